"""Candidate references: smooth motions within a room, drawn from a few numbers so that good ones can be varied.

Every axis moves by two sines of its own frequencies and phases under a window that begins and ends at rest. A vehicle
that pushes along body z takes roll and pitch from its acceleration; one with tilting rotors is given its own, so that
it may also turn without moving.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj import rotations
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference, from_poses
from infotraj.trajectories.standard import flat, window

DT = 0.01  # s
_SLOWEST, _FASTEST = 0.08, 0.7  # Hz
_TERMS = 2
_GENES = 1 + 3 * _TERMS  # of an axis: size; frequency, phase and weight of each term
_YAW = 1.5  # rad, at most
GRAVITY = 9.81


@dataclass(frozen=True)
class Room:
    """Where and how a design may fly.

    size (3,) m of the box; center (3,) m, world; seconds; speed: m/s, the greatest; tilt: rad, the greatest lean; free:
    whether roll and pitch are chosen (tilting rotors) or follow from the acceleration; gravity: m/s^2.
    """

    size: Array
    center: Array
    seconds: float
    speed: float
    tilt: float
    free: bool
    gravity: float = GRAVITY

    @property
    def genes(self) -> int:
        """How many numbers in [0, 1] describe a motion."""
        return (6 if self.free else 4) * _GENES


def path(room: Room, genes: Array) -> Reference:
    """The reference of `genes` (room.genes,) in [0, 1], in the limits of `placed`."""
    t = DT * np.arange(round(room.seconds / DT) + 1, dtype=float)
    axes = genes.reshape(-1, _GENES)
    place = np.stack([_wave(t, axes[i], room.size[i] / 2) for i in range(3)], axis=1)
    leans = [_wave(t, axes[k], room.tilt) for k in (4, 5)] if room.free else [0.0 * t, 0.0 * t]
    return placed(room, t, place, _wave(t, axes[3], _YAW), *leans)


def placed(room: Room, t: Array, place: Array, yaw: Array, roll: Array, pitch: Array) -> Reference:
    """The reference at `t` (n,) s along `place` (n, 3) m from the room's middle, scaled down until speed and lean are
    allowed; roll and pitch (n,) rad count where the vehicle may choose them."""
    velocity, acceleration = np.gradient(place, DT, axis=0), np.gradient(np.gradient(place, DT, axis=0), DT, axis=0)
    most = room.gravity * np.tan(room.tilt)
    across = np.linalg.norm(acceleration[:, :2], axis=1).max()
    upward = np.abs(acceleration[:, 2]).max()
    share = min(
        1.0,
        room.speed / max(float(np.linalg.norm(velocity, axis=1).max()), 1e-9),
        most / max(across, 1e-9),
        0.5 * room.gravity / max(upward, 1e-9),
    )
    place = room.center + share * place
    if not room.free:
        return flat(t, place, yaw, room.gravity)
    return from_poses(t, place, rotations.from_euler(roll, pitch, yaw))


def drawn(room: Room, rng: np.random.Generator) -> Array:
    """A motion at random: genes (room.genes,), uniform in [0, 1]."""
    return rng.random(room.genes)


def varied(genes: Array, spread: float, rng: np.random.Generator) -> Array:
    """A motion near another: every gene moved by `spread` (standard deviation), reflected at 0 and 1."""
    moved = np.abs(genes + spread * rng.standard_normal(len(genes))) % 2.0
    return np.where(moved > 1.0, 2.0 - moved, moved)


def calmer(genes: Array, share: float) -> Array:
    """The same motion, `share` times as large."""
    out = genes.reshape(-1, _GENES).copy()
    out[:, 0] *= share
    return out.ravel()


def _wave(t: Array, genes: Array, most: float) -> Array:
    """A motion of one axis (n,) that stays within +-most."""
    terms = genes[1:].reshape(_TERMS, 3)
    pulse = 2 * np.pi * _SLOWEST * (_FASTEST / _SLOWEST) ** terms[:, 0]
    weight = 0.2 + terms[:, 2]
    wave = np.sin(pulse[:, None] * t + 2 * np.pi * terms[:, 1, None])
    return most * genes[0] * window(t) * (weight @ wave) / weight.sum()
