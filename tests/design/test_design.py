"""The next flight: motions within a room, what the model needs for them, and what they would tell."""

import functools
import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from exact_simulation import fly
from scipy.stats import multivariate_normal

from infotraj.cli import cli
from infotraj.design.design import Design, Told, _as_read, design, room_of
from infotraj.design.expected import Limits, expected, limits
from infotraj.design.inputs import commands, own_inputs, stand_in
from infotraj.design.paths import Room, calmer, drawn, path, varied
from infotraj.design.questions import determined, open_questions, separated
from infotraj.design.report import as_dict, as_text, following
from infotraj.design.simulation import Simulated, _step, simulated
from infotraj.design.worth import Belief, Gram, Question
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.judge.groups import AS_PROBABLE
from infotraj.effects import effect_class
from infotraj.effects.channels import from_velocity
from infotraj.errors import InputError, UsageError
from infotraj.flight import Flight, sha256
from infotraj.models import Model
from infotraj.models.instant import Instant
from infotraj.report.designed import beside, read_design
from infotraj.trajectories.reference import read_reference
from infotraj.vehicle import load_vehicle

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"
QUADROTOR, OMAV = (load_vehicle(VEHICLES / f"{name}.yaml") for name in ("quadrotor", "omav"))
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.002, "velocity": 0.01}


def room(free=False, size=(2.0, 1.0, 0.6), seconds=8.0):
    return Room(np.array(size), np.array([0.3, -0.2, 1.5]), seconds, 1.5, 0.4, free)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("free", [False, True])
def test_a_motion_stays_in_its_room_and_begins_and_ends_at_rest(seed, free):
    r = room(free)
    genes = drawn(r, np.random.default_rng(seed))
    made = path(r, genes)
    away = np.abs(made.position - r.center)
    assert (away <= r.size / 2 + 1e-9).all()
    assert away.max() > 0.01
    assert np.linalg.norm(made.velocity, axis=1).max() <= 1.05 * r.speed
    up = 1 - 2 * (made.attitude[:, 1] ** 2 + made.attitude[:, 2] ** 2)
    assert up.min() >= np.cos(np.sqrt(2) * r.tilt * 1.05)
    for k in (0, -1):
        assert np.abs(made.velocity[k]).max() < 1e-3
        assert np.abs(made.rate[k]).max() < 1e-2
    near = varied(genes, 0.1, np.random.default_rng(seed))
    assert ((near >= 0) & (near <= 1)).all()
    assert 0 < np.abs(near - genes).mean() < 0.2
    calm = path(r, calmer(genes, 0.5))
    assert np.ptp(calm.position, axis=0).max() < np.ptp(made.position, axis=0).max()


def test_inputs_of_every_kind_give_the_thrust_that_is_asked_for():
    throttle = {"input": "throttle", "thrust_polynomial": (0.1, 0.5, 7.0), "thrust_coefficient": None}
    thrust = {"input": "thrust", "thrust_coefficient": None}
    changes = [{}, {**throttle, "max_speed": None}, {**thrust, "max_speed": None}, {}]
    rotors = tuple(r.model_copy(update=c) for r, c in zip(QUADROTOR.rotors, changes, strict=True))
    mixed = QUADROTOR.model_copy(update={"rotors": rotors})
    speed = np.sqrt(2.0 / np.array([r.thrust_coefficient for r in stand_in(mixed).rotors]))
    x = own_inputs(mixed, speed[None])[0]
    assert 0.1 + 0.5 * x[1] + 7.0 * x[1] ** 2 == pytest.approx(2.0)
    assert x[2] == pytest.approx(2.0)
    assert QUADROTOR.rotors[0].thrust_coefficient * x[0] ** 2 == pytest.approx(2.0)
    wrench = load_vehicle(VEHICLES / "crazyswarm2.yaml")
    asked = np.array([[0.1, 0.2, 3.0, 0.01, 0.02, 0.03]])
    assert commands(wrench, asked)["cmd_fz"] == pytest.approx([3.0])


