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
from infotraj.diagnosis.candidates import candidates
from infotraj.diagnosis.diagnosis import diagnose, observe
from infotraj.diagnosis.driving_noise import driving_variance, weighed, weighted
from infotraj.diagnosis.fitting import fit
from infotraj.diagnosis.noise import estimated, started
from infotraj.diagnosis.numbers import fitted_numbers
from infotraj.diagnosis.observation import Member
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
            assert ((weights > 0) & (weights <= 1)).all()
    joint = sensitivities(after, made.members, []).joint
    again = fit(estimated(after, joint, rounds=1), made.members)
    assert again.members[0].effect.length == pytest.approx(0.35, rel=5e-3)
    assert not weighted(weighed(after, []))


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
