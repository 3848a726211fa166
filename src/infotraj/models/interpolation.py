"""Recorded channels between their samples."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from infotraj.rotations import Array


def interpolate(times: ArrayLike, samples: ArrayLike, at: ArrayLike) -> Array:
    """Values (N, c) at sorted times `at` (N,) of samples (m, c) at `times` (m,): the cubic through four neighbours.

    At a sample's own time it is that sample. Where neighbours lie more than three usual intervals apart (a gap), the
    straight line; outside the samples the nearest one. Lagrange's formula; the error is of fourth order.
    """
    times = np.ascontiguousarray(times, dtype=float)
    samples = np.ascontiguousarray(samples, dtype=float)
    at = np.ascontiguousarray(at, dtype=float)
    if len(times) == 1:
        return np.broadcast_to(samples[0], (len(at), samples.shape[1])).copy()
    return _interpolate(times, samples, at, 3.0 * float(np.median(np.diff(times))))


@njit(cache=True)
def _interpolate(times, samples, at, widest):
    m, c = samples.shape
    out = np.empty((len(at), c))
    k = 0
    for n in range(len(at)):
        x = at[n]
        while k < m - 2 and times[k + 1] <= x:
            k += 1
        if x <= times[0] or x >= times[m - 1]:
            end = 0 if x <= times[0] else m - 1
            for j in range(c):
                out[n, j] = samples[end, j]
            continue
        if x == times[k]:
            for j in range(c):
                out[n, j] = samples[k, j]
            continue
        i = min(max(k - 1, 0), max(m - 4, 0))
        wide = m < 4
        if not wide:
            for j in range(i, i + 3):
                wide = wide or times[j + 1] - times[j] > widest
        if wide:
            u = (x - times[k]) / (times[k + 1] - times[k])
            for j in range(c):
                out[n, j] = (1 - u) * samples[k, j] + u * samples[k + 1, j]
            continue
        for j in range(c):
            out[n, j] = 0.0
        for a in range(i, i + 4):
            weight = 1.0
            for b in range(i, i + 4):
                if b != a:
                    weight *= (x - times[b]) / (times[a] - times[b])
            for j in range(c):
                out[n, j] += weight * samples[a, j]
    return out
