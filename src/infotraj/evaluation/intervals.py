"""Intervals for what is repeated over seeds: the bootstrap over paired runs, plants as strata."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from infotraj.rotations import Array

RESAMPLES = 10_000
_SEED = 20210101  # the interval of a given table is always the same


@dataclass(frozen=True)
class Interval:
    """A mean with its 95 % interval and the number of runs behind it."""

    mean: float
    low: float
    high: float
    runs: int


def bootstrap_mean(values: ArrayLike, strata: ArrayLike | None = None, level: float = 0.95) -> Interval:
    """Percentile bootstrap (Efron and Tibshirani 1993, ch. 13) of the mean of `values` (n,), one a run.

    `strata` (n,) are resampled within themselves and weigh alike: the plants are three fixed individuals, the seeds are
    what varies. Paired comparisons hand in the differences.
    """
    values = np.asarray(values, dtype=float)
    groups = np.zeros(len(values), dtype=int) if strata is None else np.unique(strata, return_inverse=True)[1]
    rng = np.random.default_rng(_SEED)
    means: list[float] = []
    resampled: list[Array] = []
    for group in range(groups.max() + 1):
        part = values[groups == group]
        means.append(float(part.mean()))
        resampled.append(part[rng.integers(len(part), size=(RESAMPLES, len(part)))].mean(axis=1))
    tail = 50.0 * (1.0 - level)
    low, high = np.percentile(np.mean(resampled, axis=0), [tail, 100.0 - tail])
    return Interval(float(np.mean(means)), float(low), float(high), len(values))
