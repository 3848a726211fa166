"""Where the model fails, as the page tells it: axis by flight, residual against named quantities, worst windows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.comparing.statistics import statistics
from infotraj.locating import sentences
from infotraj.locating.healthy import Beside
from infotraj.locating.lags import LONGEST, lags
from infotraj.locating.locating import Located
from infotraj.locating.places import Place
from infotraj.locating.ranges import by_range, place_spans
from infotraj.report.combinations import Combinations
from infotraj.report.series import packed
from infotraj.rotations import Array

MOST_PLACES = 6
_MATTERS = 0.05  # share of the squared error
_FAR = 2.0  # times its spread: a mean that is taken off
MOST_POINTS = 1200  # of a place that are drawn; its mean and RMS are of all


def heat(found: Combinations, names: Sequence[str]) -> dict[str, Any]:
    """RMSE over one floor (`Combinations.floors`), axis by flight, as given and with all supported effects, each flight
    under numbers that were fitted without it."""
    rmse = (np.array([statistics([e]).rmse for e in m.errors]) for m in (found.made[0], found.made[-1]))
    with np.errstate(invalid="ignore", divide="ignore"):
        before, after = (r / found.floors for r in rmse)
    shown = [i for i in range(len(AXES)) if np.isfinite(before[:, i]).any()]
    return {
        "flights": list(names),
        "rows": [
            {
                "axis": AXES[i],
                "cells": [
                    {"before": _number(a), "after": _number(b)} for a, b in zip(before[:, i], after[:, i], strict=True)
                ],
            }
            for i in shown
        ],
    }


def places(located: Located, healthy: Beside | None) -> list[dict[str, Any]]:
    """The places that stand out, worst first, with the rows that the search used."""
    return [
        _place(p, located, None if healthy is None else sentences.healthy_sentence(p, healthy.places[k]))
        for k, p in enumerate(located.places[:MOST_PLACES])
    ]


def windows(located: Located, names: Sequence[str]) -> list[dict[str, Any]]:
    """The worst windows in time; from and to count from the first row of the part that is used, s."""
    return [
        {
            "flight": w.flight,
            "name": names[w.flight],
            "axis": w.axis,
            "from": w.start - float(located.errors[w.flight].t[0]),
            "to": w.stop - float(located.errors[w.flight].t[0]),
            "rms": w.rms,
            "ratio": _number(w.ratio),
            "over_floor": w.over_floor,
            "share": w.share,
        }
        for w in located.windows
    ]


def offsets(located: Located) -> list[dict[str, Any]]:
    """Axes that are off by the same everywhere, where that is a part of their error that matters."""
    return [{"axis": axis, "bias": bias, "share": share} for axis, bias, share in located.offsets if share > _MATTERS]


def leftover(errors: Sequence[EquationError]) -> list[dict[str, Any]]:
    """Correlations over lags of what these errors leave, an axis each."""
    rows = []
    for k in lags(errors):
        beyond = np.abs(k.lag) > k.filter
        rows.append(
            {
                "axis": k.axis,
                "lag": packed(k.lag),
                "auto": packed(k.auto),
                "cross": packed(k.cross),
                "band": float(k.band),
                "filter": k.filter,
                "largest_auto": _largest(k.auto[beyond]),
                "largest_cross": _largest(k.cross),
                # Beyond the longest lag it is no delay: the prediction hardly changes there.
                "delay": k.delay if abs(k.delay) < LONGEST else None,
                "standard_error": k.standard_error if abs(k.delay) < LONGEST else None,
                "share": k.share,
                "late": k.late,
            }
        )
    return rows


def _place(place: Place, located: Located, healthy: str | None) -> dict[str, Any]:
    samples = next(f.samples for f in located.found if place.axis in f.samples.axes)
    x, y = place.quantity.values, samples.residual[:, samples.axes.index(place.axis)]
    off = _far_off(y)
    y = y - off
    middle, mean, rms = by_range(x, y)
    every = -(-len(x) // MOST_POINTS)
    low, high = (float(v) for v in np.percentile(x, [0.3, 99.7]))
    real = place.region is not None and place.region.low > 1.0
    return {
        "axis": place.axis,
        "unit": place.unit,
        "quantity": place.quantity.name,
        "quantity_unit": place.quantity.unit,
        "sentence": sentences.place_sentence(place),
        "healthy": healthy,
        "floor": place.floor,
        "explained": place.explained,
        "every": every,
        "x": packed(x[::every]),
        "y": packed(y[::every]),
        "middle": packed(middle),
        "mean": packed(mean),
        "rms": packed(rms),
        "low": low,
        "high": high,
        "off": off,
        **_reach(y, np.concatenate([mean, rms]), place.floor),
        "spans": place_spans(place.region, low, high) if real and place.region is not None else [],
    }


def _far_off(y: Array) -> float:
    """The mean of a residual that is off by far more than it varies, else 0: with it nothing else could be seen."""
    mean = float(np.mean(y))
    return mean if abs(mean) > _FAR * np.percentile(np.abs(y - mean), 99.5) else 0.0


def _reach(y: Array, drawn: Array, floor: float) -> dict[str, float]:
    """From where to where an axis goes: nearly all points, the lines, and the band of the noise."""
    low, high = np.percentile(y, [0.25, 99.75])
    bottom, top = min(low, drawn.min(), -2.5 * floor), max(high, drawn.max(), 2.5 * floor)
    room = 0.06 * (top - bottom)
    return {"bottom": float(bottom - room), "top": float(top + room)}


def _largest(values: Array) -> float | None:
    return _number(float(np.max(np.abs(values)))) if len(values) else None


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
