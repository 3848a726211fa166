"""Gauss-Markov processes: slow errors, as filters and wind have them (Gelb, Applied Optimal Estimation, 1974)."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from infotraj.rotations import Array


def gauss_markov(count: int, step: float, time: float, rng: np.random.Generator, width: int = 3) -> Array:
    """Unit variance, first order, correlation time `time` (s), (count, width) samples `step` (s) apart."""
    keep = np.exp(-step / time)
    driven = np.sqrt(1.0 - keep**2) * rng.standard_normal((count, width))
    driven[0] = rng.standard_normal(width)
    return lfilter([1.0], [1.0, -keep], driven, axis=0)


def smooth_gauss_markov(count: int, step: float, time: float, rng: np.random.Generator, width: int = 3) -> Array:
    """The same of second order: its derivative is finite (rms 1 / time), as an estimator's error is, which a smooth
    prediction carries from one correction to the next."""
    spare = min(int(6 * time / step), 4 * count)
    keep = np.exp(-step / time)
    rough = gauss_markov(count + spare, step, time, rng, width)
    smooth = lfilter([1.0 - keep], [1.0, -keep], rough, axis=0)[spare:]
    # of the variance of a first-order process the second, equal lag passes this share
    return smooth / np.sqrt((1.0 + keep**2) / (1.0 + keep) ** 2)
