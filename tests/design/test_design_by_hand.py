"""A room, limits of rotors, and what a flight tells of numbers, by hand."""

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from infotraj.design import design as module
from infotraj.design import questions
from infotraj.design.design import Told, _can_fly, _last, _named, _now, _numbers, _rotor_inputs, largest, room_of
from infotraj.design.expected import Limits, limits
from infotraj.design.paths import DT, Room, calmer, path, placed, varied
from infotraj.design.questions import _asked, _both, open_questions
from infotraj.design.worth import Belief, Gram, Question, _factor
from infotraj.diagnosis.judge.groups import AS_PROBABLE
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.effects import effect_class
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

QUAD = load_vehicle(Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml")
T = np.arange(0.0, 20.0, 0.01)


def flight(**columns):
    return Flight(pd.DataFrame({"t": T, **{k: np.broadcast_to(v, T.shape) for k, v in columns.items()}}))


def test_a_room_stands_in_the_middle_of_what_was_flown():
    """From 1 to 5 m along x, with a jump of the position that is none of it; nowhere known, 1.5 m above the origin."""
    x = np.linspace(1.0, 5.0, len(T))
    x[7] = 900.0
    made = room_of([flight(px=x, py=-2.0, pz=np.linspace(0.5, 2.5, len(T)))], (2, 2, 1), 8.0, 1.5, 0.4, Model(QUAD))
    assert made.center == pytest.approx([3.0, -2.0, 1.5], abs=0.01)
    assert not made.free
    assert room_of([flight()], (2, 2, 1), 8.0, 1.5, 0.4, Model(QUAD)).center.tolist() == [0.0, 0.0, 1.5]


def test_the_worst_rotor_says_by_how_much_of_its_range_it_is_outside():
    bound = Limits(np.array([100.0, 100.0]), np.array([300.0, 500.0]))
    assert bound.passed(np.array([[200.0, 300.0], [320.0, 300.0]])) == pytest.approx(0.1)
    assert bound.passed(np.array([[200.0, 60.0]])) == pytest.approx(0.1)
    assert bound.passed(np.array([[280.0, 300.0]])) == pytest.approx(-0.1)


def test_rotors_without_a_limit_may_do_a_little_more_than_was_flown_and_a_tenth_of_hover_less():
    free = QUAD.model_copy(update={"rotors": tuple(r.model_copy(update={"max_speed": None}) for r in QUAD.rotors)})
    flown = [flight(**{f"cmd_rotor_{i}": 500.0 + 100.0 * i * np.sin(T) for i in range(4)})]
    bound = limits(free, flown)
    assert bound.high == pytest.approx(1.15 * (500.0 + 100.0 * np.arange(4)), rel=1e-4)
    hover = np.sqrt(QUAD.mass * QUAD.gravity / 4 / QUAD.rotors[0].thrust_coefficient)
    assert bound.low == pytest.approx(np.full(4, hover * np.sqrt(0.1)), rel=1e-3)
    assert np.isinf(limits(free, []).high).all()


def test_a_fiftieth_of_a_rotors_range_stays_in_reserve():
    bound = Limits(np.full(4, 100.0), np.full(4, 300.0))

    def inputs(value):
        return flight(**{f"cmd_rotor_{i}": value for i in range(4)})

    assert _can_fly(Model(QUAD), inputs(290.0), bound)
    assert not _can_fly(Model(QUAD), inputs(298.0), bound)
    assert _rotor_inputs(inputs(7.0)).shape == (len(T), 4)


def test_a_motion_is_scaled_to_its_speed_and_its_lean():
    t = DT * np.arange(801)
    sway = np.outer(np.sin(2.0 * t), [3.0, 0.0, 0.0])
    for speed, tilt, share in ((1.5, 1.0, 1.5 / 6.0), (50.0, 0.2, 9.81 * np.tan(0.2) / 12.0)):
        room = Room(np.full(3, 9.0), np.array([1.0, 0.0, 1.5]), 8.0, speed, tilt, False)
        made = placed(room, t, sway, 0.0 * t, 0.0 * t, 0.0 * t)
        np.testing.assert_allclose(made.position - room.center, share * sway, atol=2e-3)
    up = placed(room, t, sway[:, [1, 2, 0]], 0.0 * t, 0.0 * t, 0.0 * t)
    assert np.abs(np.gradient(np.gradient(up.position[:, 2], DT), DT)).max() <= 0.5 * 9.81 * 1.01


def test_a_slanted_motion_is_as_fast_as_is_allowed_and_not_each_of_its_axes():
    """3, 4 and 0 m of a sine of 2 rad/s are 10 m/s together: at 1.5 m/s it is 0.15 times as large."""
    t = DT * np.arange(801)
    sway = np.outer(np.sin(2.0 * t), [3.0, 4.0, 0.0])
    room = Room(np.full(3, 9.0), np.array([1.0, 0.0, 1.5]), 8.0, 1.5, 1.0, False)
    made = placed(room, t, sway, 0.0 * t, 0.0 * t, 0.0 * t)
    np.testing.assert_allclose(made.position - room.center, 0.15 * sway, atol=2e-3)


def test_genes_are_moved_within_their_range_and_calmer_ones_are_smaller():
    rng = np.random.default_rng(0)
    genes = rng.random(28)
    moved = np.stack([varied(genes, 0.12, rng) for _ in range(400)])
    assert moved.min() >= 0.0
    assert moved.max() <= 1.0
    inner = (genes > 0.4) & (genes < 0.6)
    assert moved[:, inner].std(axis=0) == pytest.approx(0.12, rel=0.2)
    room = Room(np.full(3, 2.0), np.zeros(3), 8.0, 50.0, 1.4, False)
    whole, half = path(room, genes).position, path(room, calmer(genes, 0.5)).position
    np.testing.assert_allclose(half, 0.5 * whole, atol=1e-9)


def test_the_largest_share_of_a_motion_is_the_first_that_rotors_can_fly(monkeypatch):
    """Of 1, 0.8, 0.64, 0.512 .. with rotors that can fly three fifths of it."""
    monkeypatch.setattr(module, "expected", lambda model, reference, like: reference)
    monkeypatch.setattr(module, "_can_fly", lambda model, share, bound: share <= 0.6)

    def times(factor) -> Any:
        return lambda share: factor * share

    assert largest(Model(QUAD), times(1.0), [flight()]) == pytest.approx(0.8**3)
    with pytest.raises(InputError, match="no motion"):
        largest(Model(QUAD), times(9.0), [flight()])


def test_what_is_asked_is_said_with_axis_and_unit():
    drag, mass = effect_class("linear_drag").parameters[0], effect_class("mass_offset").parameters[0]
    factor = effect_class("thrust_scale").parameters[0]
    said = [_named("linear_drag", drag, 1), _named("mass_offset", mass, 0), _named("thrust_scale", factor, 0)]
    assert said == ["linear_drag.d y, N s/m", "mass_offset.dm, kg", "thrust_scale.factor"]
    odds = [
        _now(SimpleNamespace(question=SimpleNamespace(odds=x))) for x in (-AS_PROBABLE, 0.9 * AS_PROBABLE, AS_PROBABLE)
    ]
    assert odds == [1.0, 0.0, 1.0]
    assert Told("x").now is None
    last = _last(SimpleNamespace(search=SimpleNamespace(observation=_Two(("a", "b"), (1, 2)))))
    assert (last.samples, last.transforms) == (("b",), (2,))


@dataclass(frozen=True)
class _Two:
    """As much of an observation as `_last` reads."""

    samples: tuple
    transforms: tuple


def belief(covariance, slope=1.0):
    columns = [
        SimpleNamespace(candidate=SimpleNamespace(label="a"), place=i, scale=-0.5, slope=slope)
        for i in range(len(covariance))
    ]
    fit = SimpleNamespace(linear=SimpleNamespace(columns=columns))
    return Belief(fit, tuple(range(len(covariance))), np.asarray(covariance))


def test_a_flight_narrows_numbers_as_bayes_has_it():
    """Precisions add, tempered by the spread; errors are in the numbers' own units."""
    rng = np.random.default_rng(0)
    root, x = rng.standard_normal((2, 2)), rng.standard_normal((9, 2))
    covariance = root @ root.T + 0.1 * np.eye(2)
    joint = np.column_stack([x, np.zeros(9)])
    question = Question(belief(covariance, slope=3.0), None, spread=2.0)
    now, after, places = question.errors_after(Gram(joint.T @ joint), "a")
    narrowed = np.linalg.inv(np.linalg.inv(covariance) + x.T @ x / 2.0)
    assert now == pytest.approx(0.5 * 3.0 * np.sqrt(np.diag(covariance)))
    assert after == pytest.approx(0.5 * 3.0 * np.sqrt(np.diag(narrowed)), rel=1e-6)
    assert places == [0, 1]
    told = question.information(Gram(joint.T @ joint))
    assert told == pytest.approx(0.5 * np.log(np.linalg.det(covariance) / np.linalg.det(narrowed)), rel=1e-6)
    np.testing.assert_allclose(_factor(covariance) @ _factor(covariance).T, covariance, atol=1e-6)


def fit_of(score):
    return SimpleNamespace(solution=SimpleNamespace(score=score))


@pytest.mark.parametrize(
    ("score", "said", "odds"), [(4.0, False, 2.0), (8.0, False, 0.0), (8.0, True, 4.0), (-8.0, True, -4.0)]
)
def test_odds_that_would_pass_without_a_verdict_count_as_even(monkeypatch, score, said, odds):
    """Tempered by a scatter of two."""
    monkeypatch.setattr(questions, "overdispersion", lambda fit: (2.0, None))
    monkeypatch.setattr(questions, "belief", lambda fit: fit)
    made = _asked(fit_of(score), fit_of(0.0), "a", "b", said=said)
    assert made.question.odds == odds
    assert made.fitted == score / 2.0
    assert made.words == "a from b"


@pytest.mark.parametrize(("lost", "straight"), [(5.0, False), (7.0, True)])
def test_fits_that_lose_more_than_odds_of_a_verdict_by_settling_are_not_compared(monkeypatch, lost, straight):
    monkeypatch.setattr(questions, "overdispersion", lambda fit: (2.0, None))

    def fitted(labels, like, rounds=None):
        return fit_of(100.0 if rounds == 0 else 100.0 - lost)

    found = SimpleNamespace(search=SimpleNamespace(fitted=fitted), whole=SimpleNamespace(labels=("c",)))
    fits, one = _both(found, [["a"], ["b"]])
    assert one == straight
    assert [f.solution.score for f in fits] == [100.0 if straight else 100.0 - lost] * 2


def test_a_number_is_known_to_a_share_of_what_it_does_not_of_what_it_is():
    """A factor of 0.8 that is known to 0.05 does -0.2: it is known to a quarter of it."""
    cls = effect_class("thrust_scale")
    candidate = Candidate(cls, tuple(cls.parameters), ())
    linear = SimpleNamespace(columns=[SimpleNamespace(candidate=candidate)], observation=SimpleNamespace(vehicle=QUAD))
    first = SimpleNamespace(
        fit=SimpleNamespace(labels=("thrust_scale",), linear=linear),
        members=[SimpleNamespace(candidate=candidate, effect=cls(factor=0.8))],
    )
    question: Any = SimpleNamespace(
        first=first, errors_after=lambda gram, label: (np.array([0.05]), np.array([gram]), [0])
    )
    gram: Any = 0.01
    again: Any = 0.02
    (told,) = _numbers(question, gram, again, ("thrust_scale",))
    assert told.shares_now == pytest.approx((0.25,))
    assert (told.errors_now, told.errors_again, told.errors_after) == ((0.05,), (0.02,), (0.01,))


def test_no_flight_is_designed_to_tell_a_mass_from_a_thrust(monkeypatch):
    """A scale does. What else stands in their group is asked."""
    monkeypatch.setattr(questions, "separated", lambda found, a, b: (a, b))

    def asked(*group):
        findings = [SimpleNamespace(verdict="Not separable", group=group, evidence=None)]
        return open_questions(SimpleNamespace(findings=findings, whole=SimpleNamespace(labels=())))

    assert asked("mass_offset", "thrust_scale") == []
    # What pairs lose shows where they turn.
    assert asked("mass_offset", "thrust_scale", "coaxial_loss") == [("thrust_scale", "coaxial_loss")]
    assert asked("mass_offset", "thrust_scale", "axial_inflow") == [
        ("mass_offset", "axial_inflow"), ("thrust_scale", "axial_inflow")
    ]  # fmt: skip
