"""Instants at which a prediction is evaluated: one for each row, and two between rows for means over the step.

The means use Gauss' formula with two points on every stretch without a jump of a command, so their error is of
fourth order in the stretch. A delayed command jumps between rows: the step is cut there. Where the sensors are
filtered, a stretch has four points, and the filter is solved for the cubic through them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numba import njit

from infotraj.models.sensor_lag import shares
from infotraj.rotations import Array


@dataclass(frozen=True)
class Timeline:
    """time (N,) s, increasing; row (n,): which of them are the rows' own; weight (N,): of the mean over the step.

    lagged (N,): weight of what a filter of the sensors takes up over the step; zeros where there is none.
    """

    time: Array
    row: Array
    weight: Array
    lagged: Array

    def at_rows(self, values: Array) -> Array:
        """Values (N, c) at the rows, (n, c)."""
        return values[self.row]

    def means(self, values: Array) -> Array:
        """Mean of values (N, c) from each row to the next, (n, c); NaN in the last row."""
        return self._summed(values, self.weight)

    def forcing(self, values: Array) -> Array:
        """What the sensors' filter takes up of values (N, c) from each row to the next, (n, c); NaN in the last row."""
        return self._summed(values, self.lagged)

    def _summed(self, values: Array, weight: Array) -> Array:
        total = _sums(values, weight, self.row)
        total[-1] = np.nan
        return total


def timeline(rows: Array, jumps: Array, lag: float = 0.0, coarse: bool = False) -> Timeline:
    """The timeline of rows (n,) s with commands that jump at `jumps` (m,) s, both increasing.

    lag (s): time constant of the sensors' filter; coarse: one point on every stretch, its middle: for how a prediction
    changes, which need not be as exact as what it says.
    """
    places, weights, basis = _nodes(1 if coarse else 4 if lag > 0.0 else 2)
    given = np.ascontiguousarray(rows, dtype=float), np.ascontiguousarray(jumps, dtype=float)
    return Timeline(*_timeline(*given, places, weights, lag, basis))


@cache
def _nodes(count: int) -> tuple[Array, Array, Array]:
    """Places and weights (count,) of Gauss' formula on 0..1, and coefficients (count, count) of each node's Lagrange
    polynomial, constant first; not to be written to."""
    places, weights = np.polynomial.legendre.leggauss(count)
    places = (1.0 + places) / 2
    basis = np.linalg.inv(np.vander(places, increasing=True)).T
    return places, weights / 2, np.ascontiguousarray(basis, dtype=float)


@njit(cache=True)
def _sums(values, weight, first):
    """Weighted sums of values (N, c) from each of the places `first` (n,) to the next, (n, c)."""
    count, columns = len(first), values.shape[1]
    out = np.zeros((count, columns))
    for k in range(count):
        for i in range(first[k], first[k + 1] if k + 1 < count else len(values)):
            for j in range(columns):
                out[k, j] += values[i, j] * weight[i]
    return out


@njit(cache=True)
def _timeline(rows, jumps, places, weights, lag, basis):
    n, nodes = len(rows), len(places)
    size = (1 + nodes) * n + nodes * len(jumps)
    time, weight, row = np.empty(size), np.zeros(size), np.empty(n, dtype=np.int64)
    lagged = np.zeros(size)
    count, j = 0, 0
    for k in range(n):
        row[k] = count
        time[count] = rows[k]
        count += 1
        if k == n - 1:
            break
        start, stop, step = rows[k], rows[k + 1], rows[k + 1] - rows[k]
        near = 1e-6 * step
        while j < len(jumps) and jumps[j] <= start + near:
            j += 1
        while True:
            end = stop
            if j < len(jumps) and jumps[j] < stop - near:
                end = jumps[j]
                j += 1
            for i in range(nodes):
                time[count + i] = start + places[i] * (end - start)
                weight[count + i] = weights[i] * (end - start) / step
            if lag > 0.0:
                held, decay = shares(end - start, lag, basis), math.exp(-(stop - end) / lag)
                for i in range(nodes):
                    lagged[count + i] = held[i] * decay
            count += nodes
            if end == stop:
                break
            start = end
    return time[:count], row, weight[:count], lagged[:count]
