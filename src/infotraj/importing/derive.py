"""What a log does not hold but implies: velocity from position, angular velocity from attitude.

Central differences of second order on uneven steps; never across a gap, where the difference is one-sided.
"""

from __future__ import annotations

import numpy as np

from infotraj import rotations
from infotraj.rotations import Array

VELOCITY_RULE = "central difference of the position"
RATE_RULE = "central difference of the attitude, log(q[k]^-1 q[k+1]) over the step, body axes"


def velocity(t: Array, position: Array, limit: float) -> Array:
    """Velocity (n, 3) in the position's axes; `limit` (s) is the longest step that is no gap."""
    return _per_run(t, position, limit, lambda t, p: np.gradient(p, t, axis=0))


def rate(t: Array, attitude: Array, limit: float) -> Array:
    """Angular velocity (n, 3), rad/s, body axes, of attitudes (n, 4)."""
    return _per_run(t, attitude, limit, _rate)


def _rate(t: Array, q: Array) -> Array:
    step = rotations.log(rotations.multiply(rotations.conjugate(q[:-1]), q[1:])) / np.diff(t)[:, None]
    out = np.empty((t.size, 3))
    out[0], out[-1] = step[0], step[-1]
    # The mean of both sides' rates, each weighted with the other's length, is second order on uneven steps.
    before, after = np.diff(t)[:-1, None], np.diff(t)[1:, None]
    out[1:-1] = (step[:-1] * after + step[1:] * before) / (before + after)
    return out


def _per_run(t: Array, values: Array, limit: float, rule: object) -> Array:
    out = np.full((t.size, 3), np.nan)
    good = np.flatnonzero(np.isfinite(values).all(axis=1))
    if good.size == 0:
        return out
    breaks = np.flatnonzero(np.diff(t[good]) > limit) + 1
    for run in np.split(good, breaks):
        if run.size >= 2:
            out[run] = rule(t[run], values[run])  # type: ignore[operator]
    return out
