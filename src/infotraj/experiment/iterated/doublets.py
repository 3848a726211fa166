"""The usual identification flight: axis by axis a doublet, then a sine sweep (Klein and Morelli, Aircraft System
Identification, AIAA 2006, sec. 9.3)."""

from __future__ import annotations

import numpy as np

from infotraj.design.paths import DT, Room, placed
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference
from infotraj.trajectories.standard import window

_SLOW, _FAST = 0.2, 1.0  # Hz, of the sweep
_YAW = 0.3  # rad: rotors turn a vehicle about its thrust with their drag alone


def doublets(room: Room, rng: np.random.Generator, shares: Array | None = None) -> Reference:
    """x, y, z, yaw (and roll and pitch, where the vehicle may choose them) in turn.

    rng draws the order of the axes and on which side each begins; shares (axes,) of what the room allows, 1 by default.
    """
    t = DT * np.arange(round(room.seconds / DT) + 1, dtype=float)
    sizes = np.array([*room.size / 2, _YAW, *([room.tilt, room.tilt] if room.free else [])])
    signs, order = rng.choice([-1.0, 1.0], len(sizes)), rng.permutation(len(sizes))
    sizes = sizes * signs * (1.0 if shares is None else shares)
    length = t[-1] / len(sizes)
    axes = np.zeros((6, len(t)))
    for turn, axis in enumerate(order):
        own = (t >= turn * length) & (t < (turn + 1) * length)
        axes[axis, own] = sizes[axis] * _doublet_and_sweep(t[own] - turn * length, length)
    return placed(room, t, axes[:3].T, axes[3], axes[4], axes[5])


def axes_of(room: Room) -> int:
    """How many axes are moved in turn."""
    return 6 if room.free else 4


def _doublet_and_sweep(t: Array, length: float) -> Array:
    """To one side and to the other in the first half of `length` s, then a sweep; from rest to rest, at most 1."""
    half = length / 2
    first = t < half
    out = np.zeros(len(t))
    out[first] = _settled(t[first]) * np.sin(2 * np.pi * t[first] / half)
    u = t[~first] - half
    out[~first] = _settled(u) * np.sin(2 * np.pi * (_SLOW * u + (_FAST - _SLOW) * u**2 / (2 * half)))
    return out


def _settled(t: Array) -> Array:
    """1 but for the beginning and the end, where it comes from and goes to 0 smoothly."""
    return window(t - t[0], 0.5 * (t[-1] - t[0]))
