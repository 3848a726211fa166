"""Samples at their own times put into rows at other times, by the rules of `channels`; what no rule covers is NaN."""

from __future__ import annotations

from typing import Any

import numpy as np

from infotraj import rotations
from infotraj.importing.channels import Resample
from infotraj.rotations import Array

_SAME_S = 1e-7  # stamps this close are one instant: below the resolution of any log's clock


def gap_limit(t: Array) -> float:
    """Longest step (s) between samples that is no gap: 1.5 median periods, more where the stream jitters, at most 5.

    The jitter is 1.4826 x the median absolute deviation of the steps, which one lost sample in two does not move.
    """
    if t.size < 3:
        return float("inf") if t.size < 2 else 1.5 * float(t[1] - t[0])
    step = np.diff(t)
    median = float(np.median(step))
    jitter = 1.4826 * float(np.median(np.abs(step - median)))
    return min(1.5 * median + 6.0 * jitter, 5.0 * median) * (1.0 + 1e-9)


def gaps(t: Array, limit: float) -> list[tuple[float, float]]:
    """(start, end) in s of every step longer than `limit`."""
    found = np.flatnonzero(np.diff(t) > limit)
    return [(float(t[k]), float(t[k + 1])) for k in found]


def put(rows: Array, t: Array, values: Array, rule: Resample, limit: float) -> Array:
    """Samples `values` (n, k) at `t` (n,) as (rows, k); NaN where no sample reaches the row.

    `limit` (s) is the longest step that is bridged.
    """
    if t.size == 0:
        return np.full((rows.size, values.shape[1]), np.nan)
    if t.size == rows.size and np.array_equal(t, rows):
        return values
    if rule == "mean":
        return _mean(rows, t, values, limit)
    if rule == "hold":
        return _hold(rows, t, values, limit)
    if rule == "sample":
        return _sample(rows, t, values)
    return _between(rows, t, values, limit, slerp=rule == "slerp")


def _between(rows: Array, t: Array, values: Array, limit: float, slerp: bool) -> Array:
    out = np.full((rows.size, values.shape[1]), np.nan)
    left = np.searchsorted(t, rows + _SAME_S, side="right") - 1
    at = (left >= 0) & (np.abs(rows - t[np.maximum(left, 0)]) <= _SAME_S)
    out[at] = values[left[at]]
    inside = np.flatnonzero(~at & (left >= 0) & (left < t.size - 1))
    inside = inside[t[left[inside] + 1] - t[left[inside]] <= limit]
    k = left[inside]
    share = ((rows[inside] - t[k]) / (t[k + 1] - t[k]))[:, None]
    if slerp:
        step = rotations.log(rotations.multiply(rotations.conjugate(values[k]), values[k + 1]))
        out[inside] = rotations.multiply(values[k], rotations.exp(share * step))
    else:
        out[inside] = values[k] + share * (values[k + 1] - values[k])
    return out


def _hold(rows: Array, t: Array, values: Array, limit: float) -> Array:
    out = np.full((rows.size, values.shape[1]), np.nan)
    left = np.searchsorted(t, rows + _SAME_S, side="right") - 1
    good = (left >= 0) & (rows < _until(t, limit)[np.maximum(left, 0)] - _SAME_S)
    out[good] = values[left[good]]
    return out


def _until(t: Array, limit: float) -> Array:
    """When each held value ends: at the next sample; before a gap, and at the end, after one median period."""
    if not np.isfinite(limit):
        return np.append(t[1:], np.inf)
    period = float(np.median(np.diff(t))) if t.size > 1 else limit
    step = np.append(np.diff(t), np.inf)
    return np.where(step <= limit, t + step, t + period)


def _sample(rows: Array, t: Array, values: Array) -> Array:
    out = np.full((rows.size, values.shape[1]), np.nan)
    half = 0.5 * float(np.median(np.diff(rows))) if rows.size > 1 else _SAME_S
    right = np.clip(np.searchsorted(rows, t), 1, max(rows.size - 1, 1))
    nearest = np.where(t - rows[right - 1] <= rows[np.minimum(right, rows.size - 1)] - t, right - 1, right)
    nearest = np.minimum(nearest, rows.size - 1)
    good = (np.abs(t - rows[nearest]) <= half + _SAME_S) & np.isfinite(values).all(axis=1)
    out[nearest[good]] = values[good]
    return out


def _mean(rows: Array, t: Array, values: Array, limit: float) -> Array:
    period = float(np.median(np.diff(rows))) if rows.size > 1 else limit
    row_limit = gap_limit(rows)
    ends = np.append(rows[1:], rows[-1] + period)
    ends = np.where(ends - rows > row_limit, rows + period, ends)
    first = np.searchsorted(t, rows + _SAME_S, side="right") - 1
    last = np.searchsorted(t, ends - _SAME_S, side="left") - 1
    until = np.minimum(_until(t, limit), np.maximum(ends[-1], t))
    out = np.empty((rows.size, values.shape[1]))
    for column in range(values.shape[1]):
        out[:, column] = _held_mean(rows, ends, t, until, values[:, column])
        # One value throughout the row needs no arithmetic, and stays as it was logged, to the last bit.
        one = np.flatnonzero((first == last) & (first >= 0) & np.isfinite(out[:, column]))
        out[one, column] = values[first[one], column]
    return out


def _held_mean(rows: Array, ends: Array, t: Array, until: Array, u: Array) -> Array:
    """Mean of the held signal over [rows, ends); NaN where it covers less than half of the row."""
    good = np.isfinite(u)
    lasting = np.where(good, until - t, 0.0)
    knots = np.stack([t, t + lasting], axis=-1).ravel()
    covered = np.repeat(np.cumsum(lasting), 2)
    covered[0::2] -= lasting
    weight = np.where(good, u, 0.0)
    integral = np.repeat(np.cumsum(lasting * weight), 2)
    integral[0::2] -= lasting * weight
    coverage = _at(ends, knots, covered) - _at(rows, knots, covered)
    total = _at(ends, knots, integral) - _at(rows, knots, integral)
    enough = coverage >= 0.5 * (ends - rows)
    return np.where(enough, total / np.where(enough, coverage, 1.0), np.nan)


def _at(x: Array, knots: Array, values: Any) -> Array:
    return np.interp(x, knots, values)
