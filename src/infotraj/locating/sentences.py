"""Places as sentences with numbers."""

from __future__ import annotations

from dataclasses import replace

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
    """One place: where, how much worse than the rest, how much of the error, the floor, the trend, what is off it."""
    return "; ".join([*_found(place), *_taken_off(place)])


def place_lines(place: Place) -> list[str]:
    """The same in lines that are short to read, beside the axis's mean, which they do not say."""
    return [*_found(place), *_taken_off(replace(place, mean=0.0))]


def _found(place: Place) -> list[str]:
    lines = []
    at, error = place.region, f"{place.axis} error"
    if at is not None and at.low > 1.0:
        ratio = f"{error} is {times(at.ratio)} times the rest ({times(at.low)} to {times(at.high)}, 95 %)"
        lines += [
            *([f"{ratio} {where(place)}"] if place.other is None else [ratio, where(place)]),
            f"{100 * at.samples:.0f} % of the samples hold {100 * at.squares:.0f} % of its squared error: "
            f"RMS {at.inside:.3g} {place.unit}, floor {place.floor:.2g}",
        ]
    if place.other is None and place.explained > _FOLLOWS:
        whole = 0.0 if place.taken else place.mean
        of_all = "with its mean " if whole and matters(whole, place.floor) else ""
        it = f"{of_all}it" if lines else f"{error} {of_all}".rstrip()
        low, high = (
            f"{signed(height + whole)} {place.unit} at {x:.3g} {place.quantity.unit}"
            for x, height in zip(*(ends[[0, -1]] for ends in place.trend), strict=True)
        )
        floor = "" if lines else f"; floor {place.floor:.2g}"
        lines.append(f"{it} follows the {place.quantity.name}: {low}, {high}{floor}")
    if not lines:
        lines.append(f"{error} changes its spread with the {place.quantity.name}; floor {place.floor:.2g}")
    if place.alike:
        lines.append(f"these flights hardly tell it from: {', '.join(place.alike)}")
    return lines


def _taken_off(place: Place) -> list[str]:
    """What the numbers of a place are beside: a mean that matters, and what was found on the axis before it."""
    parts = [f"its mean of {signed(place.mean)} {place.unit}"] if matters(place.mean, place.floor) else []
    if place.taken:
        parts.append(f"what follows the {' and the '.join(place.taken)}")
    return [f"taken off before: {' and '.join(parts)}"] if parts else []


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
            f"{q.name} {low:.3g} to {high:.3g} {q.unit}"
            for q, (low, high) in zip((place.quantity, place.other), place.cell, strict=True)
        ]
        return f"at {' and '.join(spans)}"
    assert place.region is not None  # a place is a region, or a cell of two quantities
    return f"where {condition(place.quantity, place.region)}"


def condition(quantity: Quantity, at: Region) -> str:
    """One side of a threshold in words."""
    if at.side == "beyond":
        return f"the {quantity.name} is beyond ±{at.threshold:.3g} {quantity.unit}"
    return f"the {quantity.name} is {at.side} {at.threshold:.3g} {quantity.unit}"


def window_sentence(window: TimeWindow, name: str) -> str:
    """One window in time."""
    return (
        f"{name}, {window.start:.1f} to {window.stop:.1f} s: {window.axis} error is {times(window.ratio)} times "
        f"the rest of the flight, {times(window.over_floor)} times the floor"
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
        f"{lags.axis} comes {1e3 * abs(lags.delay):.0f} +- {1e3 * lags.standard_error:.0f} ms {word} than predicted: "
        f"a delay or lag would explain {100 * lags.share:.0f} % of its squared error"
    )


def times(x: float) -> str:
    """A ratio with as many digits as it deserves."""
    return f"{x:.1f}" if np.isfinite(x) and x < 100 else f"{x:.0f}"


def signed(x: float) -> str:
    """A number with its sign."""
    return f"{x:+.3g}"
