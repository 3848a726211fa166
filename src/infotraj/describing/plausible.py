"""Numbers that a first vehicle file is to be made of, and that no multirotor has: mostly those in another unit."""

from __future__ import annotations

import math

from infotraj.describing.alone import FASTEST_TIP, LAGS, SLOWEST_TIP, TORQUES
from infotraj.describing.guesses import thrust_coefficient_of_hover, thrust_coefficient_of_propeller
from infotraj.describing.writing import GRAVITY
from infotraj.errors import UsageError, problem

# Weight over the area of the propellers, N/m^2: a Crazyflie has some 40, a quadrotor of 5 inch 100 to 200, a ducted
# fan 2000.
_LOADING = (3.0, 3000.0)
# Arm over a propeller's diameter: below the first the rotors stand in each other, above the second they are lost.
_REACH = (0.25, 12.0)
_AGREE = 0.05  # of the speed in hover


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


def require_stand(moment_constant: float | None, time_constant: float | None, propeller: float) -> None:
    """UsageError for a moment constant (m) or a lag (s) that no rotor with this propeller (m, diameter) has."""
    if moment_constant is not None and not TORQUES[0] < moment_constant / propeller < TORQUES[1]:
        found = f"--moment-constant {moment_constant:g} with a propeller of {propeller:g} m"
        usual = f"m, {TORQUES[0] * propeller:.3g} to {TORQUES[1] * propeller:.3g}"
        raise UsageError(problem(found, usual, "Correct it: it is torque over thrust, N m over N."))
    if time_constant is not None and not LAGS[0] <= time_constant <= LAGS[1]:
        remedy = f"If it is in ms, give {time_constant / 1000:g}." if time_constant > LAGS[1] else "Correct it."
        raise UsageError(problem(f"--time-constant {time_constant:g}", f"s, {LAGS[0]:g} to {LAGS[1]:g}", remedy))


def require_agreement(
    mass: float, rotors: int, propeller: float, coefficient: float | None, hover: float | None, most: float | None
) -> None:
    """UsageError where speeds (rad/s), thrust coefficient (N s^2/rad^2) and mass (kg) contradict each other."""
    told = coefficient or (thrust_coefficient_of_hover(mass, GRAVITY, rotors, hover).value if hover else None)
    speed = math.sqrt(mass * GRAVITY / rotors / (told or thrust_coefficient_of_propeller(propeller).value))
    if hover is not None and abs(speed / hover - 1.0) > _AGREE:
        found = f"--hover {hover:.4g} with --thrust-coefficient {coefficient:g}"
        expected = f"{speed:.4g} rad/s, at which that lifts {mass:g} kg"
        raise UsageError(problem(found, expected, "Leave out the one that you know less well, or correct the mass."))
    if most is not None and most <= speed:
        whence = "--hover" if hover else "--thrust-coefficient" if coefficient else "the thrust guessed"
        found = f"--max-speed {most:.4g}: it cannot hover"
        remedy = "Correct one of them." if told else "Correct it, or give --hover."
        raise UsageError(problem(found, f"more than the {speed:.4g} rad/s in hover ({whence})", remedy))