@pytest.mark.parametrize(
    ("vehicle", "effect", "most"), [(QUADROTOR, None, 0.25), (QUADROTOR, {"factor": 0.9}, 0.25), (OMAV, None, 0.8)]
)
def test_the_expected_flight_is_what_the_model_predicts_of_its_inputs(vehicle, effect, most):
    effects = [effect_class("thrust_scale")(**effect)] if effect else []
    model = Model(vehicle, effects)
    like = Flight(fly(yaml.safe_load((VEHICLES / f"{vehicle.name}.yaml").read_text()), {}, seconds=2.0, noise=NOISE))
    r = path(room(bool(vehicle.tilts)), drawn(room(bool(vehicle.tilts)), np.random.default_rng(1)))
    flight = expected(model, r, like)
    assert {c for c in flight.table if c.startswith("cmd_")} <= set(like.table)
    said = model.predict(flight)
    inside = slice(100, -100)
    measured = flight.get("ax", "ay", "az")[inside]
    # What lags is not inverted: an omav's arms are behind by a tenth of a second.
    np.testing.assert_allclose(said.specific_force[inside], measured, atol=most)
    assert np.abs(said.specific_force[inside] - measured).mean() < 0.2 * most


def test_rotors_are_kept_within_what_the_file_or_the_flights_say():
    bound = limits(QUADROTOR, [])
    np.testing.assert_allclose(bound.high, [r.max_speed for r in QUADROTOR.rotors])
    assert bound.passed(np.array([bound.high + 1.0])) > 0
    assert bound.passed(np.array([(bound.low + bound.high) / 2])) < 0
    assert Limits(np.zeros(0), np.zeros(0)).passed(np.zeros((0, 0))) == 0.0


def belief(count, rng, keys):
    columns = [SimpleNamespace(candidate=SimpleNamespace(label=a), place=b, scale=2.0, slope=1.0) for a, b in keys]
    root = rng.standard_normal((count, count))
    fit = SimpleNamespace(linear=SimpleNamespace(columns=columns))
    return Belief(fit, tuple(range(count)), 0.3 * root @ root.T / count)


@pytest.mark.parametrize("odds", [0.4, 2.0, -2.0])
def test_how_often_two_explanations_are_told_apart_is_what_drawn_data_say(odds):
    rng = np.random.default_rng(5)
    rows = 12
    first, second = belief(2, rng, [("file", 0), ("a", 0)]), belief(2, rng, [("file", 0), ("b", 0)])
    columns, apart = rng.standard_normal((rows, 3)), 1.6 * rng.standard_normal(rows)
    joint = np.column_stack([columns, apart])
    question = Question(first, second, odds=odds, spread=1.3)
    told, least = question.told_apart(Gram(joint.T @ joint), np.random.default_rng(0))

    covariances = []
    for own, at in ((first, [0, 1]), (second, [0, 2])):
        own_columns = columns[:, at]
        covariances.append(np.eye(rows) + own_columns @ own.covariance @ own_columns.T)
    laws = [multivariate_normal(m, c) for m, c in zip((np.zeros(rows), apart), covariances, strict=True)]
    draws = [law.rvs(4000, random_state=rng) for law in laws]
    gains = [laws[k].logpdf(draws[k]) - laws[1 - k].logpdf(draws[k]) for k in (0, 1)]
    likely = 1 / (1 + np.exp(-odds))
    forth, back = gains[0] / 1.3, gains[1] / 1.3
    truth = likely * np.mean(odds + forth >= AS_PROBABLE) + (1 - likely) * np.mean(back - odds >= AS_PROBABLE)
    assert told == pytest.approx(truth, abs=0.06)
    assert least == pytest.approx(min(forth.mean(), back.mean()), rel=0.15)


