"""Tracking with rotors that all push along body z: the attitude is what the wanted force asks for.

Lee, Leok and McClamroch, "Geometric tracking control of a quadrotor UAV on SE(3)" (2010), with attitude errors as
rotation vectors and integrals on both loops.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from infotraj.control.demand import limit_norm, relative, rotate_into
from infotraj.control.tracking import states
from infotraj.dynamics.allocation import Allocation
from infotraj.rotations import Array
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


# For a vehicle with strong, fast rotors: it follows paths of several g in air drag of as much as its weight.
AGILE = ThrustVectorGains(
    position_p=5.0, position_d=3.5, position_i=1.5, attitude_p=150.0, attitude_d=20.0, attitude_i=20.0, yaw_p=4.0,
    yaw_d=2.5, yaw_i=1.0, max_feedback_acceleration=15.0, max_angular_acceleration=200.0,
)  # fmt: skip


class ThrustVectorController:
    """Tracks position and yaw of `reference` with the vehicle file's model; `command` as robots call it."""

    def __init__(self, vehicle: Vehicle, reference: Reference, gains: ThrustVectorGains | None = None) -> None:
        self.period = reference.dt
        self._vehicle, self._reference = vehicle, states(reference)
        self._inertia, self._allocation = vehicle.inertia_matrix(), Allocation(vehicle)
        g = gains or ThrustVectorGains()
        self._position = np.array([g.position_p, g.position_d, g.position_i, g.max_feedback_acceleration])
        self._attitude = np.array(
            [
                [g.attitude_p, g.attitude_p, g.yaw_p],
                [g.attitude_d, g.attitude_d, g.yaw_d],
                [g.attitude_i, g.attitude_i, g.yaw_i],
                [g.max_angular_acceleration] * 3,
            ]
        )
        self.reset()

    def reset(self) -> None:
        """Forgets the integrals."""
        self._drift, self._twist = np.zeros(3), np.zeros(3)

    def command(self, k: int, estimate) -> tuple[Array, Array, Array]:
        """Wrench (6,) N and N m, rotor speeds (rad/s) and no tilts, from sample k on."""
        torque, thrust = _demand(
            self._reference[k], estimate.position, estimate.velocity, estimate.attitude, estimate.rate, self._drift,
            self._twist, self._position, self._attitude, self._inertia, self._vehicle.gravity, self.period,
        )  # fmt: skip
        thrust *= self._vehicle.known_mass()
        wrench = np.array([0.0, 0.0, thrust, *torque])
        rotor_speed, tilt = self._allocation.actuators(wrench)
        return wrench, rotor_speed, tilt


@njit(cache=True)
def _demand(row, place, velocity, q, rate, drift, twist, position, attitude, inertia, gravity, period):
    """Torque (3,) N m and thrust over mass (m/s^2); moves the integrals `drift` and `twist` on."""
    wanted = np.empty(3)
    miss = row[0:3] - place
    for i in range(3):
        wanted[i] = position[0] * miss[i] + position[1] * (row[7 + i] - velocity[i]) + position[2] * drift[i]
    if not limit_norm(wanted, 0, position[3]):
        drift += period * miss
    for i in range(3):
        wanted[i] += row[13 + i]
    wanted[2] += gravity
    goal = _attitude(wanted, row[3:7])
    turn = np.empty(4)
    relative(q, goal, turn)
    if turn[0] < 0:
        turn[:] = -turn
    sine = np.sqrt(turn[1] ** 2 + turn[2] ** 2 + turn[3] ** 2)
    stretch = 2.0 * np.arctan2(sine, turn[0]) / sine if sine > 1e-9 else 2.0
    # turn maps vectors of the goal's body to the vehicle's: rotate_into takes the inverse
    back = np.array([turn[0], -turn[1], -turn[2], -turn[3]])
    ahead, angular = np.empty(3), np.empty(3)
    rotate_into(back, row[10:13], ahead)
    rotate_into(back, row[16:19], angular)
    for i in range(3):
        error = stretch * turn[1 + i]
        twist[i] += period * error
        angular[i] += attitude[0, i] * error + attitude[1, i] * (ahead[i] - rate[i]) + attitude[2, i] * twist[i]
    limit_norm(angular, 0, attitude[3, 0])
    momentum = inertia @ rate
    body = np.empty(3)
    rotate_into(q, wanted, body)
    return inertia @ angular + np.cross(rate, momentum), max(body[2], 1.0)


@njit(cache=True)
def _attitude(force, reference):
    """The attitude (4,) with body z along `force` and the heading of `reference` (4,)."""
    w, x, y, z = reference
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    up = force / np.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    ahead = np.cross(np.cross(up, np.array([np.cos(yaw), np.sin(yaw), 0.0])), up)
    ahead /= np.sqrt(ahead[0] ** 2 + ahead[1] ** 2 + ahead[2] ** 2)
    left = np.cross(up, ahead)
    out = np.empty(4)
    out[0] = 0.5 * np.sqrt(max(1.0 + ahead[0] + left[1] + up[2], 1e-12))
    out[1] = (left[2] - up[1]) / (4.0 * out[0])
    out[2] = (up[0] - ahead[2]) / (4.0 * out[0])
    out[3] = (ahead[1] - left[0]) / (4.0 * out[0])
    return out
