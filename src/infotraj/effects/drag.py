"""Drag: forces and torques against the motion through the air."""

from __future__ import annotations

import numpy as np

from infotraj.effects.along import Along
from infotraj.effects.base import Effect, Parameter
from infotraj.effects.thrust import mass_per_speed
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


class RotorDrag(Effect):
    """Force -k w v_perp at each rotor, v_perp = v_r - (v_r . d) d: blade flapping and induced drag.

    Martin and Salaun, "The true role of accelerometer feedback in quadrotor control" (2010), eq. 9; rotorpy, RotorS.
    """

    name = "rotor_drag"
    place = "wrench"
    parameters = (Parameter("k", "N s^2/(m rad)", 6e-5, (0.0, 2e-3)),)
    k: float
    needs = ("velocity", "rate", "rotor speed")
    needs_to_act = needs
    damps_turns = True
    source = "Martin and Salaun (2010), eq. 9; rotorpy; RotorS"
    linear = True

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.15 * mass_per_speed(vehicle)

    def rotor_force(self, along: Along) -> Array:
        return -self.k * along.speed[..., None] * along.velocity_across


class LinearDrag(Effect):
    """Force -d v at the body's origin, axis by axis in body axes, v its velocity through the air.

    Faessler et al., "Differential flatness of quadrotor dynamics subject to rotor drag" (2018), eq. 2, in newtons.
    """

    name = "linear_drag"
    place = "wrench"
    parameters = (Parameter("d", "N s/m", 0.1, (0.0, 10.0), size=3),)
    d: Array
    needs = ("velocity",)
    needs_to_act = needs
    source = "Faessler et al. (2018), eq. 2"
    linear = True

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.15 * (vehicle.mass or 0.7)

    def wrench(self, along: Along) -> Array:
        return of_drag(along, -self.d * along.velocity_in_air)


class QuadraticDrag(Effect):
    """Force -d_i |v_i| v_i at the body's origin, axis by axis in body axes, v its velocity through the air.

    Parasitic drag: Leishman, Principles of Helicopter Aerodynamics, 5.4.6, along each axis.
    """

    name = "quadratic_drag"
    place = "wrench"
    parameters = (Parameter("d", "N s^2/m^2", 0.05, (0.0, 10.0), size=3),)
    d: Array
    needs = ("velocity",)
    needs_to_act = needs
    source = "Leishman, Principles of Helicopter Aerodynamics, 5.4.6"
    linear = True

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.07 * (vehicle.mass or 0.7)

    def wrench(self, along: Along) -> Array:
        v = along.velocity_in_air
        return of_drag(along, -self.d * np.abs(v) * v)


class AngularDamping(Effect):
    """Torque -d omega, axis by axis in body axes: rotors and arms moving through the air as the body turns."""

    name = "angular_damping"
    place = "wrench"
    parameters = (Parameter("d", "N m s/rad", 0.01, (0.0, 5.0), size=3),)
    d: Array
    needs = ("inertia", "rate")
    needs_to_act = ("rate",)
    source = "Padfield, Helicopter Flight Dynamics (2007), 4.3.1 (rate damping derivatives)"
    linear = True
    like_commands = True

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.01 if vehicle.inertia is None else 0.8 * float(np.diag(vehicle.inertia.matrix()).min())

    def wrench(self, along: Along) -> Array:
        return np.concatenate([np.zeros((along.count, 3)), -self.d * along.rate], axis=1)


def of_drag(along: Along, force: Array) -> Array:
    """The wrench (N, 6) of a force (N, 3) that acts where drag does: at the centre of pressure, else at the origin."""
    place = along.air.pressure_centre
    if not place.any():
        return force_only(force)
    return np.asarray(force @ np.concatenate([np.eye(3), np.cross(place, np.eye(3))], axis=1))


def force_only(force: Array) -> Array:
    """The wrench (N, 6) of a force (N, 3) at the body's origin."""
    wrench = np.zeros((len(force), 6))
    wrench[:, :3] = force
    return wrench
