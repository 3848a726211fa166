"""What changes the rotors' thrust beside the wakes: ground, tilted neighbours, battery, hysteresis. Compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

# Below this share of its radius a rotor's height above the ground is not taken any smaller: the law has a pole.
LOWEST = 0.25


@njit(cache=True, error_model="numpy")
def factors(rotors, air, tilt, square, height, R, position):
    """Fills `factor` of every rotor.

    tilt (tilts,) rad, square (rotors,) speeds squared, height (m) of the body's origin above z = 0, R (3, 3) body to
    world, position (rotors, 3) m in the body frame. The hysteresis moves its `memory` on, so call it once a time step.
    """
    a = air[0]
    for i in range(rotors.shape[0]):
        factor = a.supply
        if a.ground_effect > 0.0:
            r = rotors[i].radius
            p = position[i]
            above = max(height + R[2, 0] * p[0] + R[2, 1] * p[1] + R[2, 2] * p[2], LOWEST * r)
            factor *= 1.0 + a.ground_effect * (r / above) ** 2
        if a.hysteresis != 0.0:
            factor *= 1.0 + a.hysteresis * _memory(rotors, i, np.sqrt(square[i]), a.hysteresis_half_width)
        rotors[i].factor = factor
    if a.tilt_interference > 0.0:
        _neighbours(rotors, a.tilt_interference, tilt, square)


@njit(cache=True, error_model="numpy")
def _memory(rotors, i, speed, half_width):
    """Where the speed stands within the play that it drags along, -1..1 (play operator)."""
    center = rotors[i].memory
    center = min(max(center, speed - half_width), speed + half_width)
    rotors[i].memory = center
    return (speed - center) / half_width


@njit(cache=True, error_model="numpy")
def _neighbours(rotors, strength, tilt, square):
    """A positive tilt blows towards the next arm counter-clockwise: the catalogue's rotor_interference."""
    arms = tilt.shape[0]
    push = np.zeros(arms)
    used = np.zeros(arms)
    for i in range(rotors.shape[0]):
        if rotors[i].tilt >= 0:
            push[rotors[i].tilt] += rotors[i].thrust_coefficient * square[i]
            used[rotors[i].tilt] = 1.0
    mean = push.sum() / used.sum()
    if not mean > 0.0:
        return
    for i in range(rotors.shape[0]):
        if rotors[i].before >= 0:
            b, c = rotors[i].before, rotors[i].after
            from_before, from_after = max(0.0, np.sin(tilt[b])), max(0.0, -np.sin(tilt[c]))
            rotors[i].factor *= 1.0 - strength * (from_before**2 * push[b] + from_after**2 * push[c]) / mean
