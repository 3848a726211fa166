"""Effects beside a vehicle file that is wrong: what is off in the file is not named, and what is missing is.

Flights of the exact simulation, which shares no code with the library.
"""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.gates import refusal
from infotraj.diagnosis.judge.evidence import any_of
from infotraj.diagnosis.judge.numbers import FileNumber
from infotraj.diagnosis.linear.candidates import Candidate, places, raw, read, slopes, written
from infotraj.diagnosis.report.following import next_command
from infotraj.diagnosis.report.steps import given_groups
from infotraj.diagnosis.report.summary import as_dict, as_text, sentence
from infotraj.diagnosis.select.prior import Scales
from infotraj.effects import catalogue
from infotraj.experiment.hidden.file_profiles import wrong_file
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

FILE = Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml"
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.001, "velocity": 0.005}

OVER_MASS = "thrust of all rotors over mass, factor"


def diagnosed(hidden, wrong, seconds=10.0, seed=40):
    """The answer on two flights with `hidden` effects, for a file that `wrong` makes of the true one."""
    true = yaml.safe_load(FILE.read_text())
    measured = [f"rotor_{i}" for i in range(4)]
    tables = [fly(true, hidden, seconds=seconds, seed=seed + k, noise=NOISE).drop(columns=measured) for k in range(2)]
    return diagnose(Model(wrong(load_vehicle(FILE))), [Flight(t, {}) for t in tables])


def moved(by, thrust=(1.0, 1.0, 1.0, 1.0), mass=1.0):
    """A file whose rotors are `by` (m) from where they are, with other thrusts and another mass."""

    def wrong(vehicle):
        rotors = [
            r.model_copy(
                update={
                    "position": tuple(np.add(r.position, by).tolist()),
                    "thrust_coefficient": r.thrust_coefficient * k,
                }
            )
            for r, k in zip(vehicle.rotors, thrust, strict=True)
        ]
        return vehicle.model_copy(update={"rotors": tuple(rotors), "mass": vehicle.mass * mass})

    return wrong


def rough_file(vehicle):
    """A file that is wrong by 3 %, and its mass by 3 % more."""
    file = wrong_file(vehicle, "3%", np.random.default_rng(3))
    return file.model_copy(update={"mass": file.mass * 0.97})


def thrust_over_mass(vehicle):
    """Of all rotors together."""
    return sum(r.thrust_coefficient for r in vehicle.rotors) / vehicle.mass


RATIO = thrust_over_mass(load_vehicle(FILE)) / thrust_over_mass(rough_file(load_vehicle(FILE)))


@pytest.mark.long
def test_rotors_that_are_elsewhere_than_the_file_says_make_no_name_beside_their_drag():
    found = diagnosed({"rotor_drag": {"k": 4e-5}}, moved((0.004, -0.004, 0.008), (1.05, 0.97, 1.02, 0.94)))
    assert found.supported == ("rotor_drag",)
    assert found.finding("rotor_drag").parameters["k"] == pytest.approx(4e-5, rel=0.1)


def error_elsewhere(model, hidden):
    """The equation error of a model on a flight that it was not fitted to (6,)."""
    true = yaml.safe_load(FILE.read_text())
    table = fly(true, hidden, seconds=10.0, seed=70, noise=NOISE).drop(columns=[f"rotor_{i}" for i in range(4)])
    return refusal.errors(model, [Flight(table, {})], None, None).rmse


