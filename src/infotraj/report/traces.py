"""Measured and predicted wrench of every flight, for every combination of effects, small enough for one page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from infotraj.comparing.equation_error import AXES
from infotraj.locating.windows import TimeWindow
from infotraj.report.combinations import Combinations
from infotraj.report.series import reduced
from infotraj.report.squeezing import squeezed, step, unsqueezed
from infotraj.rotations import Array

NUMBERS = 1_300_000  # that all series of a page may hold; one to two characters each
FEWEST, MOST = 300, 2400  # points a series
_CLOSE = 0.5  # of the budget: the windows that stand out, in full
AROUND = 2.0  # s before and after a window
_LONGEST = 20.0  # s of a window that are shown in full
_FINE = 1 / 32  # of the noise floor: the step in which a wrench is kept
_TIME = 1e-6  # s


def flight_traces(found: Combinations, paths: Sequence[str], windows: Sequence[TimeWindow]) -> dict[str, Any]:
    """The series of all flights, and closer ones of the worst windows of flights that had to be reduced; peak: the
    largest measured value of each axis. `read_part` reads one.

    t counts from the first row of the part that is used, s. `left` (measured minus predicted) stands apart where a
    series was reduced: the extremes of a difference are not the difference of extremes.
    """
    shown = [i for i in range(len(AXES)) if any(e.scored[:, i].any() for e in found.made[0].errors)]
    columns = 1 + 2 * len(found.made)
    numbers = NUMBERS / max(1, len(shown) * columns)
    most = int(np.clip((1 - _CLOSE) * numbers / max(1, len(paths)), FEWEST, MOST))
    near = int(np.clip(_CLOSE * numbers / max(1, len(windows)), FEWEST, MOST))
    flights = [_part(found, k, shown, most) for k in range(len(paths))]
    close = [
        None if flights[w.flight]["bucket"] is None else _part(found, w.flight, shown, near, (w.start, w.stop))
        for w in windows
    ]
    peak = {AXES[i]: max(_peak(e.measured[:, i]) for e in found.made[0].errors) for i in shown}
    return {"axes": [AXES[i] for i in shown], "peak": peak, "flights": flights, "windows": close}


def read_part(part: dict[str, Any]) -> dict[str, Any]:
    """t (n,) and, for each axis, measured (n,), model (combinations, n) and, where it stands apart, left; N, N m."""
    each = 1 + (2 if part["left"] else 1) * part["models"]
    steps = [s for name, s in part["steps"].items() for _ in range(1 if name == "t" else each)]
    if not steps:
        return {"t": np.zeros(0), "axes": {}}
    held, axes = unsqueezed(part["numbers"], np.array(steps)), {}
    for k, name in enumerate(list(part["steps"])[1:]):
        own = held[1 + k * each : 1 + (k + 1) * each]
        axes[name] = {"measured": own[0], "model": own[1 : 1 + part["models"]]}
        if part["left"]:
            axes[name]["left"] = own[1 + part["models"] :]
    return {"t": held[0], "axes": axes}


def _part(
    found: Combinations, flight: int, shown: Sequence[int], most: int, span: tuple[float, float] | None = None
) -> dict[str, Any]:
    models = len(found.made)
    if not shown:
        return {"bucket": None, "models": models, "left": False, "steps": {}, "numbers": ""}
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
    columns, steps, each = [at], {"t": step(at, _TIME)}, 1 + 2 * models
    for k, i in enumerate(shown):
        own = values[:, k * each : (k + 1) * each if small else k * each + 1 + models]
        columns += list(own.T)
        steps[AXES[i]] = step(own, _FINE * float(found.floor[i]))
    wide = [s for name, s in steps.items() for _ in range(1 if name == "t" else (len(columns) - 1) // len(shown))]
    return {
        "bucket": float(2 * (at[1] - at[0])) if small else None,
        "models": models,
        "left": small,
        "steps": steps,
        "numbers": squeezed(np.stack(columns), np.array(wide)),
    }


def _peak(values: Array) -> float:
    return float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))
