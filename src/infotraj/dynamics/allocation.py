"""Allocation: which rotor speeds and tilts give a commanded wrench.

Bodie et al., "An omnidirectional aerial manipulation platform for contact-based inspection" (2019): the wrench is
linear in the sine and cosine components of every rotor's thrust, so the pseudo-inverse gives the smallest ones.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from infotraj.dynamics.actuators import turned_about
from infotraj.errors import InputError, problem
from infotraj.rotations import Array
from infotraj.vehicle import Rotor, Vehicle


class Allocation:
    """Static inverse of `dynamics.actuators.body_wrench` for one vehicle."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle = vehicle
        others = [f"{r.name} takes a {r.input}" for r in vehicle.rotors if r.input != "speed"]
        if others or not vehicle.rotors:
            found = others[0] if others else "no rotors"
            remedy = "Write `input: speed` and `thrust_coefficient`."
            raise InputError(problem(f"{vehicle.name}: {found}", "rotors that take a speed", remedy))
        self._tilt_of = np.array([-1 if r.tilt is None else r.tilt for r in vehicle.rotors])
        self._k_f = np.array([r.thrust_coefficient for r in vehicle.rotors])
        self._top = np.array([r.max_speed or np.inf for r in vehicle.rotors])
        self._member = np.zeros((len(vehicle.tilts), len(vehicle.rotors)))
        for i, tilt in enumerate(self._tilt_of):
            if tilt >= 0:
                self._member[tilt, i] = 1.0

    @cached_property
    def matrix(self) -> Array:
        """Wrench (N, N m) of unit thrust components: (6, 2 rotors), cosines first, then sines; 0 where fixed."""
        cosine = np.stack([self._column(r, 0.0) for r in self.vehicle.rotors], axis=1)
        sine = np.stack(
            [np.zeros(6) if r.tilt is None else self._column(r, np.pi / 2) for r in self.vehicle.rotors], axis=1
        )
        return np.concatenate([cosine, sine], axis=1)

    @cached_property
    def inverse(self) -> Array:
        """Pseudo-inverse of `matrix`, (2 rotors, 6)."""
        return np.asarray(np.linalg.pinv(self.matrix), dtype=float)

    def actuators(self, wrench: ArrayLike) -> tuple[Array, Array]:
        """Rotor speeds (..., rotors) rad/s and tilts (..., tilts) rad for a wrench (..., 6), body frame.

        A tilt is the direction of the sum over the rotors it turns; each squared speed is the projection of the
        rotor's own components on that direction, clipped at zero and at the top speed.
        """
        components = np.asarray(wrench, dtype=float) @ self.inverse.T
        cosine, sine = np.split(components, 2, axis=-1)
        tilt = np.arctan2(sine @ self._member.T, cosine @ self._member.T)
        angle = np.where(self._tilt_of >= 0, tilt[..., self._tilt_of], 0.0) if tilt.shape[-1] else np.zeros_like(cosine)
        thrust = np.maximum(cosine * np.cos(angle) + sine * np.sin(angle), 0.0)
        return np.minimum(np.sqrt(thrust / self._k_f), self._top), tilt

    def _column(self, rotor: Rotor, angle: float) -> Array:
        if rotor.tilt is None:
            axis, arm = np.asarray(rotor.axis), np.asarray(rotor.position)
        else:
            about = np.asarray(self.vehicle.tilts[rotor.tilt].axis)
            axis = turned_about(self.vehicle.tilts[rotor.tilt].axis, angle, rotor.axis)
            # An offset along the thrust turns with it and makes no torque; any other is outside this method.
            arm = np.dot(about, rotor.position) * about
            rest = np.asarray(rotor.position) - arm
            if np.linalg.norm(np.cross(rest, rotor.axis)) > 1e-6 or abs(np.dot(about, rotor.axis)) > 1e-6:
                raise InputError(
                    problem(
                        f"{self.vehicle.name}: {rotor.name} lies beside the axis of its tilt",
                        "a rotor on that axis, or offset along its own thrust, which is perpendicular to it",
                        "Correct `position` or `axis`.",
                    )
                )
        return np.concatenate([axis, np.cross(arm, axis) - rotor.spin * rotor.moment_constant * axis])
