"""The shape of the thrust curve."""

from __future__ import annotations

import numpy as np

from infotraj.effects.along import Along
from infotraj.effects.base import Effect, Parameter
from infotraj.effects.thrust import hover_thrust
from infotraj.rotations import Array


class ThrustExponent(Effect):
    """T = k_F w_h^(2-n) w^n, w_h a rotor's speed in hover by the vehicle file: right in hover, another slope.

    In terms of the thrust T_0 that the file gives: T_h (T_0 / T_h)^(n/2), T_h the rotor's share of the weight; so it is
    defined for a throttle and a thrust, too. A squared speed holds at a constant thrust coefficient; Reynolds number,
    flexing blades and a speed controller that sags under load change it: Leishman, Principles of Helicopter
    Aerodynamics, 3.3 and 6.2.
    """

    name = "thrust_exponent"
    place = "thrust"
    parameters = (Parameter("n", "-", 0.2, (1.0, 3.0), absent=2.0, meaning="exponent of the speed; w^2 in the file"),)
    n: float
    built = True
    needs = ("rotors", "mass")
    needs_to_act = needs
    source = "Leishman, Principles of Helicopter Aerodynamics, 3.3"
    hidden_when = "the rotors stay at their speed in hover"

    def thrust_factor(self, along: Along) -> Array:
        share = np.maximum(along.nominal_thrust, 0.0) / hover_thrust(along.vehicle)
        # A rotor at rest has no thrust, whatever the exponent: no factor of it is asked for.
        return np.where(share > 0.0, share, 1.0) ** (self.n / 2 - 1.0)