@pytest.mark.long
@pytest.mark.parametrize("off", [False, True])
def test_thrust_over_mass_is_corrected_in_the_model_beside_what_is_named(off):
    """With an exact file nothing is corrected; with one that is off its ratio and the drag are told, and only the drag
    is named."""
    hidden = {"linear_drag": {"d": [0.25, 0.2, 0.3]}}
    found = diagnosed(hidden, rough_file if off else lambda vehicle: vehicle)
    assert found.supported == ("linear_drag",)
    assert bool(found.beside) == off
    numbers = {e.name: e.values for e in found.model.effects}
    assert numbers["linear_drag"]["d"][:2] == pytest.approx([0.25, 0.2], rel=0.1)
    given, diagnosed_ = (error_elsewhere(m, hidden) for m in (Model(found.model.vehicle), found.model))
    assert diagnosed_[2] < 0.5 * given[2]
    if off:
        name = found.beside[0].split()[0]
        mass = found.model.vehicle.mass
        rotors = found.model.vehicle.rotors
        thrust = np.array([r.thrust_coefficient for r in rotors])
        for e in found.model.effects:
            if e.name in ("rotor_effectiveness", "thrust_scale"):
                thrust[e.values.get("rotor", slice(None))] *= e.values["factor"]
        ratio = thrust.sum() / sum(r.thrust_coefficient for r in rotors)
        ratio *= mass / (mass + numbers.get("mass_offset", {"dm": 0.0})["dm"])
        assert ratio == pytest.approx(RATIO, abs=0.01)
        assert name in [e["name"] for e in as_dict(found)["corrected"]]
        corrects = rf"the new model corrects the file, beside what is named:\s.*{name}"
        assert re.search(corrects, as_text(found), re.DOTALL)


@pytest.mark.long
def test_what_the_file_was_off_by_is_left_behind_where_it_is_taken_as_it_is():
    found = diagnosed({"linear_drag": {"d": [0.25, 0.2, 0.3]}}, rough_file)
    linear = found.whole.linear
    assert len(linear.point) > 5
    made = found.search.fitted(["linear_drag"], found.whole, Scales(0.0), 4)
    assert [m.candidate.name for m in made.linear.point] == ["linear_drag"]
    (member,) = made.members
    # Torques, on which the file is off, do not decide about it.
    assert member.effect.d[:2] == pytest.approx([0.25, 0.2], rel=0.1)


@pytest.mark.long
def test_a_load_is_found_beside_a_wrong_file():
    hidden = {"suspended_load": {"mass": 0.08, "length": 0.5}}
    wrong = moved((0.002, 0.002, 0.0), (1.03, 0.97, 1.01, 0.96), mass=0.97)
    found = diagnosed(hidden, wrong, seconds=16.0, seed=41)
    assert found.supported == ("suspended_load",)
    assert found.finding("suspended_load").parameters["length"] == pytest.approx(0.5, rel=0.02)


@pytest.mark.long
def test_the_thrust_over_the_mass_is_told_where_neither_is_told_alone():
    found = diagnosed({}, rough_file)
    assert found.supported == ()
    (ratio,) = [n for n in found.file if n.name == OVER_MASS]
    assert ratio.value == pytest.approx(RATIO, abs=0.005)
    assert ratio.standard_error < 0.005
    assert not any(n.name == "mass" for n in found.file)
    assert "the numbers of your vehicle file make most of the error: corrected, " in sentence(found)


@pytest.mark.long
def test_a_millimetre_beside_the_middle_of_the_rotors_is_no_place_of_the_drag():
    """Rotors that are elsewhere look like another centre of mass, beside which the drag acts."""
    found = diagnosed({"linear_drag": {"d": [0.25, 0.2, 0.3]}}, moved((0.001, -0.0015, 0.0)))
    assert "linear_drag" in found.supported
    assert "pressure_centre" not in found.supported
    assert any(n.name.startswith("where the body's drag acts") for n in found.file)


