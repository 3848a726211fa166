"""What the IMU says of the motion, by flights that can be worked out by hand."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from infotraj.effects.laws import ImuLaw
from infotraj.flight import read_flight
from infotraj.models.kinematics import _attitudes, _push_of
from infotraj.models.prepared import Prepared
from infotraj.models.recorded import Samples
from infotraj.vehicle import load_vehicle

TOP = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def prepared():
    return Prepared(
        load_vehicle(TOP / "examples/quad/vehicle.yaml"), read_flight(TOP / "examples/quad/flight_0.parquet")
    )


def test_the_imu_pushes_along_the_world_as_the_body_is_turned():
    """Level and turned to the left, what pushes ahead in the body pushes along y of the world."""
    t = np.linspace(0.0, 1.0, 11)
    left = Samples(t, np.tile([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)], (11, 1)))
    force = np.tile([1.0, 0.0, 9.81], (10, 1))
    pushed = _push_of([force, force], _attitudes(t, left), 9.81)
    np.testing.assert_allclose(pushed[:-1], np.tile([0.0, 1.0, 0.0], (10, 1)), atol=1e-12)


def test_a_late_imu_measured_earlier_than_its_stamps_say(prepared):
    """Row k holds what was at t[k] - delay."""
    late = replace(ImuLaw.ideal(), delay=0.02)
    for of in (prepared.true_rate, prepared.true_specific_force):
        np.testing.assert_allclose(of(late).times, of(ImuLaw.ideal()).times - 0.02)
