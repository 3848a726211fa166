"""Tracking with rotors that all push along body z: the attitude is what the wanted force asks for.

Lee, Leok and McClamroch, "Geometric tracking control of a quadrotor UAV on SE(3)" (2010), with attitude errors as
rotation vectors and integrals on both loops.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj import rotations
from infotraj.dynamics.allocation import Allocation
from infotraj.rotations import Array
from infotraj.trajectories.flatness import thrust_attitude
from infotraj.trajectories.reference import Reference
from infotraj.vehicle import Vehicle


@dataclass(frozen=True)
class ThrustVectorGains:
    """Per unit error; the action is an acceleration. attitude: roll and pitch; limits in m/s^2 and rad/s^2.

    Placed low, for plants whose rotors may lag by 80 ms more than declared: the attitude loop crosses at about 7 rad/s.
    """

    position_p: float = 2.0
    position_d: float = 2.2
    position_i: float = 0.4
    attitude_p: float = 22.0
    attitude_d: float = 7.0
    attitude_i: float = 6.0
    yaw_p: float = 6.0
    yaw_d: float = 3.5
    yaw_i: float = 1.5
    max_feedback_acceleration: float = 5.0
    max_angular_acceleration: float = 60.0


class ThrustVectorController:
    """Tracks position and yaw of `reference` with the vehicle file's model; `command` as robots call it."""

    def __init__(self, vehicle: Vehicle, reference: Reference, gains: ThrustVectorGains | None = None) -> None:
        self.period = reference.dt
        self._vehicle, self._reference, self._gains = vehicle, reference, gains or ThrustVectorGains()
        self._inertia, self._allocation = vehicle.inertia_matrix(), Allocation(vehicle)
        g = self._gains
        self._p = np.array([g.attitude_p, g.attitude_p, g.yaw_p])
        self._d = np.array([g.attitude_d, g.attitude_d, g.yaw_d])
        self._i = np.array([g.attitude_i, g.attitude_i, g.yaw_i])
        self.reset()

    def reset(self) -> None:
        """Forgets the integrals."""
        self._drift, self._twist = np.zeros(3), np.zeros(3)

    def command(self, k: int, estimate) -> tuple[Array, Array, Array]:
        """Wrench (6,) N and N m, rotor speeds (rad/s) and no tilts, from sample k on."""
        r, g = self._reference, self._gains
        miss = r.position[k] - estimate.position
        feedback = g.position_p * miss + g.position_d * (r.velocity[k] - estimate.velocity) + g.position_i * self._drift
        size = float(np.linalg.norm(feedback))
        if size > g.max_feedback_acceleration:
            feedback *= g.max_feedback_acceleration / size
        else:
            self._drift += self.period * miss
        wanted = r.acceleration[k] + feedback + np.array([0.0, 0.0, self._vehicle.gravity])
        goal = thrust_attitude(wanted, heading(r.attitude[k]))
        back = rotations.multiply(rotations.conjugate(estimate.attitude), goal)
        turn = rotations.log(back if back[0] >= 0 else -back)
        self._twist += self.period * turn
        rate, angular = rotations.to_world(back, r.rate[k]), rotations.to_world(back, r.angular_acceleration[k])
        angular = angular + self._p * turn + self._d * (rate - estimate.rate) + self._i * self._twist
        size = float(np.linalg.norm(angular))
        angular *= min(1.0, g.max_angular_acceleration / max(size, 1e-9))
        momentum = self._inertia @ estimate.rate
        torque = self._inertia @ angular + np.cross(estimate.rate, momentum)
        thrust = self._vehicle.mass * max(float(rotations.to_body(estimate.attitude, wanted)[2]), 1.0)
        wrench = np.array([0.0, 0.0, thrust, *torque])
        rotor_speed, tilt = self._allocation.actuators(wrench)
        return wrench, rotor_speed, tilt


def heading(attitude: Array) -> float:
    """Yaw (rad) of an attitude (4,)."""
    return float(rotations.to_euler(attitude)[2])
