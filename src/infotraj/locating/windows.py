"""Windows in time in which the error stands out, worst first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.comparing.floor import AT_FLOOR

LENGTH = 1.0  # s
LEAST_RATIO = AT_FLOOR  # RMS in a window over that of the rest of the flight and over the floor
ALPHA = 0.01


@dataclass(frozen=True)
class TimeWindow:
    """From start to stop (s) of a flight: the axis's RMS there, over the rest of the flight (ratio), and over the
    floor."""

    flight: int
    axis: str
    start: float
    stop: float
    rms: float
    ratio: float
    over_floor: float
    share: float


def worst_windows(errors: Sequence[EquationError], *, most: int = 10) -> list[TimeWindow]:
    """Windows of 1 s, neighbours joined, whose error stands out of the rest of their flight and of the floor.

    Under noise alone a window's squared error over the floor's square is chi-squared with about three degrees of
    freedom a filter window; the limit holds for all windows, axes and flights together (Bonferroni).
    """
    tries = sum(max(1, int((e.t[-1] - e.t[0]) / LENGTH)) for e in errors) * len(AXES)
    found: list[TimeWindow] = []
    for k, error in enumerate(errors):
        freedom = max(1.0, 3.0 * LENGTH / error.window) * 0.5
        limit = max(LEAST_RATIO**2, float(special.chdtri(freedom, ALPHA / tries)) / freedom)
        slot = np.floor((error.t - error.t[0]) / LENGTH).astype(int)
        for a in range(len(AXES)):
            found += _of_axis(error, k, a, slot, limit)
    return sorted(found, key=lambda w: -w.over_floor)[:most]


def _of_axis(error: EquationError, flight: int, a: int, slot, limit: float) -> list[TimeWindow]:
    scored = error.scored[:, a]
    if not scored.any() or not error.floor[a] > 0:
        return []
    residual = np.where(scored, error.residual[:, a] - error.residual[scored, a].mean(), 0.0)
    number = np.bincount(slot, scored)
    squares = np.bincount(slot, residual**2)
    full = number >= 0.3 * np.median(number[number > 0])
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(full, squares / number, np.nan)
    rest = np.nanmedian(mean)
    high = full & (mean > limit * error.floor[a] ** 2) & (mean > LEAST_RATIO**2 * rest)
    windows = []
    for start, stop in _runs(high):
        n, total = number[start:stop].sum(), squares[start:stop].sum()
        rms = float(np.sqrt(total / n))
        others = (squares.sum() - total) / max(number.sum() - n, 1.0)
        windows.append(
            TimeWindow(
                flight,
                AXES[a],
                float(error.t[0] + start * LENGTH),
                float(min(error.t[0] + stop * LENGTH, error.t[-1])),
                rms,
                rms / float(np.sqrt(others)) if others > 0 else float("inf"),
                rms / float(error.floor[a]),
                float(total / squares.sum()),
            )
        )
    return windows


def _runs(flags) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
