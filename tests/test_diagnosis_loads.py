"""A swinging load: its cable's length wherever a fit starts, and how sure that is, on flights of the exact simulation.

Over a whole flight the squared error has local minima beside the true length (`sharpening`), and the accelerometer's
noise moves the load that is swung along the recorded motion (`driving_noise`).
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.adding import add
from infotraj.diagnosis.candidates import Place, candidates
from infotraj.diagnosis.diagnosis import diagnose, observe
from infotraj.diagnosis.driving_noise import driving_variance, weighed, weighted
from infotraj.diagnosis.fitting import fit
from infotraj.diagnosis.horizons import best_on_grid, grid
from infotraj.diagnosis.noise import estimated, started
from infotraj.diagnosis.numbers import fitted_numbers
from infotraj.diagnosis.observation import Member
from infotraj.diagnosis.scanning import scanned
from infotraj.diagnosis.sensitivities import sensitivities
from infotraj.diagnosis.sharpening import sharp_fit
from infotraj.effects import catalogue
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

FILE = Path(__file__).parents[1] / "config/vehicles/quadrotor.yaml"
CONTENT = yaml.safe_load(FILE.read_text())
VEHICLE = load_vehicle(FILE)
NOISE = {"gyro": 0.003, "accelerometer": 0.05, "position": 0.002, "attitude": 0.001, "velocity": 0.01}


@cache
def flights(mass, length, seed):
    hidden = {"suspended_load": {"mass": mass, "length": length}} if mass else {}
    return tuple(
        Flight(fly(CONTENT, hidden, seconds=16, seed=10 * seed + k, noise=NOISE), {"source": f"{k}"}) for k in range(2)
    )


def observed(made, *effects):
    known, _ = candidates({n: catalogue()[n] for n in effects}, VEHICLE, made)
    observation = observe(Model(VEHICLE), made)
    return started(observation, sensitivities(observation, [], known).joint), known


def fitted_from(made, mass, length):
    observation, (load,) = observed(made, "suspended_load")
    return observation, fit(observation, [Member(load, load.at({"mass": mass, "length": length}))])


@pytest.mark.parametrize(("mass", "length", "start"), [(0.08, 0.5, 0.6), (0.1, 0.35, 0.45), (0.1, 2.5, 1.0)])
def test_the_length_is_found_from_a_wrong_valley(mass, length, start):
    observation, stuck = fitted_from(flights(mass, length, 1), mass, start)
    assert abs(stuck.members[0].effect.length / length - 1) > 0.15  # else this test would show nothing
    found = sharp_fit(observation, stuck)
    assert found.cost < stuck.cost
    assert found.members[0].effect.length == pytest.approx(length, rel=5e-3)


def test_the_length_is_found_where_the_fit_has_given_the_load_up():
    observation, lost = fitted_from(flights(0.1, 2.5, 2), 0.1, 0.6)
    assert lost.members[0].effect.mass < 1e-3
    found = sharp_fit(observation, lost).members[0].effect
    assert (found.mass, found.length) == (pytest.approx(0.1, rel=0.03), pytest.approx(2.5, rel=5e-3))


def test_a_fit_without_a_swing_stays_as_it_is():
    observation, known = observed(flights(0.08, 0.5, 1), "thrust_scale", "rotor_lag")
    made = fit(observation, [Member(c, c.absent(VEHICLE)) for c in known])
    assert sharp_fit(observation, made) is made
    assert weighed(observation, made.members) is observation
    assert (driving_variance(observation, made) == 0.0).all()


def test_standard_errors_hold_the_noise_that_drives_the_load():
    without, with_it = [], []
    for seed in range(3):
        observation, made = fitted_from(flights(0.1, 0.8, seed), 0.1, 0.8)
        made = sharp_fit(observation, made)
        miss = abs(made.members[0].effect.length - 0.8)
        without.append(miss / fitted_numbers(made, VEHICLE)[0]["length"])
        more = driving_variance(observation, made)
        with_it.append(miss / fitted_numbers(made, VEHICLE, more=more)[0]["length"])
    assert max(without) > 3.0
    assert max(with_it) < 2.5
    assert made.members[0].effect.length * 0.01 > fitted_numbers(made, VEHICLE, more=more)[0]["length"]


def test_what_the_noise_makes_uncertain_weighs_less():
    observation, made = fitted_from(flights(0.1, 0.35, 1), 0.1, 0.35)
    made = sharp_fit(observation, made)
    after = weighed(observation, made.members)
    assert weighted(after)
    for s in after.samples:
        for channel, weights in zip(s.channels, s.weights, strict=True):
            if channel.name == "force":
                time = s.times(channel) - s.flight.t[0]
                assert weights[time < 2].mean() > weights[time > 12].mean()
    joint = sensitivities(after, made.members, []).joint
    again = fit(estimated(after, joint, rounds=1), made.members)
    assert again.members[0].effect.length == pytest.approx(0.35, rel=5e-3)
    assert not weighted(weighed(after, []))


def test_the_noise_stays_what_it_is_however_often_samples_are_weighed():
    observation, made = fitted_from(flights(0.1, 0.35, 1), 0.1, 0.35)
    for _ in range(4):
        made = sharp_fit(observation, made)
        joint = sensitivities(observation, made.members, []).joint
        observation = estimated(weighed(observation, made.members), joint, rounds=1)
        made = fit(observation, made.members)
    (key,) = (k for k in observation.noise if k.startswith("force"))
    assert [w.deviation for w in observation.noise[key]] == pytest.approx([0.05] * 3, rel=0.1)


def test_a_minute_of_flight_is_no_reason_for_false_precision():
    made = (
        Flight(fly(CONTENT, {"suspended_load": {"mass": 0.1, "length": 0.8}}, seconds=60, seed=0, noise=NOISE), {}),
    )
    added = add(Model(VEHICLE), ["suspended_load"], made)
    length, error = added.model.effects[0].length, added.errors[0]["length"]
    assert abs(length - 0.8) < 3 * error
    assert error < 0.01 * length


@pytest.mark.parametrize(("start", "stop"), [(25.0, None), (None, 10.0)])
def test_a_part_of_a_long_flight_can_be_scanned(start, stop):
    table = fly(CONTENT, {"suspended_load": {"mass": 0.1, "length": 0.8}}, seconds=42, seed=3, noise=NOISE)
    made = (Flight(table, {}),)
    known, _ = candidates({"suspended_load": catalogue()["suspended_load"]}, VEHICLE, made)
    observation = observe(Model(VEHICLE), made, start, stop)
    joint = sensitivities(observation, [], known).joint
    found = scanned(started(observation, joint), [], known[0], joint, list(range(joint[0][0].shape[2] - 1)))
    assert found.start[1] == pytest.approx(0.8, rel=0.03)


def test_without_a_force_to_look_at_nothing_is_scanned():
    observation, known = observed(flights(0.1, 0.8, 0), "suspended_load")
    joint = sensitivities(observation, [], known).joint
    for flight in joint:
        for columns in flight:
            columns[:, :, 1:] = 0.0
    assert scanned(observation, [], known[0], joint, list(range(joint[0][0].shape[2] - 1))) is None


def test_the_horizon_extends_to_the_valley_of_a_narrow_minimum():
    values = grid(Place("length", 1, 0.2, 0.05, 5.0, 0.6), (0.3,))

    def gains_at(places, horizon):
        """A swing of 0.5 m against others: in step within the horizon or not."""
        out_of_step = {p: (values[p] ** -0.5 - 0.5**-0.5) * np.sqrt(9.81) * min(horizon, 60.0) / 2 for p in places}
        return {p: horizon * 1000 * float(np.sinc(x / np.pi)) ** 2 for p, x in out_of_step.items()}, 1.0

    assert values[best_on_grid(len(values), gains_at)] == pytest.approx(0.5, rel=1e-3)
    assert best_on_grid(len(values), lambda places, _: ({p: 0.0 for p in places}, 1.0)) is None


def test_a_grid_needs_no_finite_bounds():
    assert grid(Place("length", 1, 0.2, 0.0, np.inf, 0.6), (0.3, 1.0))[[0, -1]] == pytest.approx([0.075, 4.0])


def test_diagnose_and_add_say_the_length_of_a_long_cable():
    made = flights(0.1, 2.5, 2)
    found = diagnose(Model(VEHICLE), made)
    assert found.supported == ("suspended_load",)
    said = found.finding("suspended_load")
    added = add(Model(VEHICLE), ["suspended_load"], made)
    given = (said.parameters, said.standard_errors), (added.model.effects[0].values, added.errors[0])
    for numbers, errors in given:
        assert numbers["length"] == pytest.approx(2.5, rel=5e-3)
        assert abs(numbers["length"] - 2.5) < 3 * errors["length"]
        assert abs(numbers["mass"] - 0.1) < 3 * errors["mass"]
    assert np.max(added.after.rmse[:3] / added.before.rmse[:3]) < 0.05
