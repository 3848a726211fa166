"""A number of the vehicle file that is no effect of the catalogue: where a rotor's thrust and reaction torque act."""

from __future__ import annotations

import numpy as np
from numba import njit

from infotraj.effects.along import Along, of_arm, torque_arm
from infotraj.effects.base import AXES, Declared, Effect, Parameter
from infotraj.effects.laws import RotorMove
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


class RotorTorque(Effect):
    """Torque r T of a rotor's thrust T beside what the file says, r turning with the rotor's tilt.

    For a rotor that is displaced by p along its plane r is p x d, d its axis; along d, r is what its moment constant is
    off by. Rotors of one arm, one above the other, share r: their thrusts are hardly told apart. What the air does at
    a rotor (inflow, drag) it does p further.
    """

    name = "rotor_torque"
    place = "wrench"
    parameters = (
        Parameter("rotor", "-", 1.0, (0, np.inf), index=True),
        Parameter("r", "m", 0.005, (-1.0, 1.0), size=3),
    )
    rotor: int
    r: Array
    needs = ("inertia", "rate")
    source = "Newton and Euler: the torque of a force about another point"
    linear = True
    repeatable = True
    declared = Declared("arms", 1 / 7, "")  # 0.7 mm, and as much of the reaction torque's arm

    @classmethod
    def in_the_file(cls, vehicle: Vehicle, place: int, rotor: int) -> tuple[str, float, float]:
        """A thrust along z that acts further along y turns about x."""
        r = vehicle.rotors[rotor]
        if place == 2:
            return f"rotor_{rotor}.moment_constant", float(r.moment_constant), -float(r.spin)
        other, sign = (1, 1.0) if place == 0 else (0, -1.0)
        return f"rotor_{rotor}.position.{AXES[other]}", float(r.position[other]), sign

    def moved_rotor(self) -> RotorMove:
        return RotorMove(self.rotor, self.r)

    def wrench(self, along: Along) -> Array:
        rotors = of_arm(along.vehicle, self.rotor)
        assert along.thrust is not None  # a wrench is asked for when the thrust is known
        thrust = along.thrust[:, rotors[0]] if len(rotors) == 1 else along.thrust[:, rotors].sum(axis=1)
        arm = torque_arm(along, self.rotor, self.r)
        return _torques(thrust, np.atleast_2d(arm))


@njit(cache=True)
def _torques(thrust, arm):
    """Wrenches (N, 6) of thrusts (N,) with torques of their arms, (N, 3) or (1, 3), and no force."""
    out = np.zeros((len(thrust), 6))
    for n in range(len(thrust)):
        for i in range(3):
            out[n, 3 + i] = thrust[n] * arm[min(n, len(arm) - 1), i]
    return out


def arms(vehicle: Vehicle) -> list[int]:
    """The first rotor of each arm."""
    return [i for i in range(len(vehicle.rotors)) if of_arm(vehicle, i)[0] == i]
