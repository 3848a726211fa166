"""The first-order filter of an IMU, tau dy/dt = x - y: what it makes of a prediction, and the slope that undoes it.

Between two rows the filter is solved exactly for the polynomial through a step's nodes, so that its error does not
grow where its time constant is short against the step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numba import njit

from infotraj.models.recorded import Recorded, Samples
from infotraj.rotations import Array

_BESIDE = 0.025  # s, on either side: a cubic over it keeps what a vehicle does up to 10 Hz
_DEGREES = 40  # from which the moments of a slow filter are built down: what is left out there is below rounding


def slope(samples: Samples) -> Array:
    """Derivative (m, c) of a channel where it was sampled, smoothed over 50 ms.

    Undoing a filter with the plain difference would raise the noise by the time constant over the step, and a fit
    would take a delay in place of a lag for that alone.
    """
    if len(samples.times) < 2:
        return np.zeros_like(samples.values)
    usual = float(np.median(np.diff(samples.times)))
    beside = max(_BESIDE, 2.0 * usual)
    return _slope(samples.times, np.ascontiguousarray(samples.values), beside * (1.0 + 1e-6), 3.0 * usual)


def as_sensed(recorded: Recorded, rows: Sequence[Array], lag: float) -> list[Array]:
    """Specific force, its mean, angular acceleration, its mean, each (n, 3), after the filter of a measured channel.

    rows: the true ones, then, where lag > 0 (s), what the filter takes up of force and turn in each step
    (`Timeline.forcing`). It starts settled on the first row.
    """
    if lag == 0.0:
        return list(rows)
    force, force_mean, turn, turn_mean, of_force, of_turn = rows
    sensed: list[Array] = []
    for channel, at_rows, mean, forcing in (
        (recorded.specific_force, force, force_mean, of_force),
        (recorded.rate, turn, turn_mean, of_turn),
    ):
        if channel is None or channel.derived:
            sensed += [at_rows, mean]
            continue
        step = np.diff(recorded.t)[:, None]
        out = filtered(np.exp(-step[:, 0] / lag), at_rows, forcing)
        averaged = np.full_like(mean, np.nan)
        averaged[:-1] = mean[:-1] - lag * np.diff(out, axis=0) / step
        sensed += [out, averaged]
    return sensed


@njit(cache=True)
def shares(length, lag, basis):
    """What a filter holds, a stretch of `length` (s) after 0, of the values at its nodes, (nodes,).

    basis (nodes, nodes): coefficients of each node's Lagrange polynomial, constant first, on 0..1. The integral of
    its powers against r exp(-r (1 - u)), r = length / lag, by recursion in the direction in which it is stable.
    """
    count, rate = len(basis), length / lag
    moment = np.empty(count)
    if rate < count:
        held = 0.0
        for degree in range(_DEGREES, 0, -1):
            held = rate / degree * (1.0 - held)
            if degree <= count:
                moment[degree - 1] = held
    else:
        moment[0] = 1.0 - math.exp(-rate)
        for degree in range(1, count):
            moment[degree] = 1.0 - degree / rate * moment[degree - 1]
    out = np.zeros(count)
    for node in range(count):
        for degree in range(count):
            out[node] += basis[node, degree] * moment[degree]
    return out


@njit(cache=True)
def filtered(decay, values, forcing):
    """A filter of first order from row to row (n, c): what decays of it, by `decay` (n - 1,), and `forcing` (n - 1, c).

    It starts settled on the first of `values` (n, c).
    """
    out = np.empty_like(values)
    for c in range(values.shape[1]):
        out[0, c] = values[0, c]
    for k in range(len(decay)):
        for c in range(values.shape[1]):
            moved = decay[k] * out[k, c] + forcing[k, c]
            # After a row that says nothing the filter starts anew.
            out[k + 1, c] = values[k + 1, c] if math.isnan(moved) else moved
    return out


@njit(cache=True)
def _slope(times, values, beside, widest):
    """Derivative (m, c) at the samples, of the cubic of least squares through those within `beside` (s), five at least.

    A step longer than `widest` (s) is a gap: what lies behind it does not count.
    """
    m, count = values.shape
    out = np.zeros((m, count))
    for k in range(m):
        first = last = k
        while first > 0 and times[first] - times[first - 1] <= widest:
            if k - first >= 2 and times[k] - times[first - 1] > beside:
                break
            first -= 1
        while last < m - 1 and times[last + 1] - times[last] <= widest:
            if last - k >= 2 and times[last + 1] - times[k] > beside:
                break
            last += 1
        size = min(4, last - first + 1)
        if size < 2:
            continue
        powers = np.ones((last - first + 1, size))
        normal = np.zeros((size, size))
        for j in range(first, last + 1):
            for degree in range(1, size):
                powers[j - first, degree] = powers[j - first, degree - 1] * (times[j] - times[k]) / beside
            for a in range(size):
                for b in range(size):
                    normal[a, b] += powers[j - first, a] * powers[j - first, b]
        row = _row_of_inverse(normal, 1)
        for j in range(first, last + 1):
            weight = 0.0
            for degree in range(size):
                weight += powers[j - first, degree] * row[degree] / beside
            for c in range(count):
                out[k, c] += weight * values[j, c]
    return out


@njit(cache=True)
def _row_of_inverse(normal, wanted):
    """Row `wanted` of the inverse of a small positive definite matrix (n, n), which is overwritten: by Cholesky.

    Written out because np.linalg.solve takes longer to compile than all else that a first run compiles for this.
    """
    n = len(normal)
    out = np.zeros(n)
    out[wanted] = 1.0
    for i in range(n):
        for j in range(i + 1):
            left = normal[i, j]
            for k in range(j):
                left -= normal[i, k] * normal[j, k]
            normal[i, j] = math.sqrt(left) if i == j else left / normal[j, j]
    for i in range(n):
        for k in range(i):
            out[i] -= normal[i, k] * out[k]
        out[i] /= normal[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            out[i] -= normal[k, i] * out[k]
        out[i] /= normal[i, i]
    return out
