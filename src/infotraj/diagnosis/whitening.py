"""Whitening: the same linear filter on a residual and on every sensitivity, so that what is left of the noise is white.

A difference of noisy samples is filtered by the innovations of a local level model (Durbin and Koopman, "Time series
analysis by state space methods", 2012, 2.2): the samples are level plus white noise, the level walks at random with
what the model does not know. Its gain is 0 where only the sensor is noisy, and near 1 where the process dominates. An
autoregression by Yule and Walker takes what colour is left (sensor filters, turbulence), its order by AICc (Hurvich and
Tsai 1989). Both restart with every run, whose first samples are left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz

from infotraj.rotations import Array

MOST = 20
_CLEARLY = 20.0  # in AICc: what an axis must say for a gain of its own
_GAINS = (1.0, 0.7, 0.5, 0.3, 0.2, 0.12, 0.07, 0.04, 0.02, 0.01, 0.005, 0.002)


@dataclass(frozen=True)
class Whitener:
    """Filter of one axis of one channel.

    gain: of the local level (None for a level channel); coefficients (p,): of the autoregression; deviation: standard
    deviation of its innovations in the channel's unit; white: that of the noise without colour, for comparison.
    """

    gain: float | None
    coefficients: Array
    deviation: float

    def apply(self, values: Array, run: NDArray) -> Array:
        """Whitened values (m, c) in units of the noise; rows that a run needs to start are 0."""
        out = np.empty(values.shape)
        self.into(np.ascontiguousarray(values), run, out)
        return out

    def into(self, values: Array, run: NDArray, out: Array) -> None:
        """The same, written to `out` (m, c)."""
        x = _innovations(values, run, self.gain) if self.gain is not None else values
        _filtered(x, run, self.coefficients, 1.0 / self.deviation, out)

    def used(self, run: NDArray) -> NDArray:
        """Which samples count: all but the first p of every run."""
        return place_in_run(run) >= len(self.coefficients)


def estimate(residuals: list[Array], runs: list[NDArray], difference: bool, most: int = MOST) -> tuple[Whitener, ...]:
    """The whiteners of a channel's axes from residuals (m, axes) of several flights.

    The axes of a channel share their gain, which short flights hardly show, unless one clearly has another.
    """
    axes = range(residuals[0].shape[1])
    gains = _GAINS if difference else (None,)
    tried = [[_tried([r[:, i : i + 1] for r in residuals], runs, gain, most) for gain in gains] for i in axes]
    scores = np.array([[score for score, _ in axis] for axis in tried])
    common = int(np.argmin(scores.sum(axis=0)))
    own = [int(np.argmin(axis)) if axis[common] - axis.min() > _CLEARLY else common for axis in scores]
    return tuple(axis[k][1] for axis, k in zip(tried, own, strict=True))


def _tried(values: list[Array], runs: list[NDArray], gain: float | None, most: int) -> tuple[float, Whitener]:
    """AICc of a gain with the autoregression that goes with it, and the two as a filter. values: (m, 1) a flight."""
    values = [np.ascontiguousarray(v) for v in values]
    filtered = values if gain is None else [_innovations(v, r, gain) for v, r in zip(values, runs, strict=True)]
    coefficients, variance = _autoregression([v[:, 0] for v in filtered], runs, most)
    found = Whitener(gain, coefficients, _positive(variance, values))
    # The innovations' own variance decides: the filter has a unit leading coefficient, so its likelihood is that.
    # Flights whose every stretch is too short for it have no say.
    used = [(v, r, found.used(r)) for v, r in zip(values, runs, strict=True)]
    parts = [np.mean(found.apply(v, r)[rows] ** 2) for v, r, rows in used if rows.any()]
    left = max(np.mean(parts), 1e-300) if parts else np.inf
    count = sum(map(len, values))
    return float(count * np.log(found.deviation**2 * left) + _charge(len(coefficients), count)), found


def place_in_run(run: NDArray) -> NDArray:
    """Place of each sample in its run, from 0."""
    starts = np.flatnonzero(np.concatenate([[True], np.diff(run) != 0]))
    return np.arange(len(run)) - np.repeat(starts, np.diff(np.append(starts, len(run))))


def _positive(variance: float, values: list[Array]) -> float:
    size = max((float(np.abs(v).max(initial=0.0)) for v in values), default=0.0)
    return float(np.sqrt(max(variance, (1e-9 * size) ** 2, 1e-24)))


def _autoregression(values: list[Array], runs: list[NDArray], most: int) -> tuple[Array, float]:
    """Coefficients a of x[k] = a_1 x[k-1] + ... + e[k], and the variance of e."""
    count = sum(len(v) for v in values)
    most = int(min(most, max(0, count // 50)))
    lagged = np.zeros(most + 1)
    for x, run in zip(values, runs, strict=True):
        for lag in range(most + 1):
            same = run[lag:] == run[: len(run) - lag]
            lagged[lag] += np.sum(x[lag:] * x[: len(x) - lag] * same)
    lagged /= count
    if lagged[0] <= 0:
        return np.zeros(0), 0.0
    best = (np.inf, np.zeros(0), lagged[0])
    for p in (0, 1, 2, 3, 4, 6, 8, 12, 16, 20):
        if p > most:
            break
        a = solve_toeplitz(lagged[:p], lagged[1 : p + 1]) if p else np.zeros(0)
        variance = lagged[0] - a @ lagged[1 : p + 1]
        if variance <= 0:
            break
        score = count * np.log(variance) + _charge(p, count)
        if score < best[0]:
            best = (score, a, variance)
    return best[1], float(best[2])


def _charge(order: int, count: int) -> float:
    """What AICc charges for an autoregression of this order and its variance."""
    return 2 * (order + 1) * count / max(count - order - 2, 1)


@njit(cache=True)
def _innovations(values, run, gain):
    """e[k] = d[k] + (1 - g[k-1]) e[k-1], g by Riccati's equation from an unknown first level, each scaled alike."""
    m, c = values.shape
    out = np.empty((m, c))
    walk = gain * gain / max(1.0 - gain, 1e-6)
    steady = 0.5 * (walk + np.sqrt(walk * walk + 4.0 * walk))  # variance of the predicted level, noise 1
    size, g, p = 1.0, 0.0, 1.0
    for k in range(m):
        new = k == 0 or run[k] != run[k - 1]
        p = 1.0 + walk if new else p * (1.0 - g) + walk
        now = np.sqrt((steady + 1.0) / (p + 1.0))
        for j in range(c):
            carried = 0.0 if new else (1.0 - g) * out[k - 1, j] / size
            out[k, j] = (values[k, j] + carried) * now
        g = p / (p + 1.0)
        size = now
    return out


@njit(cache=True, fastmath=True)
def _filtered(x, run, a, scale, out):
    m, c = x.shape
    p = len(a)
    place = 0
    for k in range(m):
        place = 0 if k == 0 or run[k] != run[k - 1] else place + 1
        if place < p:
            for j in range(c):
                out[k, j] = 0.0
            continue
        for j in range(c):
            out[k, j] = x[k, j] * scale
        for i in range(p):
            weight = a[i] * scale
            for j in range(c):
                out[k, j] -= weight * x[k - 1 - i, j]
