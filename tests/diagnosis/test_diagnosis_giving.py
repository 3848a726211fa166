"""The model that is given: no axis of flights that were not fitted is predicted worse for what is named."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from given_sums import given_sums

from infotraj.diagnosis.judge import giving
from infotraj.diagnosis.judge.giving import _pruned
from infotraj.diagnosis.linear.candidates import Candidate, places
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.select.around import Column, Linear
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.prior import Scales
from infotraj.diagnosis.select.score import Choice
from infotraj.effects import catalogue
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml")
FLIGHTS = 4


@pytest.fixture(autouse=True)
def _linear(monkeypatch):
    """These fits have no flights: their sums say what is left."""

    def left(made, each):
        sums = made.linear.absent
        return sums.plain_error(np.zeros((FLIGHTS, sums.width)) if each is None else each)

    monkeypatch.setattr(giving, "left", left)


def drag_on(sizes, name="linear_drag", corrects=frozenset()):
    """A fit of an effect along x, y, z, whose number on each axis is `sizes` (axes, flights), usual sizes, in each
    flight. corrects: as a number of the file."""
    drag = catalogue()[name]
    candidate = Candidate(drag, tuple(p for p in drag.parameters if not p.index))
    rng = np.random.default_rng(0)
    gram = np.zeros((3, FLIGHTS, 4, 4))
    for a in range(3):
        for k in range(FLIGHTS):
            x = np.zeros((200, 4))
            x[:, 1 + a] = rng.standard_normal(200)
            x[:, 0] = sizes[a][k] * x[:, 1 + a] + 0.1 * rng.standard_normal(200)
            gram[a, k] = x.T @ x
    sums = given_sums(gram, np.full((3, FLIGHTS), 200.0), ("fx", "fy", "fz"))
    at = places(candidate, VEHICLE)
    columns = tuple(Column(candidate, i, p.scale, 0.0, -np.inf, np.inf) for i, p in enumerate(at))
    linear = Linear(
        SimpleNamespace(
            vehicle=VEHICLE,
            command_step=0.005,
            healthy=None,
            scatter={},
            still=frozenset(),
            base=lambda c: c.absent(VEHICLE),
        ),
        (Member(candidate, candidate.absent(VEHICLE)),),
        columns,
        (Choice(name, (0, 1, 2), 3.0),),
        (None,),
        (),
        None,
        sums,
    )
    scales = Scales(0.0)
    solution = linear.scorer(scales).solution((0,))
    return Fit(linear, (0,), replace(scales, corrects=frozenset(corrects)), solution)


def test_what_holds_on_flights_that_were_not_fitted_stays():
    fit, lost, held_back = _pruned(drag_on([[1.0] * 4, [1.1] * 4, [0.9] * 4]))
    assert not lost
    assert not held_back
    np.testing.assert_allclose(fit.solution.theta, [1.0, 1.1, 0.9], atol=0.05)


def test_a_number_on_which_flights_do_not_agree_stays_absent_and_is_said():
    fit, lost, held_back = _pruned(drag_on([[1.0] * 4, [1.1] * 4, [1.0, -0.9, 1.1, -1.0]]))
    assert not lost
    assert "d[2]" in held_back["linear_drag"]
    assert "fz is predicted worse" in held_back["linear_drag"]
    assert fit.solution.theta[2] == 0.0
    (member,) = fit.members
    assert member.effect.values["d"][2] == 0.0
    assert member.effect.values["d"][0] == pytest.approx(1.0 * fit.linear.columns[0].scale, rel=0.05)


def test_of_a_force_that_corrects_the_file_the_axis_goes_that_is_predicted_worse():
    """The level of the world takes an error off along z, and is as good as nothing along y."""
    sizes = [[1.0] * 4, [1.0, -0.9, 1.1, -1.0], [5.0] * 4]
    fit, lost, held_back = _pruned(drag_on(sizes, "steady_force", {"steady_force"}))
    assert (lost, held_back) == ({}, {})
    assert fit.solution.theta[1] == 0.0
    np.testing.assert_allclose(fit.solution.theta[[0, 2]], [1.0, 5.0], rtol=0.05)


def test_a_number_stays_without_which_the_axis_is_predicted_no_better(monkeypatch):
    """fy is predicted worse than by the model as given; without d[0] it would be worse still, whatever fx gains."""
    shares = {(): [0.5, 1.3, 1.0], (0,): [0.2, 1.6, 1.0], (1,): [0.9, 1.2, 1.0], (2,): [0.6, 1.3, 1.0]}
    monkeypatch.setattr(giving, "_acts", lambda *_: True)
    monkeypatch.setattr(giving, "_shares", lambda made, each: np.array(shares[tuple(np.flatnonzero(each[0] == 0.0))]))
    fit, lost, held_back = _pruned(drag_on([[1.0] * 4] * 3))
    assert (lost, held_back) == ({}, {})
    assert fit.solution.theta.all()
    shares[(0,)][1] = 1.2
    shares[(0, 1)] = shares[(0, 2)] = [1.0, 1.2, 1.0]
    assert "d[0]" in _pruned(drag_on([[1.0] * 4] * 3))[2]["linear_drag"]


def test_an_effect_without_a_number_left_is_lost():
    _, lost, _ = _pruned(drag_on([[1.0, -0.9, 1.1, -1.0]] * 3))
    assert "predicted worse" in lost["linear_drag"]


def with_shares(monkeypatch, shares, ends=()):
    """Fits that are known by name alone: the shares of the error of two axes that each leaves, and which end at a
    bound."""
    monkeypatch.setattr(giving, "_shares", lambda made, each=None: np.array(shares[made]))
    monkeypatch.setattr(giving, "_ends", lambda made, before: made in ends)


def search_of_names():
    """What it fits is known by what was asked of it."""
    return SimpleNamespace(fitted=lambda labels, *rest, **more: "+".join(labels))


def test_the_net_of_shares_is_their_product():
    assert giving.net(np.array([0.5, 2.0])) == pytest.approx(0.0)
    assert giving.net(np.array([0.5, 0.0, 0.5])) == pytest.approx(np.log(0.25))


def test_a_model_gains_by_errors_as_they_are_or_in_units_of_their_noise_axis_by_axis(monkeypatch):
    """What gets worse as it is has that taken off; an axis without an error says nothing."""
    shares = np.array([0.5, 1.0, 2.0, 0.0, 1.0]), np.array([1.0, 0.25, 0.5, 0.0, 0.25])
    stays = np.array([1.0, 1.0, 1.0, 0.0, 3.0])  # of the last one most is no noise
    monkeypatch.setattr(giving, "_both_shares", lambda fit: (*shares, stays))
    gain = giving.Given(cast("Any", None), {}).gain
    assert gain == pytest.approx(np.log(2.0) + np.log(4.0) + (np.log(2.0) - np.log(2.0)))


def test_of_sensors_held_against_one_another_no_error_is_told_in_units_of_its_noise(monkeypatch):
    made: Any = SimpleNamespace(
        linear=SimpleNamespace(sums=SimpleNamespace(axes=("fx", "vz", "tx", "turn x", "push z"))),
        solution=SimpleNamespace(each=np.zeros((2, 1))),
    )
    monkeypatch.setattr(giving, "left", lambda fit, each, weighted=False: np.full(5, 4.0 if each is None else 1.0))
    plain, weighted, stays = giving._both_shares(made)
    np.testing.assert_allclose(plain, 0.5)
    np.testing.assert_allclose(weighted, 0.5)
    assert stays.tolist() == [1.0, 1.0, 1.0, np.inf, np.inf]


def test_what_may_correct_the_ratio_comes_in_the_order_in_which_it_predicts(monkeypatch):
    """By more than a twentieth of one axis, and without an end at a bound."""
    shares = {
        "bare": [1.0, 1.0],
        "drag+a": [0.9, 0.9],
        "drag+b": [0.5, 1.0],
        "drag+c": [0.97, 1.0],
        "drag+d": [0.1, 1.0],
        "drag+e": [0.94, 1.0],
    }
    with_shares(monkeypatch, shares, ends=("drag+d",))
    found = giving._of_ratio(search_of_names(), None, ["drag"], "bare", list("abcde"))
    assert list(found.items()) == [("b", "drag+b"), ("a", "drag+a"), ("e", "drag+e")]
    assert giving._of_ratio(search_of_names(), None, ["drag"], "bare", []) == {}


def test_a_share_is_of_the_root_mean_square():
    fit = drag_on([[2.0] * 4, [1.0] * 4, [0.0] * 4])
    assert giving._shares(fit)[0] == pytest.approx(np.sqrt(0.01 / 4.01), rel=0.1)
    assert giving._shares(fit)[2] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(("size", "stays"), [(0.03, True), (0.05, False)])
def test_a_number_stays_that_makes_no_axis_worse_by_a_twentieth(size, stays):
    """Of sizes +-s the others' mean is a third the wrong way: (0.1^2 + (4 s / 3)^2) / (0.1^2 + s^2) is 1.06 or 1.16."""
    _, lost, held_back = _pruned(drag_on([[1.0] * 4, [1.0] * 4, [size, -size, size, -size]]))
    assert not lost
    assert bool(held_back) != stays