def test_a_number_is_narrowed_as_the_information_says():
    rng = np.random.default_rng(6)
    own = belief(3, rng, [("file", 0), ("a", 0), ("a", 1)])
    columns = rng.standard_normal((20, 3))
    gram = np.zeros((4, 4))
    gram[:3, :3] = columns.T @ columns
    question = Question(own, None, spread=1.7)
    now, after, at = question.errors_after(Gram(gram), "a")
    expect = np.linalg.inv(np.linalg.inv(own.covariance) + columns.T @ columns / 1.7)
    np.testing.assert_allclose(after, 2.0 * np.sqrt(np.diag(expect))[1:], rtol=1e-4)
    np.testing.assert_allclose(now, 2.0 * np.sqrt(np.diag(own.covariance))[1:], rtol=1e-6)
    assert at == [0, 1]
    # What is learned of all numbers: by how much their joint density is narrower, in nats.
    volumes = [np.linalg.slogdet(c)[1] for c in (own.covariance, expect)]
    assert question.information(Gram(gram)) == pytest.approx(0.5 * (volumes[0] - volumes[1]), rel=1e-4)


@functools.cache
def flown():
    """A drag on a quadrotor, and what is found on two short flights."""
    content = yaml.safe_load((VEHICLES / "quadrotor.yaml").read_text())
    hidden = {"linear_drag": {"d": [0.12, 0.12, 0.1]}}
    tables = [fly(content, hidden, seconds=8.0, seed=k, noise=NOISE) for k in (0, 1)]
    flights = [Flight(t, {"source": f"{k}.parquet"}) for k, t in enumerate(tables)]
    return diagnose(Model(QUADROTOR), flights), flights


@pytest.mark.long
def test_a_design_tells_more_than_a_calm_flight_and_stays_in_its_limits():
    found, flights = flown()
    r = room_of(flights, (2.0, 2.0, 1.0), 8.0, 2.0, 0.4, Model(QUADROTOR))
    made = design(found, flights, r, separate=("linear_drag", "quadratic_drag"), candidates=6)
    (told,) = made.told
    assert told.words == "linear_drag from quadratic_drag"
    assert 0.0 <= told.after <= 1.0
    assert made.limits.passed(made.inputs) < 0
    inside = np.abs(made.reference.position - r.center) <= r.size / 2 + 1e-9
    assert inside.all()
    assert made.flown is not None
    assert made.flown.away(made.reference) < 1.0
    asked = separated(found, "linear_drag", "quadratic_drag").question
    shares = []
    for share in (0.1, 1.0):
        motion = path(r, calmer(drawn(r, np.random.default_rng(3)), share))
        gram = asked.gram(asked.observed(expected(Model(QUADROTOR), motion, flights[0])))
        shares.append(asked.told_apart(gram, np.random.default_rng(0))[1])
    assert shares[0] < shares[1]


@pytest.mark.long
def test_odds_that_would_pass_count_only_where_the_diagnosis_says_which():
    found, _ = flown()
    said = found.finding("linear_drag")
    assert said.verdict == "Supported"
    sure = separated(found, "linear_drag", "com_offset")
    assert sure.fitted == sure.question.odds > AS_PROBABLE
    open_still = [replace(f, verdict="Plausible") if f.name == said.name else f for f in found.findings]
    unsure = separated(replace(found, findings=tuple(open_still)), "linear_drag", "com_offset")
    assert unsure.fitted == sure.fitted
    assert unsure.question.odds == 0.0


def test_fits_that_lose_by_settling_are_compared_in_one_linearisation(monkeypatch):
    found, _ = flown()
    own = type(found.search).fitted
    assert not separated(found, "linear_drag", "quadratic_drag").question.straight

    def worse(self, labels, like, scales=None, rounds=2):
        made = own(self, labels, like, scales, rounds)
        return replace(made, solution=replace(made.solution, score=made.solution.score - (40.0 if rounds else 0.0)))

    monkeypatch.setattr(type(found.search), "fitted", worse)
    asked = separated(found, "linear_drag", "quadratic_drag")
    assert asked.question.straight
    last = replace(found.search.observation, samples=found.search.observation.samples[-1:])
    last = replace(last, transforms=last.transforms[-1:])
    straight, curved = (replace(asked.question, straight=s).gram(last).products for s in (True, False))
    assert straight[:-1, :-1] == pytest.approx(curved[:-1, :-1])
    # What the two predict differs by what their numbers say, as far as the model is linear in them.
    assert straight[-1, -1] == pytest.approx(curved[-1, -1], rel=0.1)


