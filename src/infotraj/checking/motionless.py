"""Where a vehicle stands: its sensors show no motion, and its motors, if the log has them, do not change."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from infotraj.flight import COMMANDED_FORCE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.rotations import Array, Mask

SPAN = 1.0  # s that are judged together
CELL = 0.1  # s; white noise is averaged over it
# No real vehicle hovers so calmly: turning (rad/s), share of its specific force that changes, moving (m, m/s).
STILL_RATE = 0.05
STILL_FORCE = 0.015
STILL_PLACE = 0.02
STILL_SPEED = 0.1
# Motors that a controller moves change by more than this share of their level within SPAN.
STILL_MOTORS = 1e-3


def motionless_rows(flight: Flight) -> Mask:
    """Rows (n,) bool in seconds of no motion at all; none where the log has no inertial sensor.

    Motors that a controller moves fly, however calm the sensors are. Motors that run, with sensors that do not change
    in the last bit, are a simulation without noise: it may hover so.
    """
    t = flight.t
    out = np.zeros(len(t), dtype=bool)
    inertial = [g for g in (RATE, SPECIFIC_FORCE) if flight.has(*g)]
    if not inertial or t[-1] - t[0] < SPAN:
        return out
    # the rest at the end, shorter than SPAN, belongs to the last whole one
    part = np.minimum(((t - t[0]) / SPAN).astype(int), int((t[-1] - t[0]) / SPAN) - 1)
    cell = ((t - t[0]) / CELL).astype(int)
    motors = _motors(flight)
    level = float(np.nanpercentile(np.abs(motors), 95)) if motors is not None and np.isfinite(motors).any() else 0.0
    # what gaps leave of a second says little
    calm = np.bincount(part) > 0.5 * SPAN / float(np.median(np.diff(t)))
    exact = np.ones(part[-1] + 1, dtype=bool)
    for columns, limit in (
        (RATE, STILL_RATE),
        (SPECIFIC_FORCE, STILL_FORCE),
        (POSITION, STILL_PLACE),
        (VELOCITY, STILL_SPEED),
    ):
        if not flight.has(*columns):
            continue
        x = flight.get(*columns)
        spread, raw = _spread(_means(x, cell), part), _spread(x, part)
        if columns == SPECIFIC_FORCE:
            limit = limit * float(np.nanmedian(np.linalg.norm(x, axis=1)))
        calm &= spread <= limit
        if columns in inertial:
            exact &= raw == 0.0
    if motors is not None and level > 0:
        calm &= (_spread(motors, part) <= STILL_MOTORS * level) & ~exact
    return calm[part]


def _motors(flight: Flight) -> Array | None:
    for prefix in ("rotor_", "cmd_rotor_"):
        rotors = flight.numbered(prefix)
        if rotors.shape[1] and np.isfinite(rotors).any():
            return rotors
    return flight.get(*COMMANDED_FORCE) if flight.has(*COMMANDED_FORCE) else None


def _means(x: Array, cell: NDArray[np.intp]) -> Array:
    """The mean of x (n, c) over the rows of each cell, (n, c); NaN where a cell has no sample."""
    good = np.isfinite(x)
    out = np.empty_like(x)
    for c in range(x.shape[1]):
        count = np.bincount(cell, good[:, c])
        total = np.bincount(cell, np.where(good[:, c], x[:, c], 0.0))
        out[:, c] = np.where(count > 0, total / np.maximum(count, 1), np.nan)[cell]
    return out


def _spread(x: Array, part: NDArray[np.intp]) -> Array:
    """Largest minus smallest value in each part, the largest over the columns, (parts,); 0 where there is none."""
    low = np.full((part[-1] + 1, x.shape[1]), np.inf)
    high = -low
    np.minimum.at(low, part, np.where(np.isfinite(x), x, np.inf))
    np.maximum.at(high, part, np.where(np.isfinite(x), x, -np.inf))
    return np.where(np.isfinite(low), high - low, 0.0).max(axis=1)
