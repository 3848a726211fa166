"""The first-order filter of an IMU, tau dy/dt = x - y: what it makes of a prediction, and what it was given.

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

_DEGREES = 40  # from which the moments of a slow filter are built down: what is left out there is below rounding


def before_lag(samples: Samples, lag: float) -> Array:
    """What a filter of time constant `lag` (s) was given, (m, 3), where its output was sampled: y + lag dy/dt."""
    if lag == 0.0 or len(samples.times) < 2:
        return samples.values
    values = np.ascontiguousarray(samples.values)
    return values + lag * _slope(samples.times, values, 3.0 * float(np.median(np.diff(samples.times))))


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
        out = _filtered(np.exp(-step[:, 0] / lag), at_rows, forcing)
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
    return basis @ moment


@njit(cache=True)
def _filtered(decay, values, forcing):
    out = np.empty_like(values)
    out[0] = values[0]
    for k in range(len(decay)):
        for c in range(values.shape[1]):
            moved = decay[k] * out[k, c] + forcing[k, c]
            # After a row that says nothing the filter starts anew.
            out[k + 1, c] = values[k + 1, c] if math.isnan(moved) else moved
    return out


@njit(cache=True)
def _slope(times, values, widest):
    """Derivative (m, c) at the samples: of the quartic through five neighbours, or of the line beside a gap."""
    m, count = values.shape
    out = np.zeros((m, count))
    for k in range(m):
        first = min(max(k - 2, 0), max(m - 5, 0))
        last = min(first + 5, m)
        for j in range(k, first, -1):
            if times[j] - times[j - 1] > widest:
                first = j
                break
        for j in range(k, last - 1):
            if times[j + 1] - times[j] > widest:
                last = j + 1
                break
        for a in range(first, last):
            weight = 0.0
            if a == k:
                for b in range(first, last):
                    if b != k:
                        weight += 1.0 / (times[k] - times[b])
            else:
                weight = 1.0 / (times[a] - times[k])
                for b in range(first, last):
                    if b != a and b != k:
                        weight *= (times[k] - times[b]) / (times[a] - times[b])
            for c in range(count):
                out[k, c] += weight * values[a, c]
    return out
