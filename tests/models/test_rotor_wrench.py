"""The wrench of a vehicle's inputs, by hand."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from infotraj.dynamics import actuators
from infotraj.effects import along
from infotraj.models.rotor_wrench import CommandedWrench
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle(Path(__file__).parents[2] / "config/vehicles/omav.yaml")


def test_a_moment_scale_multiplies_the_torque_about_the_thrust_axis_of_a_commanded_wrench_and_no_other():
    vehicle: Any = SimpleNamespace(thrust_axis=(0.0, 0.0, 1.0))
    commanded: Any = SimpleNamespace(rotor=np.array([[0.0, 0.0, 8.0, 0.1, 0.2, 0.3]]))
    made = CommandedWrench(vehicle)(np.full((1, 1), 0.5), np.array([1.5]), commanded)
    np.testing.assert_allclose(made, [[0.0, 0.0, 4.0, 0.05, 0.1, 0.225]])


def test_rotors_stand_along_a_flight_where_their_tilts_turn_them():
    tilt = np.random.default_rng(0).uniform(-np.pi, np.pi, (20, len(OMAV.tilts)))
    made_of = along.rotor_frames(OMAV, np.cos(tilt), np.sin(tilt))
    for made, expected in zip(made_of, actuators.rotor_frames(OMAV, tilt), strict=True):
        np.testing.assert_allclose(made, expected, atol=1e-12)
