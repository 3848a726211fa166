"""The paper's tasks: a pitching motion (Sec. V-A) and figures of eight in attitude (Sec. V-B, V-C), position fixed.

A task starts and ends at rest, level: the phase of its periodic motion runs up from zero speed and back to it, so
the path itself is the same from the first sample to the last.
"""

from __future__ import annotations

import numpy as np

from infotraj import rotations
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference, from_poses

_HEIGHT = 1.5  # m, well clear of the ground effect (several rotor radii)


def phase(t: Array, cycles: int, ramp: float) -> Array:
    """Phase (rad) from 0 to 2 pi `cycles` over t (n,) s; its speed rises and falls over `ramp` seconds.

    The speed follows the quintic 10 s^3 - 15 s^4 + 6 s^5, so that the angular acceleration stays smooth.
    """
    duration = t[-1] - t[0]
    speed = 2 * np.pi * cycles / (duration - ramp)

    def rise(since: Array) -> Array:
        s = np.clip(since / ramp, 0.0, 1.0)
        return speed * (ramp * (2.5 * s**4 - 3 * s**5 + s**6) + np.maximum(since - ramp, 0.0))

    since = t - t[0]
    half = duration / 2
    return np.where(since <= half, rise(since), 2 * np.pi * cycles - rise(duration - since))


def pitch_task(amplitude: float, peak_acceleration: float, cycles: int, dt: float, ramp: float = 2.0) -> Reference:
    """Pitch swings between +- `amplitude` (rad); its acceleration peaks at `peak_acceleration` (rad/s^2).

    The steady frequency follows from both: w = sqrt(peak_acceleration / amplitude).
    """
    speed = np.sqrt(peak_acceleration / amplitude)
    t = _times(2 * np.pi * cycles / speed + ramp, dt)
    angle = amplitude * np.sin(phase(t, cycles, ramp))
    return _at_rest_position(t, np.zeros_like(t), angle)


def figure_eight(amplitude: float, period: float, cycles: int, dt: float, ramp: float = 2.0) -> Reference:
    """A figure of eight in attitude: roll once, pitch twice a `period` (s), each up to `amplitude` (rad)."""
    t = _times(cycles * period + ramp, dt)
    around = phase(t, cycles, ramp)
    return _at_rest_position(t, amplitude * np.sin(around), amplitude * np.sin(2 * around))


def _times(duration: float, dt: float) -> Array:
    return dt * np.arange(round(duration / dt) + 1, dtype=float)


def _at_rest_position(t: Array, roll: Array, pitch: Array) -> Reference:
    position = np.broadcast_to([0.0, 0.0, _HEIGHT], (len(t), 3))
    return from_poses(t, position, rotations.from_euler(roll, pitch, np.zeros_like(t)))