@pytest.mark.long
def test_what_is_large_and_out_of_line_in_the_file_is_in_the_sentence_and_an_axis_that_gets_worse_in_the_text():
    found = diagnosed({"linear_drag": {"d": [0.25, 0.2, 0.3]}}, rough_file)
    large = FileNumber(OVER_MASS, 1.0, 0.9, 0.01, False, takes=0.9)
    others = (FileNumber("clock of the sensors, later by", 0.0, 0.01, 0.001, False, "s"), replace(large, ordinary=True))
    told = replace(found, file=(large, *others), after=replace(found.after, rmse=2.0 * found.before.rmse))
    assert f"; your vehicle file is out of line: {OVER_MASS} 0.9" in sentence(told)
    assert "clock" not in sentence(told)
    larger = replace(large, name="a force", takes=0.95)
    assert f"out of line: a force 0.9 and {OVER_MASS} 0.9" in sentence(replace(told, file=(large, larger)))
    assert "out of line" not in sentence(replace(told, file=others))
    # What is out of line comes first: of the others none does.
    beside = replace(
        found, beside=("com_offset", "mass_offset"), after=replace(found.after, rmse=0.1 * found.before.rmse)
    )
    usual = FileNumber("center_of_mass.z", 0.0, 0.01, 0.001, True, "m", takes=0.8, label="com_offset", on=("ty",))
    assert ", first of all center_of_mass.z 0.01 m" in sentence(replace(beside, file=(usual,)))
    assert "first of all" not in sentence(replace(beside, file=(usual, large)))
    assert "fx is worse with the new model" in as_text(told)
    assert "is worse with the new model" not in as_text(found)
    doubted = (replace(large, doubt="why not"),) * 2
    assert f"in doubt: {OVER_MASS}, {OVER_MASS} (why not)" in as_text(replace(found, file=doubted))


def test_an_effect_is_no_surer_than_it_is_with_what_it_needs_beside_it():
    """Without one of the two the other is worth nothing; without both it is 3 nats less."""
    nats = {(0, 1): 0.0, (0,): -9.0, (1,): -8.0, (): -3.0}
    made = SimpleNamespace(log_probability=lambda sets: np.array([nats[tuple(sorted(s))] for s in sets]))
    assert any_of(made, [1], [0], 1.0) - any_of(made, [1], [], 1.0) == pytest.approx(3.0, abs=0.01)


@pytest.mark.long
def test_no_file_is_taken_for_granted():
    """Of two file profiles the better counts for the set with an effect and for the one without."""
    whole = diagnosed({"linear_drag": {"d": [0.25, 0.2, 0.3]}}, rough_file).whole
    sets = [whole.chosen, ()]
    scores = np.array([whole.linear.scorer(whole.scales.times(f)).scores(sets) for f in (1.0, 1 / 3)])
    assert np.all(whole.log_probability(sets) >= np.logaddexp.reduce(scores, axis=0) - 1e-9)
    assert whole.log_probability(sets)[0] - whole.log_probability(sets)[1] > 20.0


@pytest.mark.parametrize("name", ["mass_offset", "inertia_error", "thrust_scale", "rotor_effectiveness"])
def test_a_number_is_as_far_from_its_double_as_from_its_half(name):
    vehicle, cls = load_vehicle(FILE), catalogue()[name]
    candidate = Candidate(
        cls, tuple(p for p in cls.parameters if not p.index), (("rotor", 0),) if cls.repeatable else ()
    )
    at = [replace(p, low=-np.inf, high=np.inf) for p in places(candidate, vehicle)]
    whole = np.array([p.whole for p in at])
    absent = np.array([p.absent for p in at])
    above, below = ([p.coordinate(a + w * x) for p, a, w in zip(at, absent, whole, strict=True)] for x in (0.25, -0.2))
    assert np.allclose(np.subtract(above, absent), -np.subtract(below, absent))
    effect = written(candidate, at, np.array(above))
    assert np.allclose(raw(effect, at), absent + 0.25 * whole)
    assert np.allclose(read(effect, at), above)
    assert np.allclose(slopes(effect, at), 1.25)


def test_a_number_that_adds_to_nothing_is_its_own_coordinate():
    vehicle, cls = load_vehicle(FILE), catalogue()["com_offset"]
    at = places(Candidate(cls, cls.parameters), vehicle)
    effect = cls(r=[0.01, -0.02, 0.005])
    assert np.array_equal(read(effect, at), [0.01, -0.02, 0.005])
    assert np.array_equal(slopes(effect, at), np.ones(3))


