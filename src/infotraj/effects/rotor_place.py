"""A number of the vehicle file that is no effect of the catalogue: where the middle of the rotors is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from infotraj.effects.base import Declared, Effect, Parameter
from infotraj.effects.laws import BodyLaw
from infotraj.rotations import Array


class RotorPlace(Effect):
    """All rotors are r (body axes) from where the file says, and with them the drag that acts at the rotors.

    What that does to the torque of the thrusts is `rotor_torque`'s: heights do nothing to it, and no two rotors are off
    by the same.
    """

    name = "rotor_place"
    place = "rigid body"
    parameters = (Parameter("r", "m", 0.005, (-1.0, 1.0), size=3),)
    r: Array
    needs = ("inertia", "rate")
    beside = ("rotor_drag",)
    source = "Newton and Euler: the torque of a force about another point"
    declared = Declared("arms", 1 / 7, "middle of the rotors, further along {axis} by")  # 0.7 mm

    def body(self, law: BodyLaw) -> BodyLaw:
        return replace(law, drag_at_rotors=law.drag_at_rotors + self.r)


def torque_at(place: Array, force: Array) -> Array:
    """Torque (N, 3) about the origin of forces (N, 3) that act at `place` (3,), body axes."""
    return np.cross(place, force)
