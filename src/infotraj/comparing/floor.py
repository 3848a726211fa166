"""The noise floor: the error that measurement noise alone leaves, estimated from the flight itself.

White noise on samples shows in their high differences, which a smooth motion and a smooth model error leave alone: the
difference-based estimate of a variance (Hall, Kay, Titterington 1990, after von Neumann 1941), here with third
differences of measured minus predicted samples. Passed through the known gain of the filter it is the floor. Where
the samples' noise is not white (a smoothed velocity, an estimator's output), neighbours say too little: `colour`
shows it, and the floor is taken from the filtered residual itself, third differences one window apart. Everything
that changes within half a second and that the model does not explain then counts as noise.
"""

from __future__ import annotations

from math import comb

import numpy as np

from infotraj.rotations import Array

ORDER = 3
_BINOMIAL = np.array([(-1.0) ** k * comb(ORDER, k) for k in range(ORDER + 1)])
_EVEN = 0.25  # differences are taken where the steps differ by less than this share
# 1.4826 x the median of |x| is the standard deviation of normal x: a spike, or a jump of the motion, does not move it.
_NORMAL = 1.4826
_SPIKED = 1.3
AT_FLOOR = 1.5  # times the floor: an error within it makes no window in time stand out
RED = 1.3  # noise seen over part of the window this many times that of neighbours is not white


def white_noise(t: Array, x: Array, lag: int = 1) -> Array:
    """Standard deviation (c,) of white noise on the samples x (n, c) at times t, from differences `lag` samples apart.

    NaN with fewer than 8 differences.
    """
    span = ORDER * lag
    if len(t) <= span:
        return np.full(x.shape[1], np.nan)
    step = np.median(np.diff(t)) * lag
    pieces = [x[k * lag : len(x) - span + k * lag] for k in range(ORDER + 1)]
    differences = sum(c * piece for c, piece in zip(_BINOMIAL, pieces, strict=True))
    total = t[span:] - t[: len(t) - span]
    even = np.abs(total - ORDER * step) < _EVEN * ORDER * step
    differences = differences[even & np.isfinite(differences).all(axis=1)]
    if len(differences) < 8:
        return np.full(x.shape[1], np.nan)
    robust = _NORMAL * np.median(np.abs(differences), axis=0)
    plain = np.sqrt(np.mean(differences**2, axis=0))
    # The plain estimate is the sharper one; spikes show as a plain estimate far above the robust one. A channel that
    # repeats its values has a median of 0, which says nothing.
    chosen = np.where((robust > 0.0) & (plain > _SPIKED * robust), robust, plain)
    return chosen / np.sqrt(np.sum(_BINOMIAL**2))


def fast_part(t: Array, filtered: Array, window: float) -> Array:
    """Standard deviation (c,) of the part of a filtered residual (n, c) that changes from one window (s) to the next.

    NaN with too few rows; rows that are NaN are left out.
    """
    good = np.isfinite(filtered).all(axis=1)
    if good.sum() < 2:
        return np.full(filtered.shape[1], np.nan)
    step = float(np.median(np.diff(t[good])))
    return white_noise(t[good], filtered[good], max(1, round(window / step)))


def colour(t: Array, x: Array, lag: int) -> Array:
    """Noise found with differences `lag` samples apart over that of neighbours, (c,): 1 for white noise, more for
    red."""
    near = white_noise(t, x)
    return white_noise(t, x, lag) / np.where(near > 0.0, near, np.nan)
