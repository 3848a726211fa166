"""References that wander smoothly in place and attitude, from rest to rest."""

from __future__ import annotations

import numpy as np

from infotraj import rotations
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference, from_poses

_RISE = 2.5  # s from rest to the full size, and back
_HEIGHT = 1.5  # m


def wandering(
    duration: float, place: float, angle: float, rng: np.random.Generator, dt: float = 0.01, tempo: float = 1.0
) -> Reference:
    """Two sines an axis with random phases and frequencies, under a window that starts and ends at rest.

    duration (s); place (m): size of the motion along x and y, half of it (0.6 m at most) along z; angle (rad): size of
    roll and pitch, twice it in yaw; dt (s); tempo: of the motion in place, 1 being as fast as that in attitude (1.1 to
    1.9 rad/s, and 2.4 to 3.6 rad/s with a third of the size).
    """
    t = dt * np.arange(round(duration / dt) + 1, dtype=float)
    rise = np.clip(np.minimum(t, duration - t) / _RISE, 0.0, 1.0)
    window = rise**3 * (10 - 15 * rise + 6 * rise**2)

    def wave(size: float, speed: float = 1.0) -> Array:
        slow, fast = speed * rng.uniform(1.1, 1.9), speed * rng.uniform(2.4, 3.6)
        first, second = rng.uniform(0.0, 2.0 * np.pi, 2)
        return window * size * (np.sin(slow * t + first) + 0.3 * np.sin(fast * t + second))

    around = wave(place, tempo), wave(place, tempo)
    position = np.stack([*around, _HEIGHT + wave(min(0.5 * place, 0.6), tempo)], axis=1)
    return from_poses(t, position, rotations.from_euler(wave(angle), wave(angle), wave(2.0 * angle)))