def test_a_flight_like_one_of_two_narrows_a_number_no_more_than_two_do():
    """The next flight's data scatter as the flown ones do, beyond the noise model."""
    found, _ = flown()
    question, label = determined(found, "linear_drag")
    assert label == "linear_drag"
    assert question.spread == overdispersion(question.first.fit)[0]
    own = question.first.fit.linear.observation
    last = replace(own, samples=own.samples[-1:], transforms=own.transforms[-1:])
    now, after, _ = question.errors_after(question.gram(last), "linear_drag")
    assert (after < now).all()
    # Two flights and one more of the same kind: at best the root of two thirds, but for how much each one tells.
    assert (after > 0.6 * now).all()


def test_names_that_are_none_and_effects_that_cannot_be_tested_are_refused():
    found, _ = flown()
    with pytest.raises(UsageError, match="no effect 'drag'"):
        separated(found, "drag", "linear_drag")
    with pytest.raises(UsageError, match="two effects"):
        separated(found, "linear_drag", "linear_drag")
    with pytest.raises(InputError, match="servo_lag cannot be tested"):
        separated(found, "linear_drag", "servo_lag")
    with pytest.raises(UsageError, match=r"linear_drag:2: the effect has no places; expected linear_drag\."):
        determined(found, "linear_drag:2")
    with pytest.raises(UsageError, match=r"rotor_effectiveness has no place 7; expected rotor_effectiveness:0 or "):
        determined(found, "rotor_effectiveness:7")
    assert len(open_questions(found)) <= 3


def test_the_simulated_body_is_integrated_to_second_order():
    acts = Instant(Model(QUADROTOR, [effect_class("linear_drag")(d=[0.5, 0.6, 0.7])]))
    start = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 2.0, -1.0, 0.5, 3.0, -2.0, 4.0])
    rotor = np.sqrt(QUADROTOR.mass * 9.81 / 4 / QUADROTOR.rotors[0].thrust_coefficient) * np.array([1.0, 1.01, 1, 0.99])
    ends = []
    for steps in (20, 40, 80):
        state = start.copy()
        for k in range(steps):
            state = _step(acts, 0.4 * k / steps, state, rotor, np.zeros(0), 0.4 / steps, 9.81)
        ends.append(state)
    coarse, fine = (np.abs(a - b).max() for a, b in pairwise(ends))
    assert 3.3 < coarse / fine < 4.7


def test_rotors_that_hardly_follow_lose_the_reference():
    r = path(room(), drawn(room(), np.random.default_rng(0)))
    slow = tuple(x.model_copy(update={"time_constant": 1.0}) for x in QUADROTOR.rotors)
    far = [
        simulated(Model(v), r, limits(QUADROTOR, [])).away(r)
        for v in (QUADROTOR, QUADROTOR.model_copy(update={"rotors": slow}))
    ]
    assert far[0] < 0.5
    assert far[1] > 1.0


def test_a_controller_that_is_lost_is_said():
    r = path(room(), drawn(room(), np.random.default_rng(0)))
    weak = Model(QUADROTOR, [effect_class("thrust_scale")(factor=0.35)])
    flown = simulated(weak, r, limits(QUADROTOR, []))
    assert flown.at_limit > 0.02 or flown.away(r) > 1.0
    assert simulated(Model(load_vehicle(VEHICLES / "crazyswarm2.yaml")), r, limits(QUADROTOR, [])) is None


def test_a_weak_rotor_does_not_lose_the_reference():
    r = path(room(), drawn(room(), np.random.default_rng(0)))
    weak = Model(QUADROTOR, [effect_class("rotor_effectiveness")(rotor=3, factor=0.8)])
    assert simulated(weak, r, limits(QUADROTOR, [])).away(r) < 0.25


