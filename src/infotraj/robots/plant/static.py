"""The true wrench at rest in closed form, and the command that holds the true vehicle at an attitude."""

from __future__ import annotations

import numpy as np

from infotraj.dynamics.allocation import Allocation
from infotraj.errors import InfotrajError
from infotraj.robots.plant import aerodynamics
from infotraj.robots.plant.truth import Truth
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


class StaticPlant:
    """The plant at rest in still air, actuators settled, play at its middle, servos without load."""

    def __init__(self, vehicle: Vehicle, truth: Truth) -> None:
        self.vehicle, self.truth = vehicle, truth
        self._rotors = aerodynamics.rotor_table(vehicle, truth)
        self._air = aerodynamics.air_table(truth)
        self._axes = aerodynamics.tilt_axes(vehicle)
        self._zero = np.array(truth.servos.zero_error if truth.servos else (), dtype=float)
        self._allocation = Allocation(vehicle)

    def wrench(self, rotor_speed: Array, tilt: Array) -> Array:
        """True force (N) and torque (N m) about the body's origin, body frame, (6,), at settled commands."""
        n = len(self._rotors)
        position, direction, loss, thrust = np.empty((n, 3)), np.empty((n, 3)), np.empty(n), np.empty(n)
        still = np.zeros(3)
        square = np.clip(rotor_speed, 0.0, self._rotors["max_speed"]) ** 2
        aerodynamics.frames(self._rotors, self._axes, np.asarray(tilt, dtype=float) + self._zero, position, direction)
        aerodynamics.thrusts(self._rotors, self._air, square, still, still, position, direction, loss, thrust)
        result = np.zeros(6)
        aerodynamics.rotor_wrench(self._rotors, thrust, position, direction, result)
        return result

    def achieved(self, command: Array) -> Array:
        """What a commanded wrench (6,) really gives, as seen from the model: (6,) N and N m, body frame.

        Allocated with the vehicle file, acting on the true vehicle. The torque is the one that the vehicle file's
        inertia needs for the true angular acceleration at rest, which is how a flight log shows it.
        """
        true = self.wrench(*self._allocation.actuators(command))
        moment = true[3:] - np.cross(self.truth.center_of_mass, true[:3])
        angular = np.linalg.solve(self.truth.inertia.matrix(), moment)
        torque = self.vehicle.inertia_matrix() @ angular + np.cross(self.vehicle.center_of_mass, true[:3])
        return np.concatenate([true[:3], torque])

    def hold(self, up: Array) -> Array:
        """The commanded wrench (6,) under which the true vehicle hovers at rest; `up` (3,) is world z, body frame.

        InfotrajError where no such command exists.
        """
        weight = self.truth.flying_mass * self.vehicle.gravity
        force = weight * np.asarray(up, dtype=float)
        goal = np.concatenate([force, np.cross(self.vehicle.center_of_mass, force)])
        command = goal.copy()
        for _ in range(200):
            miss = goal - self.achieved(command)
            command += miss
            if np.abs(miss).max() < 1e-9 * weight:
                return command
        raise InfotrajError(
            f"{self.truth.name}: no command holds it with world z along {np.round(up, 3).tolist()} in the body frame; "
            f"{np.abs(miss).max():.3g} N or N m are missing. Make the plant's errors smaller."
        )
