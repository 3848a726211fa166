"""Places as sentences with numbers."""

from __future__ import annotations

import numpy as np

from infotraj.locating.healthy import Usual
from infotraj.locating.lags import Lags
from infotraj.locating.places import Place, matters
from infotraj.locating.quantities import Quantity
from infotraj.locating.regions import Region
from infotraj.locating.tree import Leaf
from infotraj.locating.windows import TimeWindow
from infotraj.rotations import Array

_FOLLOWS = 0.1  # share of the squared error that must follow a quantity for the sentence to say how


def place_sentence(place: Place) -> str:
    """One place: where, how much worse than the rest, how much of the error, the interval, the floor, the trend."""
    parts = []
    at, taken_out = place.region, _taken_out(place)
    error = f"{place.axis} error{f', beside {taken_out},' if taken_out else ''}"
    of = f"{'this' if taken_out else 'the'} squared error"
    if at is not None and at.low > 1.0:
        parts.append(
            f"{error} is {times(at.ratio)} times the rest (95 % interval {times(at.low)} to "
            f"{times(at.high)}) when {where(place)}: {100 * at.samples:.0f} % of the samples hold "
            f"{100 * at.squares:.0f} % of {of}, "
            f"RMS {at.inside:.3g} {place.unit} against a floor of {place.floor:.2g}"
        )
    if place.other is None and place.explained > _FOLLOWS:
        low, high = place.trend[0][0], place.trend[0][-1]
        first, last = place.trend[1][0], place.trend[1][-1]
        start = "it" if parts else error
        whole = ""
        if not place.taken:
            first, last = first + place.mean, last + place.mean
            whole = "with the mean " if taken_out else ""
        parts.append(
            f"{start} follows the {place.quantity.name} ({100 * place.explained:.0f} % of {of}): "
            f"{whole}{signed(first)} at {low:.3g}, {signed(last)} {place.unit} at {high:.3g} {place.quantity.unit}"
            + ("" if parts else f"; floor {place.floor:.2g} {place.unit}")
        )
    if not parts:
        parts.append(f"{error} changes its spread with the {place.quantity.name}; floor {place.floor:.2g}")
    if place.alike:
        parts.append(f"these flights hardly tell it from: {', '.join(place.alike)}")
    return "; ".join(parts)


def _taken_out(place: Place) -> str:
    """What the numbers of a place are beside: a mean that matters, and what was found on the axis before it."""
    parts = [f"its mean of {signed(place.mean)} {place.unit}"] if matters(place.mean, place.floor) else []
    if place.taken:
        parts.append(f"what follows the {' and the '.join(place.taken)}")
    return " and ".join(parts)


def healthy_sentence(place: Place, usual: Usual) -> str:
    """What the error is at a place when nothing is wrong, beside what it is now."""
    rms, trend = (x[np.isfinite(x)] for x in (usual.rms, usual.trend))
    parts = []
    if len(rms):
        parts.append(f"RMS with the mean {_span(rms, place.unit)} there, now {usual.now:.3g}")
    if len(trend) and place.explained > _FOLLOWS:
        parts.append(f"{_span(np.round(100 * trend) + 0.0, '% of this trend', '.0f')}")
    said = "; ".join(parts) or "they were not there"
    return f"healthy flights: {said}"


def healthy_bias(bias: Array, unit: str) -> str:
    """The mean error of an axis on healthy flights."""
    return f"healthy flights {_span(bias, unit, '+.3g')}" if len(bias) else "healthy flights do not say"


def _span(values: Array, unit: str, digits: str = ".3g") -> str:
    low, high = (f"{v:{digits}}" for v in (values.min(), values.max()))
    return f"{low if low == high else f'{low} to {high}'} {unit}"


def where(place: Place) -> str:
    """The condition in words."""
    if place.other is not None and place.cell is not None:
        spans = [
            f"the {q.name} is between {low:.3g} and {high:.3g} {q.unit}"
            for q, (low, high) in zip((place.quantity, place.other), place.cell, strict=True)
        ]
        return " and ".join(spans)
    assert place.region is not None  # a place is a region, or a cell of two quantities
    return condition(place.quantity, place.region)


def condition(quantity: Quantity, at: Region) -> str:
    """One side of a threshold in words."""
    if at.side == "beyond":
        return f"the {quantity.name} is beyond {at.threshold:.3g} {quantity.unit} either way"
    return f"the {quantity.name} is {at.side} {at.threshold:.3g} {quantity.unit}"


def window_sentence(window: TimeWindow, name: str) -> str:
    """One window in time."""
    return (
        f"{name}: {window.axis} error is {times(window.ratio)} times the rest of the flight from {window.start:.1f} to "
        f"{window.stop:.1f} s ({window.over_floor:.1f} times the floor; "
        f"{100 * window.share:.0f} % of the squared error)"
    )


def leaf_sentence(axis: str, leaf: Leaf) -> str:
    """One leaf of a tree."""
    conditions = " and ".join(f"{name} {side} {cut:.3g} {unit}" for name, unit, side, cut in leaf.conditions)
    return (
        f"{axis}: {leaf.over_floor:.1f} times the floor where {conditions or 'ever it flew'} "
        f"({100 * leaf.samples:.0f} % of the samples, {100 * leaf.squares:.0f} % of the squared error)"
    )


def lag_sentence(lags: Lags) -> str:
    """What a shift in time would explain."""
    word = "later" if lags.delay > 0 else "earlier"
    return (
        f"{lags.axis}: the measurement comes {1e3 * abs(lags.delay):.0f} +- {1e3 * lags.standard_error:.0f} ms "
        f"{word} than the prediction, which would explain {100 * lags.share:.0f} % of the squared error: "
        "a delay or a lag"
    )


def times(x: float) -> str:
    """A ratio with as many digits as it deserves."""
    return f"{x:.1f}" if np.isfinite(x) and x < 100 else f"{x:.0f}"


def signed(x: float) -> str:
    """A number with its sign."""
    return f"{x:+.3g}"
