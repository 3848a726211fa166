"""Effects on the rigid body: its mass, its inertia, its centre of mass."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np

from infotraj.effects.base import Declared, Effect, Parameter
from infotraj.effects.laws import BodyLaw
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_BALANCED = 0.00033  # m: what a balance tells of a centre of mass, however small the vehicle


class MassOffset(Effect):
    """True mass m = nominal + dm: the specific force is F / (nominal + dm). Newton's second law."""

    name = "mass_offset"
    place = "rigid body"
    exact = True
    balance = True
    declared = Declared("mass", 1 / 10, "mass")  # 0.5 %: a scale is better than a bench
    parameters = (Parameter("dm", "kg", 0.05, (-0.5, 1.0), meaning="true mass minus the vehicle file's"),)
    dm: float
    needs = ("mass", "specific force")
    source = "Newton's second law"

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.05 * vehicle.known_mass()

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        return -0.5 * vehicle.known_mass(), 3.0 * vehicle.known_mass()

    @classmethod
    def whole(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return vehicle.mass or 0.0

    @classmethod
    def in_the_file(cls, vehicle: Vehicle, place: int, rotor: int) -> tuple[str, float, float]:
        return "mass", float(vehicle.mass or 0.0), 1.0

    def body(self, law: BodyLaw) -> BodyLaw:
        return law if law.mass is None else replace(law, mass=law.mass + self.dm)


class InertiaError(Effect):
    """True inertia J = nominal + diag(dxx, dyy, dzz), about the centre of mass. Euler's equations."""

    name = "inertia_error"
    place = "rigid body"
    exact = True
    declared = Declared("inertia", 2 / 15, "inertia.{axis}{axis}")  # 2 %: from a drawing, or a pendulum
    parameters = tuple(
        Parameter(f"d{a}", "kg m^2", 0.01, (-1.0, 1.0), meaning=f"true J_{a} minus the vehicle file's")
        for a in ("xx", "yy", "zz")
    )
    needs = ("inertia", "rate")
    source = "Euler's equations of motion"
    like_commands = True
    _place: ClassVar[dict[str, int]] = {"dxx": 0, "dyy": 1, "dzz": 2}

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        i = cls._place[parameter.name]
        return 0.15 * vehicle.inertia_matrix()[i, i]

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        i = cls._place[parameter.name]
        nominal = vehicle.inertia_matrix()[i, i]
        return -0.8 * nominal, 9.0 * nominal

    @classmethod
    def whole(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        i = cls._place[parameter.name]
        return float(vehicle.inertia_matrix()[i, i])

    @classmethod
    def in_the_file(cls, vehicle: Vehicle, place: int, rotor: int) -> tuple[str, float, float]:
        name, _, per = super().in_the_file(vehicle, place, rotor)
        moments = np.diag(vehicle.inertia.matrix()) if vehicle.inertia is not None else np.zeros(3)
        return name, float(moments[place]), per

    dxx: float
    dyy: float
    dzz: float

    def body(self, law: BodyLaw) -> BodyLaw:
        if law.inertia is None:
            return law
        return replace(law, inertia=law.inertia + np.diag([self.dxx, self.dyy, self.dzz]))


class CenterOfMassOffset(Effect):
    """Centre of mass at r from where the vehicle file puts it (the body's origin, if it says nothing).

    With the wrench (F, tau) about the origin and J about the centre of mass: J dw = tau - r x F - w x J w, and the
    IMU at the origin measures F/m - dw x r - w x (w x r). Featherstone, "Rigid Body Dynamics Algorithms" (2008), 2.13.
    """

    name = "com_offset"
    place = "rigid body"
    exact = True
    balance = True
    declared = Declared("place", 1 / 20, "center_of_mass.{axis}")  # 0.15 % of an arm, and `_BALANCED`
    parameters = (Parameter("r", "m", 0.01, (-0.1, 0.1), size=3, meaning="centre of mass, body axes"),)
    r: Array
    needs = ("rate",)
    needs_to_act = needs
    source = "Featherstone, Rigid Body Dynamics Algorithms (2008), 2.13"

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.03 * arm_length(vehicle)

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        reach = 0.5 * arm_length(vehicle)
        return -reach, reach

    @classmethod
    def declared_deviation(cls, vehicle: Vehicle, size: float) -> float:
        return float(np.hypot(super().declared_deviation(vehicle, size), _BALANCED / abs(size)))

    @classmethod
    def in_the_file(cls, vehicle: Vehicle, place: int, rotor: int) -> tuple[str, float, float]:
        name, _, per = super().in_the_file(vehicle, place, rotor)
        return name, float(vehicle.center_of_mass[place]), per

    def body(self, law: BodyLaw) -> BodyLaw:
        return replace(law, center_of_mass=law.center_of_mass + self.r)


def arm_length(vehicle: Vehicle) -> float:
    """Mean distance (m) of the rotors from the body's origin: the size that usual offsets scale with.

    Where the file has no rotors: that at which half of the mass makes the inertia about z, as motors on arms do; 0.1 m
    where it does not say that either.
    """
    if vehicle.rotors:
        return float(np.mean([np.linalg.norm(r.position) for r in vehicle.rotors])) or 0.1
    if vehicle.mass is None or vehicle.inertia is None:
        return 0.1
    return float(np.sqrt(2.0 * vehicle.inertia.zz / vehicle.mass))
