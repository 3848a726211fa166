"""Numbers that a first vehicle file is to be made of, and that no multirotor has: mostly those in another unit."""

from __future__ import annotations

import math

from infotraj.describing.alone import FASTEST_TIP, SLOWEST_TIP
from infotraj.describing.writing import GRAVITY
from infotraj.errors import UsageError, problem

# Weight over the area of the propellers, N/m^2: a Crazyflie has some 40, a quadrotor of 5 inch 100 to 200, a ducted
# fan 2000.
_LOADING = (3.0, 3000.0)
# Arm over a propeller's diameter: below the first the rotors stand in each other, above the second they are lost.
_REACH = (0.25, 12.0)


def require_sizes(arm: float, mass: float, propeller: float, rotors: int) -> None:
    """UsageError where no vehicle of this arm (m), mass (kg) and propellers (m, diameter) flies."""
    given = f"--arm {arm:g} --mass {mass:g} --propeller {propeller:g} (m, kg, m)"
    remedy = "Correct it; units can be given: --arm 160mm --mass 800g --propeller 5in."
    loading = mass * GRAVITY / (rotors * math.pi * (propeller / 2) ** 2)
    if not _LOADING[0] < loading < _LOADING[1]:
        found = f"{given}: {rotors} propellers carry {loading:.4g} N a m^2 of their area"
        raise UsageError(problem(found, f"{_LOADING[0]:g} to {_LOADING[1]:g}", remedy))
    if not _REACH[0] < arm / propeller < _REACH[1]:
        found = f"{given}: an arm is {arm / propeller:.4g} propellers long"
        raise UsageError(problem(found, f"{_REACH[0]:g} to {_REACH[1]:g}", remedy))


def require_speed(hover: float, propeller: float) -> None:
    """UsageError where propellers (m, diameter) that turn at `hover` (rad/s) carry no multirotor."""
    tip = hover * propeller / 2
    if SLOWEST_TIP < tip < FASTEST_TIP:
        return
    found = f"--hover {hover:g}: at {hover:g} rad/s the tips of {propeller:g} m propellers move with {tip:.4g} m/s"
    remedy = f"If it is in rpm, give --hover {hover:g}rpm."
    if hover <= 1.0:
        remedy = "If it is a throttle, add --input throttle."
    raise UsageError(problem(found, f"rad/s, tips of {SLOWEST_TIP:g} to {FASTEST_TIP:g} m/s", remedy))
