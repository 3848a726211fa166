"""Instants at which a prediction is evaluated: one for each row, and two between rows for means over the step.

The means use Gauss' formula with two points on every stretch without a jump of a command, so their error is of
fourth order in the stretch. A delayed command jumps between rows: the step is cut there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from infotraj.rotations import Array


@dataclass(frozen=True)
class Timeline:
    """time (N,) s, increasing; row (n,): which of them are the rows' own; weight (N,): of the mean over the step."""

    time: Array
    row: Array
    weight: Array

    def at_rows(self, values: Array) -> Array:
        """Values (N, c) at the rows, (n, c)."""
        return values[self.row]

    def means(self, values: Array) -> Array:
        """Mean of values (N, c) from each row to the next, (n, c); NaN in the last row."""
        total = np.add.reduceat(values * self.weight[:, None], self.row, axis=0)
        total[-1] = np.nan
        return total


def timeline(rows: Array, jumps: Array) -> Timeline:
    """The timeline of rows (n,) s with commands that jump at `jumps` (m,) s, both increasing."""
    time, row, weight = _timeline(np.ascontiguousarray(rows), np.ascontiguousarray(jumps))
    return Timeline(time, row, weight)


@njit(cache=True)
def _timeline(rows, jumps):
    n = len(rows)
    size = 3 * n + 2 * len(jumps)
    time, weight, row = np.empty(size), np.zeros(size), np.empty(n, dtype=np.int64)
    low, high = 0.5 - np.sqrt(3.0) / 6, 0.5 + np.sqrt(3.0) / 6
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
            for place in (low, high):
                time[count] = start + place * (end - start)
                weight[count] = 0.5 * (end - start) / step
                count += 1
            if end == stop:
                break
            start = end
    return time[:count], row, weight[:count]
