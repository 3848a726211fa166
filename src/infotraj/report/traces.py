"""Measured and predicted wrench of every flight, for every combination of effects, small enough for one page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from infotraj.comparing.equation_error import AXES
from infotraj.locating.windows import TimeWindow
from infotraj.report.combinations import Combinations
from infotraj.report.series import packed, reduced
from infotraj.rotations import Array

BUDGET = 7_000_000  # characters that all series of a page may take
FEWEST, MOST = 300, 2400  # points a series
_CLOSE = 0.5  # of the budget: the windows that stand out, in full
AROUND = 2.0  # s before and after a window
_LONGEST = 20.0  # s of a window that are shown in full


def flight_traces(found: Combinations, paths: Sequence[str], windows: Sequence[TimeWindow]) -> dict[str, Any]:
    """The series of all flights, and closer ones of the worst windows of flights that had to be reduced.

    t counts from the flight's first row, s. `left` (measured minus predicted) stands apart where a series was reduced:
    the extremes of a difference are not the difference of extremes.
    """
    shown = [i for i in range(len(AXES)) if any(e.scored[:, i].any() for e in found.made[0].errors)]
    columns = 1 + 2 * len(found.made)
    numbers = 0.75 * BUDGET / 4 / max(1, len(shown) * columns)
    most = int(np.clip((1 - _CLOSE) * numbers / max(1, len(paths)), FEWEST, MOST))
    near = int(np.clip(_CLOSE * numbers / max(1, len(windows)), FEWEST, MOST))
    flights = [_part(found, k, shown, most) for k in range(len(paths))]
    close = [
        None if flights[w.flight]["bucket"] is None else _part(found, w.flight, shown, near, (w.start, w.stop))
        for w in windows
    ]
    return {"axes": [AXES[i] for i in shown], "flights": flights, "windows": close}


def _part(
    found: Combinations, flight: int, shown: Sequence[int], most: int, span: tuple[float, float] | None = None
) -> dict[str, Any]:
    if not shown:
        return {"t": packed(np.zeros(0)), "bucket": None, "axes": {}}
    t = found.made[0].errors[flight].t
    rows = np.arange(len(t))
    if span is not None:
        stop = min(span[1], span[0] + _LONGEST)
        rows = np.flatnonzero((t >= span[0] - AROUND) & (t <= stop + AROUND))
    since = t[rows] - t[0]
    every: list[Array] = []
    for i in shown:
        errors = [m.errors[flight] for m in found.made]
        measured = errors[0].measured[rows, i]
        predicted = [np.where(np.isfinite(measured), e.predicted[rows, i], np.nan) for e in errors]
        measured = np.where(np.isfinite(predicted[0]), measured, np.nan)
        every += [measured, *predicted, *(measured - p for p in predicted)]
    at, values = reduced(since, np.stack(every, axis=1), most)
    small = len(at) < len(since)
    each = 1 + 2 * len(found.made)
    axes = {}
    for k, i in enumerate(shown):
        own = [packed(values[:, k * each + c]) for c in range(each)]
        models = len(found.made)
        axes[AXES[i]] = {"measured": own[0], "model": own[1 : 1 + models]}
        if small:
            axes[AXES[i]]["left"] = own[1 + models :]
    return {"t": packed(at), "bucket": float(2 * (at[1] - at[0])) if small else None, "axes": axes}