@pytest.mark.long
def test_the_rotor_that_was_found_is_the_one_whose_number_is_narrowed():
    """Not the first of the name: numbers of the file beside it are of the other rotors."""
    content = yaml.safe_load((VEHICLES / "quadrotor.yaml").read_text())
    hidden = {"rotor_effectiveness": {"rotor": 3, "factor": 0.85}}
    flights = [Flight(fly(content, hidden, seconds=8.0, seed=0, noise=NOISE), {"source": "0.parquet"})]
    found = diagnose(Model(QUADROTOR), flights)
    assert found.whole.labels == ("rotor_effectiveness 3",)
    r = room_of(flights, (2.0, 2.0, 1.0), 8.0, 2.0, 0.4, Model(QUADROTOR))
    made = [
        design(found, flights, r, determine=name, candidates=3).told
        for name in ("rotor_effectiveness", "rotor_effectiveness:3")
    ]
    assert made[0] == made[1]
    assert [t.words for t in made[0]] == ["rotor_effectiveness 3"]
    assert made[0][0].errors_after < made[0][0].errors_now


def test_forces_of_the_next_flight_are_told_as_those_of_the_flown_ones():
    flight = Flight(fly(yaml.safe_load((VEHICLES / "quadrotor.yaml").read_text()), {}, seconds=1.0, noise=NOISE))
    found: Any = SimpleNamespace(by_velocity=False)
    assert not from_velocity(_as_read(found, flight))
    found.by_velocity = True
    like = _as_read(found, flight)
    motion = path(room(), drawn(room(), np.random.default_rng(0)))
    assert from_velocity(expected(Model(QUADROTOR), motion, like))
    assert not from_velocity(expected(Model(QUADROTOR), motion, flight))


def test_what_strays_in_simulation_is_not_to_be_flown(monkeypatch):
    def far(model, reference, bound):
        return Simulated(np.add(reference.position, [0.0, 0.4, 0.0]), np.zeros((len(reference.t), 4)), 0.0)

    monkeypatch.setattr("infotraj.design.design.simulated", far)
    found, flights = flown()
    made = design(found, flights, room_of(flights, (2.0, 2.0, 1.0), 8.0, 2.0, 0.4, found.model), candidates=3)
    assert "warning: in simulation it strays by 0.4 m from the reference" in as_text(made, "ref.csv")
    assert following(made, "ref.csv", "diagnose").startswith("do not fly it as it is")
    plain = replace(made, not_flown="", told=(Told("drag", 0.0, 0.5, 0.9),))
    assert following(plain, "ref.csv", "diagnose") == "fly ref.csv, then diagnose"
    assert " m from the reference at most; leave that much room around the motion\n" in as_text(plain, "ref.csv")
    # What is told already, known to better than a hundredth, or not there at all is hardly worth a flight.
    for told, says in (
        ((), "nothing is open, and nothing was found"),
        ((Told("drag", 1.0, 1.0, 1.0),), "what is asked is told already"),
        ((_narrowed(0.009),), "what was found is known to better than 1 %"),
        # Nothing is told; the last flight again tells more, or as much.
        ((Told("drag", 0.0, 0.005, 0.004),), "it tells almost nothing of what is asked; a larger --box"),
        ((_narrowed(0.3, 0.3, 0.299),), "it tells almost nothing of what is asked; a larger --box"),
        (
            (_narrowed(0.3, 0.2, 0.299),),
            "it tells almost nothing of what is asked; flying the last one again tells more",
        ),
        ((Told("drag", 0.0, 0.81, 0.68),), "it tells at most 5 % more than another flight like the last one"),
        ((_narrowed(0.3, 0.2, 0.199),), "it tells at most 5 % more than another flight like the last one"),
        ((Told("a", 1.0, 1.0, 1.0), Told("b", 0.0, 0.5, 0.5)), "it tells at most 5 % more"),
    ):
        idle = replace(plain, told=told)
        assert f"hardly worth flying for this: {says}" in as_text(idle, "ref.csv")
        assert following(idle, "ref.csv", "diagnose").startswith("if you fly it all the same, fly ref.csv")
    better = Told("a", 0.0, 0.8, 0.9), Told("b", 0.0, 0.8, 0.7)
    for told in (plain.told, (_narrowed(0.02),), (_narrowed(0.001), _narrowed(0.02)), better):
        assert "hardly worth" not in as_text(replace(plain, told=told), "ref.csv")