def test_a_number_acts_where_it_changes_a_thousandth_of_the_error_and_more():
    fit = drag_on([[1.0] * 4] * 3)
    each = fit.solution.each
    assert giving._acts(fit, each, (0,), 0)
    assert not giving._acts(fit, each, (0,), 1)
    assert not giving._acts(fit, 0.001 * each, (0,), 0)


def test_numbers_that_stay_absent_are_so_on_every_fold():
    theta, each = giving._without(np.ones(3), np.ones((4, 3)), (0, 2))
    assert theta.tolist() == [0.0, 1.0, 0.0]
    assert each.tolist() == [[0.0, 1.0, 0.0]] * 4


def test_the_reason_says_by_how_much_an_axis_is_worse():
    """Sizes of +-1 that are fitted from the three other flights: a third of each is added, noise of 0.1 is little."""
    _, _, held_back = _pruned(drag_on([[1.0] * 4, [1.1] * 4, [1.0, -1.0, 1.0, -1.0]]))
    assert "worse with it, by 33 %" in held_back["linear_drag"]


def corrected(monkeypatch, made, shares, asked=("drag",), ends=()):
    """What corrects the file beside `asked`, where a file that is so far off leaves these shares of the error of fx;
    the numbers of the file that were tried. ends: how far off files are of which a number ends at a bound."""
    tried = []

    def with_file(search, whole, labels, file, common):
        tried.append(tuple(file))
        return SimpleNamespace(labels=(*labels, *file), scales=Scales(common))

    def fitted(labels, like, scales, rounds):
        return SimpleNamespace(labels=labels, scales=scales)

    # What the kinematic axis has is no reason for anything.
    of_fit = {None: np.array([made, 1.0])}
    monkeypatch.setattr(
        giving, "_shares", lambda f: of_fit[None] if f is None else np.array([shares[f.scales.common], 1e-3])
    )
    monkeypatch.setattr(giving, "_with_file", with_file)
    monkeypatch.setattr(giving, "_ends", lambda made, before: made.scales.common in ends)
    monkeypatch.setattr(giving, "labels_of_file", lambda whole: ["mass_offset", "inertia_error", "thrust_scale"])
    sums = SimpleNamespace(axes=("fx", "turn x"))
    whole = SimpleNamespace(linear=SimpleNamespace(sums=sums), scales=Scales(1.0))
    search = SimpleNamespace(fitted=fitted, held=())
    return giving._corrected(search, whole, None, list(asked)), tried


