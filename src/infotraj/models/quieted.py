"""The IMU's samples without what is faster than the motion that poses show as well.

How a prediction changes with the clock of the IMU is the derivative of its samples: of noise and vibration a large one,
so that these would tell the clock wherever it is, and surely (errors in variables; Fuller, "Measurement Error Models",
1987). What moves goes with the poses: the coherence of the two says up to which frequency (Bendat and Piersol, "Random
data", 2010, 6.1).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from infotraj.importing.resample import gap_limit
from infotraj.models.recorded import Samples
from infotraj.rotations import Array

_WINDOW = 2.0  # s of a spectrum
_FEWEST = 64  # rows of a stretch: of fewer no spectrum is told
_SHARED = 0.8  # of what two sensors show, that is one motion: a quarter of it beside is noise
_PERIODS = 2  # of the fastest frequency, by which a stretch is mirrored beyond its ends
_FAST = 0.8  # of half the rate: a filter that near to it is none


def fastest(t: Array, recorded: Array, by_imu: Array) -> float:
    """The frequency (Hz) up to which what poses and the IMU say of the same steps is one motion, on any axis.

    recorded, by_imu (n, 3): rates of change from row to row, t (n,) s. Infinite where the rows are too few to say.
    """
    both = np.concatenate([recorded, by_imu], axis=1)
    runs = [x for x in _stretches(t, np.isfinite(both).all(axis=1)) if len(x) >= _FEWEST]
    if not runs:
        return np.inf
    step = float(np.median(np.diff(t)))
    width = int(min(max(_WINDOW / step, _FEWEST), *(len(x) for x in runs)))
    one, two, cross = 0.0, 0.0, 0.0
    for x in runs:
        a, b = both[x, :3], both[x, 3:]
        frequency, power = signal.welch(a, 1.0 / step, nperseg=width, detrend="linear", axis=0)
        one = one + len(x) * power
        two = two + len(x) * signal.welch(b, 1.0 / step, nperseg=width, detrend="linear", axis=0)[1]
        cross = cross + len(x) * signal.csd(a, b, 1.0 / step, nperseg=width, detrend="linear", axis=0)[1]
    shared = np.abs(cross) ** 2 / np.maximum(one * two, 1e-300)
    for k in range(1, len(frequency)):
        octave = (frequency >= frequency[k]) & (frequency <= 2.0 * frequency[k])
        if (shared[octave].mean(axis=0) < _SHARED).all():
            return float(frequency[k])
    return np.inf


def quieted(samples: Samples, cut: float) -> Samples:
    """The samples after a low-pass without phase at `cut` (Hz): Butterworth's of fourth order, forwards and backwards.

    Stretches between gaps are filtered apart; short ones stay as they are.
    """
    share = 2.0 * samples.usual * cut
    if not share < _FAST:
        return samples
    low = signal.butter(4, share, output="sos")
    values = samples.values.copy()
    for r in _stretches(samples.times, np.ones(len(samples.times), dtype=bool)):
        if len(r) >= _FEWEST:
            beyond = min(len(r) - 1, round(_PERIODS * 2.0 / share))
            values[r] = signal.sosfiltfilt(low, samples.values[r], axis=0, padlen=beyond)
    return replace(samples, values=values)


def _stretches(t: Array, used: NDArray) -> list[NDArray]:
    """Indices of the rows that are used, in stretches between gaps."""
    rows = np.flatnonzero(used)
    if len(rows) < 2:
        return [rows]
    return np.split(rows, np.flatnonzero(np.diff(t[rows]) > gap_limit(t)) + 1)
