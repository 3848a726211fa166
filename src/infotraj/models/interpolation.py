"""Recorded channels between their samples."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from infotraj.rotations import Array


def interpolate(times: ArrayLike, samples: ArrayLike, at: ArrayLike, usual: float | None = None) -> Array:
    """Values (N, c) at sorted times `at` (N,) of samples (m, c) at `times` (m,): the cubic through four neighbours.

    At a sample's own time it is that sample. Where neighbours lie more than three usual intervals apart (a gap), the
    straight line; outside the samples the nearest one. usual: that interval, s; the median where it is not given.
    Lagrange's formula; the error is of fourth order.
    """
    times = np.ascontiguousarray(times, dtype=float)
    samples = np.ascontiguousarray(samples, dtype=float)
    at = np.ascontiguousarray(at, dtype=float)
    if len(times) == 1:
        return np.broadcast_to(samples[0], (len(at), samples.shape[1])).copy()
    return _interpolate(times, samples, at, 3.0 * (float(np.median(np.diff(times))) if usual is None else usual))


@njit(cache=True)
def _interpolate(times, samples, at, widest):
    m, c = samples.shape
    out = np.empty((len(at), c))
    share = np.empty(4)  # one over the product of a neighbour's distances from the other three
    weight = np.empty(4)
    k, last, wide = 0, -1, False
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
        if i != last:
            last, wide = i, m < 4
            if not wide:
                for j in range(i, i + 3):
                    wide = wide or times[j + 1] - times[j] > widest
            if not wide:
                for a in range(4):
                    product = 1.0
                    for b in range(4):
                        if b != a:
                            product *= times[i + a] - times[i + b]
                    share[a] = 1.0 / product
        if wide:
            u = (x - times[k]) / (times[k + 1] - times[k])
            for j in range(c):
                out[n, j] = (1 - u) * samples[k, j] + u * samples[k + 1, j]
            continue
        first, second = (x - times[i]) * (x - times[i + 1]), (x - times[i + 2]) * (x - times[i + 3])
        weight[0], weight[1] = (x - times[i + 1]) * second * share[0], (x - times[i]) * second * share[1]
        weight[2], weight[3] = first * (x - times[i + 3]) * share[2], first * (x - times[i + 2]) * share[3]
        for j in range(c):
            total = 0.0
            for a in range(4):
                total += weight[a] * samples[i + a, j]
            out[n, j] = total
    return out