def _narrowed(now, again=None, after=None):
    return Told("x", None, None, None, ("x.k",), (now,), (again or now,), (after or now / 2,), (now,))


def test_a_box_smaller_than_what_is_strayed_from_it_says_what_the_room_must_leave():
    r = path(room(), drawn(room(), np.random.default_rng(0)))
    away = Simulated(np.add(r.position, [0.0, 0.1, 0.0]), np.zeros((len(r.t), 4)), 0.0)
    bound = Limits(np.zeros(0), np.zeros(0))
    for least, said in ((0.19, True), (0.21, False)):
        told = (Told("drag", 0.0, 0.5, 0.9),)
        made = Design(r, told, np.zeros((0, 0)), bound, room(size=(2.0, 1.0, least)), away, "", 3)
        warning = "warning: in simulation it strays by 0.1 m, more than half of the box's smallest side of 0.19 m"
        assert (warning in as_text(made, "ref.csv")) == said
        assert following(made, "ref.csv", "diagnose").startswith("fly ref.csv")
        numbers = as_dict(made, "ref.csv", Path("model.yaml"), [])
        assert (numbers["warning"] is not None) == said
        assert numbers["fly"]


@pytest.mark.long
def test_the_command_writes_a_reference_and_says_what_it_will_tell(tmp_path):
    _, flights = flown()
    paths = []
    for k, f in enumerate(flights):
        paths.append(str(tmp_path / f"{k}.parquet"))
        f.write(paths[-1])
    output, numbers = tmp_path / "ref.csv", tmp_path / "design.json"
    vehicle = str(VEHICLES / "quadrotor.yaml")
    asked = ["--determine", "linear_drag", "--within", "8s", "--box", "2x2x1", "--candidates", "4"]
    files = ["-o", str(output), "--json", str(numbers), "--figures", str(tmp_path)]
    ran = CliRunner().invoke(cli, ["design", vehicle, "--flown", *paths, *asked, *files])
    assert ran.exit_code == 0, ran.output
    assert all(f"linear_drag.d {axis}, N s/m: standard error" in ran.output for axis in "xyz")
    assert read_reference(output).t[-1] == pytest.approx(8.0)
    content = json.loads(numbers.read_text())
    (told,) = content["told"]
    for row in told["numbers"]:
        assert row["standard_error"]["after"] < row["standard_error"]["now"]
    for row, size in zip(told["numbers"], (0.12, 0.12, 0.1), strict=True):
        assert row["share_of_effect"] * size == pytest.approx(row["standard_error"]["now"], rel=0.2)
    assert (tmp_path / "design.png").stat().st_size > 10_000
    # The page takes it, and knows the flights by what is in them.
    read = read_design(numbers)
    same = [{"sha256": sha256(Path(p))} for p in paths]
    assert beside(read, same)["others"] == []
    assert beside(read, same[:1])["others"] == paths
    reference = read_reference(output)
    assert read["drawn"]["position"][0] == pytest.approx(reference.position[0], abs=1e-4)
    assert max(read["drawn"]["speed"]) == pytest.approx(read["greatest"]["speed"], rel=0.01)
    assert 200 < len(read["drawn"]["t"]) <= 800
    bad = CliRunner().invoke(cli, ["design", vehicle, "--flown", *paths, "--box", "2x2", "-o", str(output)])
    assert bad.exit_code == 2
    assert "no box" in bad.output
