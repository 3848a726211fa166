"""The wrench of a vehicle's inputs, by hand."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from infotraj.models.rotor_wrench import CommandedWrench


def test_a_moment_scale_multiplies_the_torque_about_the_thrust_axis_of_a_commanded_wrench_and_no_other():
    vehicle: Any = SimpleNamespace(thrust_axis=(0.0, 0.0, 1.0))
    commanded: Any = SimpleNamespace(rotor=np.array([[0.0, 0.0, 8.0, 0.1, 0.2, 0.3]]))
    made = CommandedWrench(vehicle)(np.full((1, 1), 0.5), np.array([1.5]), commanded)
    np.testing.assert_allclose(made, [[0.0, 0.0, 4.0, 0.05, 0.1, 0.225]])
