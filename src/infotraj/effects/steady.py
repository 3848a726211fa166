"""A constant force in the world, a constant torque on the body."""

from __future__ import annotations

import numpy as np

from infotraj.effects.along import Along
from infotraj.effects.base import Declared, Effect, Parameter
from infotraj.effects.drag import force_only
from infotraj.effects.rigid_body import arm_length
from infotraj.rotation_matrices import turned_back
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


class SteadyForce(Effect):
    """A constant force f in world axes at the body's origin: steady wind, the pull of a tether."""

    name = "steady_force"
    place = "wrench"
    exact = True
    parameters = (Parameter("f", "N", 0.3, (-20.0, 20.0), size=3, meaning="world axes"),)
    f: Array
    needs = ("attitude", "mass", "specific force")
    needs_to_act = ("attitude",)
    source = "Newton's second law with a constant disturbance"
    # 0.1 deg by which the world frame is not level: 0.17 % of the weight.
    declared = Declared(
        "angle", 1 / 18, "level of the world frame or bias of the accelerometer, as a force along {axis}", alone=True
    )
    linear = True

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.03 * weight(vehicle)

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        # What a vehicle with more than twice its weight of thrust can hold its place against.
        return -2.0 * weight(vehicle), 2.0 * weight(vehicle)

    def wrench(self, along: Along) -> Array:
        return force_only(turned_back(along.attitude, self.f))


class SteadyTorque(Effect):
    """A constant torque t in body axes: an uneven frame, a misaligned rotor."""

    name = "steady_torque"
    place = "wrench"
    exact = True
    parameters = (Parameter("t", "N m", 0.01, (-10.0, 10.0), size=3, meaning="body axes"),)
    t: Array
    needs = ("inertia", "rate")
    source = "Euler's equations of motion with a constant disturbance"
    linear = True

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.01 * weight(vehicle) * arm_length(vehicle)

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        most = 0.5 * weight(vehicle) * arm_length(vehicle)
        return -most, most

    def wrench(self, along: Along) -> Array:
        return np.concatenate([np.zeros((along.count, 3)), np.broadcast_to(self.t, (along.count, 3))], axis=1)


def weight(vehicle: Vehicle) -> float:
    """Weight (N) by the vehicle file; of 1 kg where it gives no mass."""
    return (vehicle.mass or 1.0) * vehicle.gravity
