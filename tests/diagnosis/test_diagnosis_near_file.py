"""A file whose numbers are off is not a file with an entry wrong, and the other way round."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.ndimage import uniform_filter1d

from infotraj.comparing.equation_error import EquationError
from infotraj.diagnosis.gates.near_file import nats_against
from infotraj.diagnosis.gates.vehicle_faults import _SURE, _changed
from infotraj.dynamics.actuators import body_wrench
from infotraj.vehicle import Vehicle

CONTENT = yaml.safe_load((Path(__file__).parents[2] / "config" / "vehicles" / "quadrotor.yaml").read_text())
T = np.arange(600) / 100
WIDTH, NO_TILT = 15, np.zeros((600, 0))
NOISE = np.array([0.02, 0.02, 0.02, 1e-3, 1e-3, 3e-4])


def vehicle(off=0.0, seed=0):
    """The quadrotor, with every number of its rotors off by a share, places by that of an arm."""
    content, rng = yaml.safe_load(yaml.safe_dump(CONTENT)), np.random.default_rng(seed)
    for rotor in content["rotors"]:
        arm = np.linalg.norm(rotor["position"])
        rotor["thrust_coefficient"] *= 1 + off * rng.uniform(-1, 1)
        rotor["moment_constant"] *= 1 + off * rng.uniform(-1, 1)
        rotor["position"] = [float(x + off * arm * rng.uniform(-1, 1)) for x in rotor["position"]]
    return Vehicle.model_validate(content)


def inputs(seed):
    rng = np.random.default_rng(seed)
    hover = np.sqrt(CONTENT["mass"] * 9.81 / 4 / CONTENT["rotors"][0]["thrust_coefficient"])
    turns = uniform_filter1d(rng.standard_normal((600, 4)), 20, axis=0)
    return hover * (1 + 0.05 * turns + 0.1 * np.sin(2 * np.pi * 0.3 * T)[:, None])


def flown(plant, file, rotor, seed):
    """The error of a file on the flight of a plant."""
    rng = np.random.default_rng(seed)
    sides = [uniform_filter1d(body_wrench(v, rotor, NO_TILT), WIDTH, axis=0) for v in (plant, file)]
    measured = sides[0] + NOISE * rng.standard_normal((600, 6))
    unit = {"force": "N", "torque": "N m"}
    return EquationError(T, measured, sides[1], NOISE, np.ones(6), unit, "accelerometer", 0.15, {}, {})


def nats(plant, file, seed):
    rotor = inputs(seed)
    return nats_against(file, rotor, NO_TILT, flown(plant, file, rotor, seed), WIDTH)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("off", [0.0, 0.03, 0.1])
def test_numbers_that_are_off_are_no_wrong_entry(off, seed):
    plant, file = vehicle(off, seed), vehicle()
    given = nats(plant, file, seed)
    gains = {words: given - nats(plant, changed, seed) for words, changed in _changed(file, True)}
    assert max(gains.values()) < _SURE


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("off", [0.0, 0.03, 0.1])
@pytest.mark.parametrize("words", ["the spin of rotor_1 reversed", "rotor_0 and rotor_1 in each other's place"])
def test_a_wrong_entry_is_more_than_numbers_that_are_off(words, off, seed):
    plant, right = vehicle(off, seed), vehicle()
    wrong = dict(_changed(right, True))[words]
    assert nats(plant, wrong, seed) - nats(plant, right, seed) > _SURE


def test_a_flight_that_shows_nothing_says_nothing():
    file, rotor = vehicle(), inputs(0)
    error = flown(file, file, rotor, 0)
    error.measured[:] = np.nan
    assert nats_against(file, rotor, NO_TILT, error, WIDTH) == 0.0
