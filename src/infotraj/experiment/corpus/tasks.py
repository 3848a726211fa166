"""What the corpus's exact vehicles fly: paths at 1 kHz, from rest on the ground and back to it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from infotraj.experiment.corpus.exact_flyer import STEP
from infotraj.rotations import Array

REST, RISE, SETTLE = 2.0, 2.5, 1.0
_STANDING_HEIGHT = 0.05  # m, of the body's origin: legs
Motion = Callable[[Array, float, float, np.random.Generator], tuple[Array, Array]]


def path(task: str, seconds: float, room: float, speed: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Positions (n, 3) in m and yaw (n,) in rad a STEP: rest, take-off, `task` for `seconds`, and, half of the time,
    landing. room: m, half the extent; speed: m/s, the greatest of the task."""
    t = np.arange(0.0, seconds, STEP)
    moved, yaw = TASKS[task](t, room, speed, rng)
    # away and back no faster than the task itself (the greatest slope of the ease is 2.2)
    away, back = (max(2.0, 2.2 * float(np.linalg.norm(moved[k])) / speed) for k in (0, -1))
    ease = _ease(t / away) * _ease((seconds - t) / back)
    moved, yaw = ease[:, None] * moved, ease * yaw
    height = rng.uniform(0.8, 1.5) + max(0.0, -float(moved[:, 2].min()))
    rise = np.zeros((round((REST + RISE + SETTLE) / STEP), 3))
    rise[:, 2] = height * _ease((np.arange(len(rise), dtype=float) * STEP - REST) / RISE)
    parts, turns = [rise, moved + np.array([0.0, 0.0, height])], [np.zeros(len(rise)), yaw]
    if rng.random() < 0.5:
        down = np.zeros((round((2.0 + height / 0.4) / STEP), 3))
        down[:, 2] = height * (1.0 - _ease(np.arange(len(down), dtype=float) * STEP / (height / 0.4)))
        parts.append(down)
        turns.append(np.zeros(len(down)))
    place = np.array([*rng.uniform(-0.5, 0.5, 2), _STANDING_HEIGHT])
    return np.concatenate(parts) + place, np.concatenate(turns) + rng.uniform(-np.pi, np.pi)


def _hover(t: Array, room: float, speed: float, rng: np.random.Generator) -> tuple[Array, Array]:
    return np.zeros((len(t), 3)), np.zeros(len(t))


def _eight(t: Array, room: float, speed: float, rng: np.random.Generator) -> tuple[Array, Array]:
    # Gerono's lemniscate is fastest at its centre: room x rate x sqrt(2)
    rate = speed / (np.sqrt(2.0) * room)
    turned = rng.uniform(-np.pi, np.pi)
    x, y = room * np.sin(rate * t), 0.5 * room * np.sin(2.0 * rate * t)
    c, s = np.cos(turned), np.sin(turned)
    z = 0.15 * room * np.sin(0.7 * rate * t)
    yaw = rng.uniform(0.0, 0.8) * np.sin(0.5 * rate * t)
    return np.stack([c * x - s * y, s * x + c * y, z], axis=-1), yaw


def _wander(t: Array, room: float, speed: float, rng: np.random.Generator) -> tuple[Array, Array]:
    # sums of sines in every direction, scaled to the speed; the nose turns as it likes
    w = rng.uniform(0.4, 1.6, (4, 4))
    phase = rng.uniform(-np.pi, np.pi, (4, 4))
    waves = np.sin(w[..., None] * t + phase[..., None]).sum(axis=1)
    moved = np.stack([waves[0], waves[1], 0.4 * waves[2]], axis=-1)
    moved *= speed / np.linalg.norm(np.gradient(moved, STEP, axis=0), axis=1).max()
    return moved, 0.4 * waves[3]


def _steps(t: Array, room: float, speed: float, rng: np.random.Generator) -> tuple[Array, Array]:
    # a new place every 3 s, reached at up to `speed`; a new heading every other time
    count = int(t[-1] // 3.0) + 2
    reach = min(room, 0.5 * speed)
    places = rng.uniform(-1.0, 1.0, (count, 3)) * [reach, reach, 0.4 * reach]
    headings = np.repeat(rng.uniform(-1.5, 1.5, count), 2)[:count]
    k = (t // 3.0).astype(int)
    ease = _ease((t % 3.0) / 1.2)
    moved = places[k] + ease[:, None] * (places[k + 1] - places[k])
    return moved, headings[k] + ease * (headings[k + 1] - headings[k])


def _vertical(t: Array, room: float, speed: float, rng: np.random.Generator) -> tuple[Array, Array]:
    # up and down alone: it hardly turns
    rate = rng.uniform(0.6, 1.2)
    moved = np.zeros((len(t), 3))
    moved[:, 2] = min(speed, 1.5) / rate * np.sin(rate * t)
    return moved, np.zeros(len(t))


TASKS: dict[str, Motion] = {
    "hover": _hover,
    "gentle eight": _eight,
    "fast eight": _eight,
    "wander": _wander,
    "steps": _steps,
    "vertical": _vertical,
}


def _ease(x: Array) -> Array:
    """0 to 1 with three continuous derivatives."""
    x = np.clip(x, 0.0, 1.0)
    return x**4 * (35.0 - 84.0 * x + 70.0 * x**2 - 20.0 * x**3)
