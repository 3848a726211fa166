"""Wrench of the rotors at many instants.

A rotor's position p and axis d turn together with its tilt, so p x d turns with them: the wrench of a unit thrust is
W0 + W1 cos(tilt) + W2 sin(tilt) with three constant columns (Rodrigues' formula), and so is that of a unit reaction
torque. The wrench of all rotors is then one product of matrices.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from infotraj.dynamics.actuators import turn_parts
from infotraj.effects.along import Actuation
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


class RotorWrench:
    """Force (N) and torque (N m) about the body's origin, body axes, of a vehicle's rotors.

    ratio (rotors,) m: their reaction torques along their axes, a unit of thrust, as the vehicle file has them.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self.ratio = np.array([-r.spin * r.moment_constant for r in vehicle.rotors])
        of_rotor = np.array([-1 if r.tilt is None else r.tilt for r in vehicle.rotors])
        self._tilting = np.flatnonzero(of_rotor >= 0)
        self._tilt = of_rotor[self._tilting]
        by_thrust = [
            self._parts(vehicle, r.tilt, [np.array(r.axis), np.cross(r.position, r.axis)]) for r in vehicle.rotors
        ]
        by_torque = [self._parts(vehicle, r.tilt, [np.zeros(3), np.array(r.axis)]) for r in vehicle.rotors]
        self._by_thrust, self._by_torque = self._arranged(by_thrust), self._arranged(by_torque)

    def __call__(self, thrust: Array, torque_ratio: Array, actuation: Actuation) -> Array:
        """The wrench (N, 6) of thrusts (N, rotors) N and of reaction torques torque_ratio times them along the axes.

        torque_ratio (m): (rotors,), or (N, rotors) where it changes.
        """
        if torque_ratio.ndim == 2:
            still = np.zeros(thrust.shape[1])
            return self(thrust, still, actuation) + self._turned(thrust * torque_ratio, actuation) @ self._by_torque
        ratio = np.concatenate([torque_ratio, torque_ratio[self._tilting], torque_ratio[self._tilting]])
        return self._turned(thrust, actuation) @ (self._by_thrust + ratio[:, None] * self._by_torque)

    def _turned(self, values: Array, actuation: Actuation) -> Array:
        """Values (N, rotors), then times the cosine and times the sine of their tilts where they have one."""
        if not self._tilting.size:
            return values
        return _turned(values, *actuation.turns, self._tilting, self._tilt)

    def _arranged(self, parts: list[Array]) -> Array:
        stacked = np.array(parts)
        return np.concatenate([stacked[:, 0], stacked[self._tilting, 1], stacked[self._tilting, 2]])

    @staticmethod
    def _parts(vehicle: Vehicle, tilt: int | None, vectors: list[Array]) -> Array:
        """Constant, cosine and sine part (3, 6) of vectors that turn with the tilt."""
        if tilt is None:
            return np.array([np.concatenate(vectors), np.zeros(6), np.zeros(6)])
        return np.concatenate([turn_parts(vehicle.tilts[tilt].axis) @ v for v in vectors], axis=1)


class CommandedWrench:
    """The wrench of a vehicle that takes one: what is commanded, as it follows its command, times what acts of it.

    A thrust is here the share (N, 1) of the command that acts, 1 by itself. ratio (1,), 1 by itself: what multiplies
    the torque about the vehicle's `thrust_axis`, which is the rotors' reaction torque.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self.ratio = np.ones(1)
        self._axis = None if vehicle.thrust_axis is None else np.array(vehicle.thrust_axis)

    def __call__(self, share: Array, torque_ratio: Array, actuation: Actuation) -> Array:
        """The wrench (N, 6) of shares (N, 1) of the commands; torque_ratio: (1,), or (N, 1) where it changes."""
        total = share * actuation.rotor
        if self._axis is not None:
            about = total[:, 3:] @ self._axis
            total[:, 3:] += (torque_ratio - 1.0) * about[:, None] * self._axis
        return total


@njit(cache=True)
def _turned(values, cosine, sine, rotors, tilts):
    """Values (N, r), then those of `rotors` times the cosine and times the sine of their `tilts`."""
    count, width, tilting = len(values), values.shape[1], len(rotors)
    out = np.empty((count, width + 2 * tilting))
    for n in range(count):
        for r in range(width):
            out[n, r] = values[n, r]
        for k in range(tilting):
            x = values[n, rotors[k]]
            out[n, width + k] = x * cosine[n, tilts[k]]
            out[n, width + tilting + k] = x * sine[n, tilts[k]]
    return out


def wrench_of_inputs(vehicle: Vehicle) -> RotorWrench | CommandedWrench:
    """How the wrench follows from a vehicle's inputs."""
    return CommandedWrench(vehicle) if vehicle.inputs == "wrench" else RotorWrench(vehicle)


def rotor_wrench(position: Array, axis: Array, thrust: Array, reaction: Array) -> Array:
    """The wrench (N, 6) of rotors wherever they are: position, axis (N, rotors, 3), thrust, reaction (N, rotors).

    reaction (N m) is the reaction torque on the body along the axis.
    """
    torque = np.einsum("nr,nri->ni", reaction, axis)
    total = forces_at_rotors(position, thrust[..., None] * axis)
    total[:, 3:] += torque
    return total


def forces_at_rotors(position: Array, force: Array) -> Array:
    """Wrench about the body's origin (N, 6) of a force (N, rotors, 3) at every rotor, at position (N, rotors, 3)."""
    return _forces_at_rotors(position, np.ascontiguousarray(force))


@njit(cache=True)
def _forces_at_rotors(position, force):
    count, rotors = force.shape[:2]
    out = np.zeros((count, 6))
    for n in range(count):
        for r in range(rotors):
            x, y, z = position[n, r, 0], position[n, r, 1], position[n, r, 2]
            a, b, c = force[n, r, 0], force[n, r, 1], force[n, r, 2]
            out[n, 0] += a
            out[n, 1] += b
            out[n, 2] += c
            out[n, 3] += y * c - z * b
            out[n, 4] += z * a - x * c
            out[n, 5] += x * b - y * a
    return out
