"""Standard references that move every axis: figure eight, helix, attitude in place, low pass, waypoints.

All begin and end at rest. A vehicle that pushes along body z alone takes its attitude from the acceleration (`flat`);
one with tilting rotors is given roll and pitch of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from infotraj import rotations
from infotraj.rotations import Array
from infotraj.trajectories.flatness import thrust_attitude
from infotraj.trajectories.reference import Reference, from_poses


@dataclass(frozen=True)
class Extent:
    """How far and fast: size (m) of paths, `pace` (multiple of the usual speed), lowest height (m), tilt (rad) of
    vehicles that choose their attitude; 0 for those that cannot; speed (m/s) of the fast paths."""

    size: float = 0.9
    pace: float = 1.0
    low: float = 0.25
    tilt: float = 0.35
    speed: float = 6.0


_STILL = 0.6  # s at rest before the first and after the last move
Pose = tuple[Array, Array, Array, Array]  # position (n, 3) m; roll, pitch, yaw (n,) rad


def standard(kind: str, seconds: float, extent: Extent, rng: np.random.Generator, dt: float = 0.01) -> Reference:
    """A reference of `kind` (a key of KINDS), sampled every `dt` s; `rng` draws sizes, frequencies and phases."""
    t = dt * np.arange(round(seconds / dt) + 1, dtype=float)
    place, roll, pitch, yaw = KINDS[kind](t, extent, rng)
    if extent.tilt > 0:
        return from_poses(t, place, rotations.from_euler(roll, pitch, yaw))
    return flat(t, place, yaw)


def flat(t: Array, place: Array, yaw: Array, gravity: float = 9.81) -> Reference:
    """The reference of a vehicle that pushes along body z: attitude from acceleration and yaw (`flatness`)."""
    level = from_poses(t, place, rotations.from_euler(0 * yaw, 0 * yaw, yaw))
    force = level.acceleration + np.array([0.0, 0.0, gravity])
    return from_poses(t, place, thrust_attitude(force, yaw))


_HEIGHT = np.array([0.0, 0.0, 1.4])  # m, of the middle of most paths


def window(t: Array, rise: float = 2.0) -> Array:
    """From 0 to 1 and back, four times differentiable: rate and torque of a flat vehicle begin and end at 0."""
    u = np.clip(np.minimum(t, t[-1] - t) / rise, 0.0, 1.0)
    return u**5 * (126 - 420 * u + 540 * u**2 - 315 * u**3 + 70 * u**4)


def _wave(t: Array, size: float, pulse: float, rng: np.random.Generator) -> Array:
    """Two sines of about `pulse` and twice `pulse` (rad/s), of random phase, from rest to rest."""
    a, b = rng.uniform(0, 2 * np.pi, 2)
    slow, fast = pulse * rng.uniform(0.85, 1.15), pulse * rng.uniform(1.8, 2.3)
    return window(t) * size * (np.sin(slow * t + a) + 0.3 * np.sin(fast * t + b)) / 1.1


def _angles(t: Array, extent: Extent, rng: np.random.Generator, share: float = 1.0, yaw: float = 0.8) -> tuple:
    tilt = share * extent.tilt
    return _wave(t, tilt, 1.7, rng), _wave(t, tilt, 1.4, rng), _wave(t, yaw, 1.1, rng)


def _eight(t: Array, extent: Extent, rng: np.random.Generator) -> Pose:
    pulse, phase = extent.pace * rng.uniform(1.3, 1.7), rng.uniform(0, 2 * np.pi)
    a = extent.size * rng.uniform(0.9, 1.2)
    x = a * np.sin(pulse * t + phase)
    y = 0.5 * a * np.sin(2 * (pulse * t + phase))
    z = 0.35 * extent.size * np.sin(0.83 * pulse * t + rng.uniform(0, 2 * np.pi))
    place = window(t)[:, None] * np.stack([x, y, z], axis=1) + _HEIGHT
    return place, *_angles(t, extent, rng)


def _helix(t: Array, extent: Extent, rng: np.random.Generator) -> Pose:
    pulse, phase = extent.pace * rng.uniform(1.6, 2.0), rng.uniform(0, 2 * np.pi)
    radius = extent.size * rng.uniform(0.7, 0.9)
    around = pulse * t * rng.choice([-1.0, 1.0]) + phase
    z = 0.6 * extent.size * np.sin(0.37 * pulse * t)
    place = window(t)[:, None] * np.stack([radius * np.cos(around), radius * np.sin(around), z], axis=1)
    return place + _HEIGHT, *_angles(t, extent, rng, yaw=1.2)


def _attitude(t: Array, extent: Extent, rng: np.random.Generator) -> Pose:
    place = np.stack([_wave(t, 0.2, 2.3 * extent.pace, rng) for _ in range(3)], axis=1) + _HEIGHT
    return place, *_angles(t, extent, rng, share=1.6, yaw=1.0)


def _low(t: Array, extent: Extent, rng: np.random.Generator) -> Pose:
    pulse = extent.pace * rng.uniform(1.2, 1.5)
    x = _wave(t, extent.size, pulse, rng)
    y = _wave(t, extent.size, 0.8 * pulse, rng)
    # four descents to the lowest height in 16 s
    z = extent.low + 0.45 * (1.0 + np.cos(2 * np.pi * 0.25 * t)) + 0.4 * (1.0 - window(t))
    return np.stack([x, y, z], axis=1), *_angles(t, extent, rng, share=0.35)


def _waypoints(t: Array, extent: Extent, rng: np.random.Generator) -> Pose:
    """Straight moves between random points with constant acceleration, then constant deceleration."""
    place = np.stack([_moves(t, 1.3 * extent.size, rng) for _ in range(3)], axis=1) * [1.0, 1.0, 0.4]
    roll, pitch = _moves(t, 0.8 * extent.tilt, rng), _moves(t, 0.8 * extent.tilt, rng)
    return place + _HEIGHT, roll, pitch, _moves(t, 1.6, rng)


def _moves(t: Array, size: float, rng: np.random.Generator) -> Array:
    """From one random value to the next, each move half of the time speeding up and half slowing down."""
    stops = [0.0, _STILL]
    while stops[-1] < t[-1] - _STILL - 2.4:
        stops.append(stops[-1] + rng.uniform(1.2, 1.8))
    stops = [*stops[:-1], t[-1] - _STILL, t[-1]]
    values = np.concatenate([[0.0, 0.0], rng.uniform(-0.5, 0.5, len(stops) - 4) * size, [0.0, 0.0]])
    k = np.clip(np.searchsorted(stops, t, side="right") - 1, 0, len(stops) - 2)
    u = (t - np.array(stops)[k]) / np.diff(stops)[k]
    share = np.where(u < 0.5, 2 * u**2, 1 - 2 * (1 - u) ** 2)
    return values[k] + (values[k + 1] - values[k]) * share


def _smooth_waypoints(t: Array, extent: Extent, rng: np.random.Generator) -> Pose:
    """The same moves, each with the smallest jerk."""
    place = np.stack([_smoothed(_moves(t, 1.4 * extent.size, rng)) for _ in range(3)], axis=1) * [1.0, 1.0, 0.4]
    roll, pitch = (_smoothed(_moves(t, 0.8 * extent.tilt, rng)) for _ in range(2))
    return place + _HEIGHT, roll, pitch, _smoothed(_moves(t, 1.6, rng))


def _smoothed(values: Array, half: int = 20) -> Array:
    """Running mean, twice, over 2 half + 1 samples: what a vehicle that must tilt first can follow."""
    kernel = np.ones(2 * half + 1) / (2 * half + 1)
    for _ in range(2):
        values = np.convolve(np.pad(values, half, mode="edge"), kernel, mode="valid")
    return values


_FAST_HEIGHT, _SPEEDING_UP = np.array([0.0, 0.0, 4.0]), 4.0  # m, s


def _fast_circle(t: Array, extent: Extent, rng: np.random.Generator) -> Pose:
    """A circle, tipped a little, at `speed` after 4 s; banking grows with speed^2 / size."""
    radius, speed = extent.size * rng.uniform(0.9, 1.1), extent.speed * rng.uniform(0.9, 1.0)
    around = rng.choice([-1.0, 1.0]) * _travelled(t, speed / radius)
    flat_circle = np.stack([np.cos(around) - 1.0, np.sin(around), _tipped(around, rng)], axis=1)
    return radius * flat_circle + _FAST_HEIGHT, *_heading(t, rng)


def _fast_lemniscate(t: Array, extent: Extent, rng: np.random.Generator) -> Pose:
    """A figure eight (Gerono's) of 2.4 sizes, fastest in its middle, where it is at `speed` after 4 s."""
    size, speed = 1.2 * extent.size * rng.uniform(0.9, 1.1), extent.speed * rng.uniform(0.9, 1.0)
    around = rng.choice([-1.0, 1.0]) * _travelled(t, speed / (np.sqrt(2.0) * size))
    eight = np.stack([np.sin(around), np.sin(around) * np.cos(around), _tipped(around, rng)], axis=1)
    return size * eight + _FAST_HEIGHT, *_heading(t, rng)


def _travelled(t: Array, pulse: float) -> Array:
    """Angle (rad) after speeding up to `pulse` (rad/s) and before slowing down again."""
    rates = pulse * window(t, _SPEEDING_UP)
    return np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(t))])


def _tipped(around: Array, rng: np.random.Generator) -> Array:
    """Height over the size of a path on a plane that leans by up to 0.15 rad; 0 where it begins."""
    lean, towards = rng.uniform(0.05, 0.15), rng.uniform(0, 2 * np.pi)
    return lean * (np.sin(around + towards) - np.sin(towards))


def _heading(t: Array, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    return 0 * t, 0 * t, _wave(t, 0.6, 0.9, rng)


KINDS: dict[str, Callable[[Array, Extent, np.random.Generator], Pose]] = {
    "eight": _eight,
    "helix": _helix,
    "attitude": _attitude,
    "low": _low,
    "waypoints": _waypoints,
    "smooth_waypoints": _smooth_waypoints,
    "fast_circle": _fast_circle,
    "fast_lemniscate": _fast_lemniscate,
}
