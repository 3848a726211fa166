"""What a log does not hold but implies: velocity from position, angular velocity from attitude.

Central differences on a grid that is even between gaps; never across a gap, where the difference is one-sided. A
receiver's stamps jitter about the even instants at which the sensor read, and a difference over a jittering step is too
large in the mean: by 2 % for a jitter of 8 % of a step. Of such a run it is asked which times make the motion smoother,
the stamps or even ones; samples at uneven true times are put on an even grid between them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from infotraj import rotations
from infotraj.importing.resample import gap_limit
from infotraj.rotations import Array

VELOCITY_RULE = "central difference of the position"
RATE_RULE = "central difference of the attitude, log(q[k]^-1 q[k+1]) over the step, body axes"
Rule = Callable[[Array, float], Array]
_EVEN = 1e-3  # of a step: stamps this close to an even grid are on it


def velocity(t: Array, position: Array, limit: float) -> Array:
    """Velocity (n, 3) in the position's axes; `limit` (s) is the longest step of the rows that is no gap."""
    return slope(t, position, _between_samples(t, position, limit))


def slope(t: Array, values: Array, limit: float) -> Array:
    """Derivative (n, k), per second, of values (n, k) at times t (n,), s; NaN where a sample stands alone.

    limit: s, longest step that is no gap.
    """
    return _per_run(t, values, limit, slope_rule)


def rate(t: Array, attitude: Array, limit: float) -> Array:
    """Angular velocity (n, 3), rad/s, body axes, of attitudes (n, 4); `limit` as in `velocity`."""
    good = np.isfinite(attitude).all(axis=1)
    q = np.full_like(attitude, np.nan)
    q[good] = rotations.continuous(rotations.normalize(attitude[good]))
    return _per_run(t, q, _between_samples(t, q, limit), rate_rule)[:, :3]


def _between_samples(t: Array, values: Array, limit: float) -> float:
    """The longest step (s) between samples that is no gap: they may stand in every fifth row of a faster sensor's."""
    sampled = t[np.isfinite(values).all(axis=1)]
    return max(limit, gap_limit(sampled)) if sampled.size > 2 else limit


def slope_rule(values: Array, step: float) -> Array:
    """Derivative (n, k) of values (n, k), n >= 2, at an even step (s)."""
    return np.gradient(values, step, axis=0)


def rate_rule(q: Array, step: float) -> Array:
    """Angular velocity (n, 3), rad/s, body axes, of continuous attitudes (n, 4), n >= 2, at an even step (s)."""
    q = rotations.normalize(q)
    turn = rotations.log(rotations.multiply(rotations.conjugate(q[:-1]), q[1:])) / step
    return np.concatenate([turn[:1], 0.5 * (turn[:-1] + turn[1:]), turn[-1:]])


def on_even_grid(t: Array, values: Array, limit: float, rule: Rule) -> tuple[Array, Array]:
    """Times (m,), s, and what `rule` makes of values (n, k) there, on a grid that is even between gaps."""
    runs = [_of_run(t[run], values[run], rule) for run in _runs(t, values, limit)]
    if not runs:
        return np.zeros(0), np.zeros((0, 3))
    return np.concatenate([grid for grid, _ in runs]), np.concatenate([found for _, found in runs])


def _per_run(t: Array, values: Array, limit: float, rule: Rule) -> Array:
    out = np.full(values.shape, np.nan)
    for run in _runs(t, values, limit):
        grid, found = _of_run(t[run], values[run], rule)
        out[run, : found.shape[1]] = np.stack([np.interp(t[run], grid, x) for x in found.T], axis=1)
    return out


def _runs(t: Array, values: Array, limit: float) -> list[NDArray[np.intp]]:
    good = np.flatnonzero(np.isfinite(values).all(axis=1))
    breaks = np.flatnonzero(np.diff(t[good]) > limit) + 1
    return [run for run in np.split(good, breaks) if run.size >= 2]


def _of_run(t: Array, values: Array, rule: Rule) -> tuple[Array, Array]:
    k = np.concatenate([[0], np.cumsum(np.maximum(np.rint(np.diff(t) / np.median(np.diff(t))), 1))]).astype(int)
    step, first = np.polyfit(k, t, 1) if len(t) > 2 else (float(t[1] - t[0]), float(t[0]))
    grid = first + step * np.arange(k[-1] + 1)
    off = np.abs(t - grid[k]).max() / step
    if off < _EVEN and len(grid) == len(t):
        return t, rule(values, step)
    if off >= 0.5 or _roughness(t, values, k) <= _roughness(grid[k], values, k):
        step = float(t[-1] - t[0]) / k[-1]
        grid = t[0] + step * np.arange(k[-1] + 1)
        when = t
    else:
        when = grid[k]
    return grid, rule(np.stack([np.interp(grid, when, x) for x in values.T], axis=1), step)


def _roughness(t: Array, values: Array, k: NDArray[np.intp]) -> float:
    """Median square of the second divided differences of values (n, k) at times t (n,), where no sample is lost."""
    slopes = np.diff(values, axis=0) / np.diff(t)[:, None]
    second = np.diff(slopes, axis=0) / (t[2:] - t[:-2])[:, None]
    near = (np.diff(k)[1:] == 1) & (np.diff(k)[:-1] == 1)
    return float(np.median(np.sum(second[near] ** 2, axis=1))) if near.any() else 0.0