def test_the_file_is_as_far_off_as_predicts_best_and_only_where_that_tells(monkeypatch):
    shares = {0.05: 0.9, 0.3: 0.5, 1.0: 0.4, 3.0: 0.6, 9.0: 0.7}
    found, _ = corrected(monkeypatch, 0.5, shares)
    assert found.scales.common == 1.0
    assert corrected(monkeypatch, 0.45, shares)[0] is None


def test_where_a_number_ends_at_a_bound_the_file_is_less_far_off_if_that_tells(monkeypatch):
    shares = {0.05: 0.9, 0.3: 0.7, 1.0: 0.5, 3.0: 0.4, 9.0: 0.3}
    assert corrected(monkeypatch, 1.0, shares, ends=(9.0, 3.0))[0].scales.common == 1.0
    assert corrected(monkeypatch, 0.5, shares, ends=(9.0, 3.0))[0] is None


def test_thrust_over_mass_is_said_once(monkeypatch):
    shares = dict.fromkeys((0.05, 0.3, 1.0, 3.0, 9.0), 0.1)
    _, tried = corrected(monkeypatch, 1.0, shares, ["drag", "mass_offset"])
    assert set(tried) == {("inertia_error",)}
    assert set(corrected(monkeypatch, 1.0, shares)[1]) == {("mass_offset", "inertia_error", "thrust_scale")}
