"""What a vehicle file needs and nobody measured: guesses from size and mass, each with where it comes from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

AIR = 1.225  # kg/m^3
_OUTSIDE = 0.42  # of the mass, in motors, propellers and outer arms: 0.38 to 0.45 by the published zz of shipped files
_HUB = 0.4  # radius of what is in the middle, in arms
_THRUST_NUMBER = 0.14  # C_T = T / (rho n^2 D^4): two narrow blades have 0.09, three wide ones 0.19
_TORQUE_PER_DIAMETER = 0.1  # moment constant over diameter; 0.07 to 0.13 in the shipped files


class Guess(NamedTuple):
    """A value in SI, and the comment that says where it comes from."""

    value: float
    why: str


class Moments(NamedTuple):
    """Moments of inertia (kg m^2) about x, y and z, and where they come from."""

    xx: float
    yy: float
    zz: float
    why: str


def inertia(mass: float, positions: Sequence[tuple[float, float, float]], arm: float) -> Moments:
    """Rotors with an even share of what is outside, and a flat cylinder in the middle."""
    place = np.asarray(positions)
    share, hub = _OUTSIDE * mass / len(place), (1 - _OUTSIDE) * mass
    radius = _HUB * arm
    flat = hub * radius**2 / 4
    xx = share * float(np.sum(place[:, 1] ** 2)) + flat
    yy = share * float(np.sum(place[:, 0] ** 2)) + flat
    zz = share * float(np.sum(place[:, :2] ** 2)) + 2 * flat
    why = (
        f"guessed: {100 * _OUTSIDE:.0f} % of the mass at the rotors, the rest a flat disc of {_HUB:g} arms; "
        "off by up to a half, about x and y of a tall vehicle by more"
    )
    return Moments(xx, yy, zz, why)


def thrust_coefficient_of_hover(mass: float, gravity: float, rotors: int, speed: float) -> Guess:
    """N s^2/rad^2 from the speed (rad/s) at which it hovers."""
    return Guess(mass * gravity / rotors / speed**2, f"from hover: {mass:g} kg at {speed:g} rad/s")


def thrust_coefficient_of_propeller(diameter: float) -> Guess:
    """N s^2/rad^2 from the propeller's diameter (m) alone."""
    value = _THRUST_NUMBER * AIR * diameter**4 / (4 * np.pi**2)
    why = f"guessed from the diameter with C_T = {_THRUST_NUMBER:g}: right to a factor of 1.6; better from hover"
    return Guess(float(value), why)


def thrust_of_throttle(mass: float, gravity: float, rotors: int, hover: float) -> Guess:
    """The coefficient (N) of the throttle's square, from the throttle (0..1) at which it hovers."""
    return Guess(
        mass * gravity / rotors / hover**2, f"from hover: {mass:g} kg at throttle {hover:g}; a square is guessed"
    )


def moment_constant(diameter: float) -> Guess:
    """Torque per thrust (m)."""
    return Guess(_TORQUE_PER_DIAMETER * diameter, "guessed: a tenth of the propeller's diameter (0.07 to 0.13 of it)")
