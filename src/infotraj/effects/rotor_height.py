"""A number of the vehicle file that is no effect of the catalogue: how far along its axis a rotor is."""

from __future__ import annotations

import numpy as np

from infotraj.effects.base import Declared, Effect, Parameter
from infotraj.effects.laws import RotorMove
from infotraj.vehicle import Vehicle


class RotorHeight(Effect):
    """The rotors of an arm are h further along their axes than the file says, and with them the drag that acts there.

    Their thrusts turn the body alike, wherever along their own lines they act; drag of the rotors, which acts across
    them, does not: it then damps rolling and pitching by another height.
    """

    name = "rotor_height"
    place = "wrench"
    parameters = (
        Parameter("rotor", "-", 1.0, (0, np.inf), index=True),
        Parameter("h", "m", 0.005, (-1.0, 1.0)),
    )
    rotor: int
    h: float
    needs = ("inertia", "rate")
    beside = ("rotor_drag",)
    source = "Newton and Euler: the torque of a force about another point"
    repeatable = True
    declared = Declared("arms", 1 / 7, "rotor_{rotor}.position along its axis, more by")  # 0.7 mm

    @classmethod
    def in_the_file(cls, vehicle: Vehicle, place: int, rotor: int) -> tuple[str, float, float]:
        """Of a rotor that points straight up it is the place along z."""
        axis = np.array(vehicle.rotors[rotor].axis)
        if vehicle.rotors[rotor].tilt is None and np.allclose(axis, (0.0, 0.0, 1.0)):
            return f"rotor_{rotor}.position.z", float(vehicle.rotors[rotor].position[2]), 1.0
        return super().in_the_file(vehicle, place, rotor)

    def moved_rotor(self) -> RotorMove:
        return RotorMove(self.rotor, np.zeros(3), self.h)
