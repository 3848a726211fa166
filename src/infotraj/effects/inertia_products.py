"""Numbers of the vehicle file that are no effect of the catalogue: its products of inertia."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from infotraj.effects.base import Declared, Effect, Parameter
from infotraj.effects.laws import BodyLaw
from infotraj.vehicle import Vehicle

_MOST = 0.3  # of the moments' geometric mean: with moments that are off as well, still a body


class InertiaProducts(Effect):
    """True inertia J = nominal + [[0, xy, xz], [xy, 0, yz], [xz, yz, 0]], about the centre of mass. Euler's equations.

    Files hardly ever state them. A battery or a load that is beside the planes of symmetry makes some: rolling then
    turns the vehicle about z as well, as reaction torques that differ from rotor to rotor would.
    """

    name = "inertia_products"
    place = "rigid body"
    exact = True
    parameters = tuple(
        Parameter(f"d{a}", "kg m^2", 0.01, (-1.0, 1.0), meaning=f"true entry J_{a} minus the vehicle file's")
        for a in ("xy", "xz", "yz")
    )
    dxy: float
    dxz: float
    dyz: float
    needs = ("inertia", "rate")
    source = "Euler's equations of motion"
    declared = Declared("axes", 1 / 3, "")  # 5 % of the moments: as a load of 15 % beside the middle makes them

    @classmethod
    def _size(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        moments = dict(zip("xyz", np.diag(vehicle.inertia_matrix()), strict=True))
        return float(np.sqrt(moments[parameter.name[1]] * moments[parameter.name[2]]))

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.15 * cls._size(vehicle, parameter)

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        most = _MOST * cls._size(vehicle, parameter)
        return -most, most

    @classmethod
    def in_the_file(cls, vehicle: Vehicle, place: int, rotor: int) -> tuple[str, float, float]:
        of = cls.parameters[place].name[1:]
        return f"inertia.{of}", float(getattr(vehicle.known_inertia(), of)), 1.0

    def body(self, law: BodyLaw) -> BodyLaw:
        if law.inertia is None:
            return law
        xy, xz, yz = self.dxy, self.dxz, self.dyz
        return replace(law, inertia=law.inertia + np.array([[0.0, xy, xz], [xy, 0.0, yz], [xz, yz, 0.0]]))