def test_a_file_that_is_off_by_ten_percent_is_corrected_and_nothing_is_named():
    """No effect is missing, so none is named; what the flights show of the file stands in the model that is given."""
    found = diagnosed({}, lambda vehicle: wrong_file(vehicle, "10%", np.random.default_rng(6)))
    assert found.supported == ()
    assert found.beside
    given, corrected = (error_elsewhere(m, {}) for m in (Model(found.model.vehicle), found.model))
    assert corrected[2] < 0.5 * given[2]
    assert np.all(corrected < 1.1 * given)
    assert "no effect is named; the new model corrects the file:\n" in as_text(found)
    factors = [e.values["factor"] for e in found.model.effects if e.name == "rotor_effectiveness"]
    assert f"  rotor_effectiveness (0 1 2 3) factor={' '.join(f'{x:.3g}' for x in factors)}\n" in as_text(found)
    assert as_text(found).count("one may stand for another") == 1
    assert [e["name"] for e in as_dict(found)["corrected"]] == [e.name for e in found.model.effects]
    (group,) = given_groups(found)
    assert sorted(group) == sorted(m.candidate.label for m in found.final.members)
    assert "--save-model" in next_command(found, FILE, None)


@pytest.mark.long
@pytest.mark.parametrize("seed", [2, 4])
def test_a_file_of_three_percent_is_corrected_with_all_of_its_numbers(seed):
    """Torques may be off for sure where no number is that explains them: those alone that are sure left a tenth."""
    hidden = {"linear_drag": {"d": [0.25, 0.2, 0.3]}}
    found = diagnosed(hidden, lambda vehicle: wrong_file(vehicle, "3%", np.random.default_rng(seed)))
    assert found.supported == ("linear_drag",)
    given, corrected = (error_elsewhere(m, hidden) for m in (Model(found.model.vehicle), found.model))
    assert np.all(corrected[:5] < 0.1 * given[:5])


@pytest.mark.long
@pytest.mark.parametrize(("force", "bias"), [(0.0, 0.04), (0.03, 0.0)])
def test_the_bias_of_an_accelerometer_is_no_steady_force(force, bias):
    """It looks like one to who measures forces with it; one that is there, the path shows, too."""
    true = yaml.safe_load(FILE.read_text())
    hidden = {"linear_drag": {"d": [0.25, 0.2, 0.3]}} | ({"steady_force": {"f": [force, 0.0, 0.0]}} if force else {})
    flights = []
    for seed in (50, 51):
        table = fly(true, hidden, seconds=10.0, seed=seed, noise=NOISE)
        table["ax"] += bias
        flights.append(Flight(table.drop(columns=[f"rotor_{i}" for i in range(4)]), {}))
    found = diagnose(Model(load_vehicle(FILE)), flights)
    assert "linear_drag" in found.supported
    assert ("steady_force" in {e.name for e in found.model.effects}) == bool(force)
    assert ("steady_force" in found.supported) == bool(force)
    if bias:
        told = found.finding("accelerometer_bias")
        assert told.parameters["b"][0] == pytest.approx(bias, abs=0.01)


@pytest.mark.long
def test_beside_a_file_that_whole_steps_do_not_mend_the_effect_is_found():
    """With columns of a place that was left the model did not come to its numbers, and nothing could be named."""
    found = diagnosed(
        {"linear_drag": {"d": [0.05, 0.06, 0.04]}}, lambda vehicle: wrong_file(vehicle, "10%", np.random.default_rng(8))
    )
    assert found.supported == ("linear_drag",)
    assert found.finding("linear_drag").parameters["d"][:2] == pytest.approx([0.05, 0.06], rel=0.1)
    assert np.all(found.after.rmse < 0.3 * found.before.rmse)
    rotors = [e.values["rotor"] for e in found.model.effects if e.name == "rotor_effectiveness"]
    assert rotors
    corrected = [e["parameters"]["rotor"] for e in as_dict(found)["corrected"] if e["name"] == "rotor_effectiveness"]
    assert corrected == rotors
    assert f"rotor_effectiveness ({' '.join(map(str, sorted(rotors)))})" in as_text(found)


