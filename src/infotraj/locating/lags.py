"""The residual's memory, and its tie to commands over lags: what MATLAB's `resid` draws, and the delay it hints at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.rotations import Array

LONGEST = 0.5  # s
BLOCK = 2.0  # s
_SURE = 2.58  # 99 %, two-sided


@dataclass(frozen=True)
class Lags:
    """Correlations of one axis over lags, all flights together.

    lag (m,) s, from -LONGEST to LONGEST; auto (m,): of the residual with itself; cross (m,): of the residual with the
    rate of change of the predicted side, positive lags where the residual comes later; band: beyond it a correlation is
    unlikely chance (99 %, at one lag), for the number of independent values that the residual's memory leaves; filter
    (s): up to here the filter itself makes neighbours alike. delay (s): the shift of the prediction that takes most of
    the residual away, to first order, with its standard error over blocks; `late` where it is surely not 0 and takes
    away a part of the residual that matters (`share`).
    """

    axis: str
    lag: Array
    auto: Array
    cross: Array
    band: float
    filter: float
    delay: float
    standard_error: float
    share: float

    @property
    def late(self) -> bool:
        """True where measurement surely lags (or leads) the prediction, and that explains a fifth of the residual."""
        return abs(self.delay) > _SURE * self.standard_error and self.share > 0.2


def lags(errors: Sequence[EquationError]) -> list[Lags]:
    """One Lags an axis that can be answered."""
    found = []
    for a, axis in enumerate(AXES):
        series = [s for e in errors for s in _series(e, a)]
        if series:
            found.append(_of_axis(axis, series, errors[0].window))
    return found


def _series(error: EquationError, a: int) -> list[tuple[float, Array, Array]]:
    """Even stretches (step, residual, slope of the prediction) of one flight and axis."""
    rows = np.flatnonzero(error.scored[:, a])
    if len(rows) < 20:
        return []
    t = error.t[rows]
    step = float(np.median(np.diff(t)))
    pieces = np.split(rows, np.flatnonzero(np.diff(t) > 1.5 * step) + 1)
    mean = float(np.mean(error.residual[rows, a]))
    found = []
    for piece in pieces:
        if len(piece) * step > 2.0 * LONGEST:
            grid = np.arange(error.t[piece[0]], error.t[piece[-1]], step)
            residual, predicted = (
                np.interp(grid, error.t[piece], x) for x in (error.residual[piece, a] - mean, error.predicted[piece, a])
            )
            found.append((step, residual, np.gradient(predicted, step)))
    return found


def _of_axis(axis: str, series: list[tuple[float, Array, Array]], window: float) -> Lags:
    step = series[0][0]
    most = round(LONGEST / step)
    auto, cross = np.zeros(2 * most + 1), np.zeros(2 * most + 1)
    power, change, total = 0.0, 0.0, 0
    products, squares = [], []
    for dt, r, slope in series:
        if abs(dt - step) > 0.01 * step:
            continue
        slope = slope - slope.mean()
        power, change, total = power + float(r @ r), change + float(slope @ slope), total + len(r)
        auto += _correlated(r, r, most)
        cross += _correlated(r, slope, most)
        for k in range(0, len(r), max(1, round(BLOCK / dt))):
            part = slice(k, k + max(1, round(BLOCK / dt)))
            products.append(r[part] @ slope[part])
            squares.append(slope[part] @ slope[part])
    auto = auto / power if power > 0 else auto
    cross = cross / np.sqrt(power * change) if power * change > 0 else cross
    independent = total / max(1.0, np.sum(auto**2))
    products_, squares_ = np.array(products), np.array(squares)
    gain = products_.sum() / squares_.sum() if squares_.sum() > 0 else 0.0
    scatter = np.sqrt(np.sum((products_ - gain * squares_) ** 2)) / max(squares_.sum(), 1e-300)
    share = gain**2 * change / power if power > 0 else 0.0
    # A measurement that lags by d is y(t - d) = y - d y': the residual is minus d times the slope.
    return Lags(
        axis, step * np.arange(-most, most + 1, dtype=float), auto, cross, _SURE / np.sqrt(independent), window,
        float(-gain), float(scatter), float(share),
    )  # fmt: skip


def _correlated(later: Array, earlier: Array, most: int) -> Array:
    """Sums of later[i + k] earlier[i] for k from -most to most."""
    from scipy.signal import correlate

    full = correlate(later, earlier, mode="full", method="fft")
    middle = len(earlier) - 1
    out = np.zeros(2 * most + 1)
    low, high = max(0, middle - most), min(len(full), middle + most + 1)
    out[low - (middle - most) : high - (middle - most)] = full[low:high]
    return out
