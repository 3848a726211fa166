"""The one filter of the equation error: a least-squares slope over a window, and the mean over time that goes with it.

A slope over a window is a weighted mean of the derivative, with parabolic weights (Lanczos' differentiator). What is
sampled (an accelerometer) passes the mean with the same parabola. Both are written for samples at any times, so a lost
message widens a window and does not bend it; both sides of a comparison pass them at the same samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from infotraj.rotations import Array

GAP = 3.5  # a step longer than so many median steps is a gap, and no window reaches over it
FEWEST = 1  # samples on either side of a window's centre


@dataclass(frozen=True)
class Window:
    """Windows of 2 `half` + 1 samples around each of the times t (n,) s, none of them across a gap.

    `whole` (n,) says where a window lies inside the samples; elsewhere results are NaN.
    """

    t: Array
    half: int
    whole: Array

    @classmethod
    def over(cls, t: Array, seconds: float, step: float | None = None) -> Window:
        """Windows of about `seconds` on samples at t (n,); `step` (s) where the usual one is known otherwise."""
        t = np.ascontiguousarray(t, dtype=float)
        if len(t) < 2:
            return cls(t, FEWEST, np.zeros(len(t), dtype=bool))
        step = float(np.median(np.diff(t))) if step is None else step
        half = max(FEWEST, round(seconds / step / 2))
        return cls(t, half, _whole(t, half, GAP * step))

    def slope(self, x: Array) -> Array:
        """Least-squares slope of x (n, c) in each window, (n, c), unit of x per s."""
        return _slope(self.t, np.ascontiguousarray(x, dtype=float), self.half, self.whole)

    def mean(self, x: Array) -> Array:
        """Mean of x (n, c) in each window with parabolic weights, (n, c)."""
        return _mean(self.t, np.ascontiguousarray(x, dtype=float), self.half, self.whole)

    def slope_gain(self) -> Array:
        """Standard deviation (1/s) of each slope for unit white noise on the samples, (n,)."""
        return _gains(self.t, self.half, self.whole)[0]

    def mean_gain(self) -> Array:
        """Standard deviation of each mean for unit white noise on the samples, (n,)."""
        return _gains(self.t, self.half, self.whole)[1]


@njit(cache=True)
def _whole(t, half, gap):
    n = len(t)
    good = np.zeros(n, dtype=np.bool_)
    start = 0
    for i in range(1, n + 1):
        if i == n or t[i] - t[i - 1] > gap:
            for k in range(start + half, i - half):
                good[k] = True
            start = i
    return good


@njit(cache=True)
def _slope(t, x, half, whole):
    n, width = x.shape
    out = np.full((n, width), np.nan)
    for i in range(n):
        if not whole[i]:
            continue
        middle = 0.0
        for k in range(i - half, i + half + 1):
            middle += t[k] - t[i]
        middle /= 2 * half + 1
        square = 0.0
        for c in range(width):
            out[i, c] = 0.0
        for k in range(i - half, i + half + 1):
            apart = t[k] - t[i] - middle
            square += apart * apart
            for c in range(width):
                out[i, c] += apart * (x[k, c] - x[i, c])
        for c in range(width):
            out[i, c] /= square
    return out


@njit(cache=True)
def _weight(t, i, k, half):
    # The parabola vanishes one mean step outside the window, as the slope's own weights do.
    left, right = t[i] - t[i - half], t[i + half] - t[i]
    reach = max(left, right) * (half + 1) / half
    apart = (t[k] - t[i]) / reach
    return 1.0 - apart * apart


@njit(cache=True)
def _mean(t, x, half, whole):
    n, width = x.shape
    out = np.full((n, width), np.nan)
    for i in range(n):
        if not whole[i]:
            continue
        total = 0.0
        for c in range(width):
            out[i, c] = 0.0
        for k in range(i - half, i + half + 1):
            w = _weight(t, i, k, half)
            total += w
            for c in range(width):
                out[i, c] += w * x[k, c]
        for c in range(width):
            out[i, c] /= total
    return out


@njit(cache=True)
def _gains(t, half, whole):
    n = len(t)
    slope, mean = np.full(n, np.nan), np.full(n, np.nan)
    for i in range(n):
        if not whole[i]:
            continue
        middle = 0.0
        for k in range(i - half, i + half + 1):
            middle += t[k] - t[i]
        middle /= 2 * half + 1
        square, total, squares = 0.0, 0.0, 0.0
        for k in range(i - half, i + half + 1):
            square += (t[k] - t[i] - middle) ** 2
            w = _weight(t, i, k, half)
            total += w
            squares += w * w
        slope[i] = 1.0 / np.sqrt(square)
        mean[i] = np.sqrt(squares) / total
    return slope, mean