@pytest.mark.long
@pytest.mark.parametrize("hidden", [{}, {"linear_drag": {"d": [0.25, 0.2, 0.3]}}])
def test_a_lag_that_is_too_long_in_the_file_is_corrected_and_not_named(hidden):
    """A lag that is missing is longer; what corrects a file may be shorter, too."""

    def slower(vehicle):
        rotors = [r.model_copy(update={"time_constant": 1.6 * r.time_constant}) for r in vehicle.rotors]
        return vehicle.model_copy(update={"rotors": tuple(rotors)})

    found = diagnosed(hidden, slower)
    assert found.supported == tuple(hidden)
    assert "rotor_lag" in found.beside
    (lag,) = [e.extra_time_constant for e in found.model.effects if e.name == "rotor_lag"]
    true = load_vehicle(FILE).rotors[0].time_constant
    assert lag == pytest.approx(-0.6 * true, rel=0.05)
    given, corrected = (error_elsewhere(m, hidden) for m in (Model(found.model.vehicle), found.model))
    assert np.all(corrected[2:5] < 0.2 * given[2:5])


@pytest.mark.long
def test_a_lag_that_hides_behind_a_delay_is_found_together_with_it():
    """One after the other neither moves: with the lag of the file the delay is 24 ms, and a longer lag brings nothing
    beside it. A lag that is half as long again as in a file wrong by 3 % is out of line with it."""

    def faster(vehicle):
        file = wrong_file(vehicle, "3%", np.random.default_rng(11))
        rotors = [r.model_copy(update={"time_constant": 0.02}) for r in file.rotors]
        return file.model_copy(update={"rotors": tuple(rotors)})

    hidden = {"actuation_delay": {"delay": 0.014}}
    found = diagnosed(hidden, faster)
    assert found.supported == ("actuation_delay", "rotor_lag")
    assert "com_offset" in found.beside
    numbers = {e.name: e.values for e in found.model.effects}
    assert numbers["actuation_delay"]["delay"] == pytest.approx(0.014, abs=0.001)
    assert numbers["rotor_lag"]["extra_time_constant"] == pytest.approx(0.01, abs=0.002)
    given, corrected = (error_elsewhere(m, hidden) for m in (Model(found.model.vehicle), found.model))
    assert np.all(corrected[2:5] < 0.1 * given[2:5])


@pytest.mark.long
def test_where_no_velocity_is_logged_the_position_shows_that_a_force_is_there():
    """Beside a file that is wrong by 10 % it is not named; what the path shows corrects the model."""
    true = yaml.safe_load(FILE.read_text())
    hidden = {"steady_force": {"f": [0.15, -0.1, 0.0]}}
    columns = ["vx", "vy", "vz", *(f"rotor_{i}" for i in range(4))]
    flights = [
        Flight(fly(true, hidden, seconds=10.0, seed=seed, noise=NOISE).drop(columns=columns), {}) for seed in (50, 51)
    ]
    found = diagnose(Model(wrong_file(load_vehicle(FILE), "10%", np.random.default_rng(6))), flights)
    assert found.supported == ()
    assert "steady_force" in found.beside
    assert any(n.name.startswith("level of the world frame") for n in found.file)
    (force,) = [e.f for e in found.model.effects if e.name == "steady_force"]
    assert force[:2] == pytest.approx([0.15, -0.1], abs=0.03)


@pytest.mark.long
def test_a_filter_of_the_sensors_is_not_told_to_be_a_clock_alone():
    """What is slow is shifted alike by both; from a model that holds the one the other was judged by a derivative."""
    found = diagnosed({"sensor_lag": {"time_constant": 0.0085}}, rough_file, seconds=16.0)
    named = {n for s in found.supported for n in found.finding(s).group}
    assert "sensor_lag" in named
    assert named <= {"sensor_lag", "time_offset"}
