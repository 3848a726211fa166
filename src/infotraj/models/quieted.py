"""The IMU's samples without what is faster than the motion in them.

How a prediction changes with the clock of the IMU is the derivative of its samples: of noise and vibration a large one,
so that these would tell the clock wherever it is, and surely (errors in variables; Fuller, "Measurement Error Models",
1987). What moves goes with the poses: their cross-spectrum says which share of what the IMU shows is motion (Bendat and
Piersol, "Random data", 2010, 6.1).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from infotraj.importing.resample import gap_limit
from infotraj.models.recorded import Samples
from infotraj.rotations import Array

_WINDOW = 2.0  # s of a spectrum
_FEWEST = 64  # rows of a stretch: of fewer no spectrum is told
_MOTION = 0.8  # of what the IMU shows: with less a quarter of it and more is noise
_SURE = 2.0  # standard errors
_PERIODS = 2  # of the fastest frequency, by which a stretch is mirrored beyond its ends
_FAST = 0.8  # of half the rate: a filter that near to it is none


def fastest(t: Array, recorded: Array, by_imu: Array) -> float:
    """The frequency (Hz) from which on what the IMU says of steps is surely no motion for the most part, on any axis.

    recorded, by_imu (n, 3): rates of change from row to row by poses and by the IMU, t (n,) s. Noise of the poses makes
    the share of motion unsure, not small: infinite where they cannot say, and where the rows are too few.
    """
    both = np.concatenate([recorded, by_imu], axis=1)
    runs = [x for x in _stretches(t, np.isfinite(both).all(axis=1)) if len(x) >= _FEWEST]
    if not runs:
        return np.inf
    from scipy import signal  # late: it takes as long to import as all the rest

    step = float(np.median(np.diff(t)))
    width = int(min(max(_WINDOW / step, _FEWEST), *(len(x) for x in runs)))
    how = {"fs": 1.0 / step, "nperseg": width, "detrend": "linear", "axis": 0}
    sums = [len(x) * np.stack([signal.csd(a, b, **how)[1] for a, b in _pairs(both[x])]) for x in runs]
    pose, imu, cross = np.sum(sums, axis=0) / sum(len(x) for x in runs)
    frequency = np.linspace(0.0, 0.5 / step, len(pose))
    windows = sum(len(x) for x in runs) / width
    for k in range(1, len(frequency)):
        octave = (frequency >= frequency[k]) & (frequency <= 2.0 * frequency[k])
        shown = np.maximum(imu[octave].mean(axis=0).real, 1e-300)
        share = np.abs(cross[octave].mean(axis=0)) / shown
        error = np.sqrt(pose[octave].mean(axis=0).real / shown / (windows * octave.sum()))
        if (share + _SURE * error < _MOTION).all():
            return float(frequency[k])
    return np.inf


def _pairs(both: Array) -> list[tuple[Array, Array]]:
    """What is held against what: poses, the IMU, and one against the other."""
    a, b = both[:, :3], both[:, 3:]
    return [(a, a), (b, b), (a, b)]


def quieted(samples: Samples, cut: float) -> Samples:
    """The samples after a low-pass without phase at `cut` (Hz): Butterworth's of fourth order, forwards and backwards.

    Stretches between gaps are filtered apart; short ones stay as they are.
    """
    share = 2.0 * samples.usual * cut
    if not share < _FAST:
        return samples
    from scipy import signal  # late, as above

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
