"""Numbers of the file as an effect has them, and what is known of them before a flight."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from infotraj import rotations
from infotraj.diagnosis.gates.level import as_level, unmeasured
from infotraj.diagnosis.judge.numbers import _in_the_file
from infotraj.diagnosis.select.prior import Scales
from infotraj.dynamics.actuators import body_wrench
from infotraj.flight import ATTITUDE, Flight
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml")


@pytest.mark.parametrize("rotor", range(4))
@pytest.mark.parametrize("axis", range(3))
def test_a_corrected_file_makes_the_torque_that_was_found(rotor, axis):
    """An arm of 1 mm that the effect adds, as a moment constant or a place in the file: the same torque of a thrust."""
    arm, speeds = 1e-3, np.full(4, 900.0)
    name, declared, per = _in_the_file("rotor_torque", {"rotor": rotor}, axis, VEHICLE)
    old = VEHICLE.rotors[rotor]
    if axis == 2:
        assert name == f"rotor_{rotor}.moment_constant"
        new = old.model_copy(update={"moment_constant": declared + per * arm})
    else:
        place = list(old.position)
        k = "xyz".index(name[-1])
        assert place[k] == declared
        place[k] += per * arm
        new = old.model_copy(update={"position": tuple(place)})
    rotors = tuple(new if i == rotor else r for i, r in enumerate(VEHICLE.rotors))
    changed = VEHICLE.model_copy(update={"rotors": rotors})
    before, after = (body_wrench(v, speeds, np.zeros(0)) for v in (VEHICLE, changed))
    thrust = old.thrust_coefficient * 900.0**2
    expected = np.zeros(6)
    expected[3 + axis] = thrust * arm
    np.testing.assert_allclose(after - before, expected, atol=1e-9 * thrust)


def test_clocks_are_no_worse_for_what_a_file_says_of_its_vehicle():
    assert Scales(9.0).of("clock") == Scales(0.3).of("clock") == 1.0
    assert Scales(0.0).of("clock") == 0.0
    assert Scales(9.0, {"mass": 3.0}).of("mass") == 3.0
    assert Scales(9.0, {"mass": 3.0}).of("rotors") == 9.0


def test_a_vehicle_that_is_taken_as_level_is_level():
    t = np.arange(0.0, 1.0, 0.01)
    flight = as_level(Flight(pd.DataFrame({"t": t, "px": 0.0, "py": 0.0, "pz": 1.0})))
    np.testing.assert_array_equal(rotations.matrix(flight.get(*ATTITUDE)), np.broadcast_to(np.eye(3), (100, 3, 3)))
    assert unmeasured(flight) == (frozenset({"vx", "vy"}), frozenset({"vz", "tx", "ty", "tz"}))
