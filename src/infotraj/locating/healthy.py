"""Places beside healthy flights: what the error there is when nothing is wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from infotraj.comparing.equation_error import AXES, equation_error
from infotraj.comparing.statistics import Statistics, statistics
from infotraj.dynamics.inputs import for_vehicle
from infotraj.flight import Flight
from infotraj.locating.locating import Located
from infotraj.locating.places import Place
from infotraj.locating.quantities import Quantity
from infotraj.locating.samples import Samples, samples
from infotraj.models import Model
from infotraj.rotations import Array

LEAST_ROWS = 20  # rows that a healthy flight must have at a place: fewer say nothing of it


@dataclass(frozen=True)
class Usual:
    """The error at one place now and on n healthy flights.

    now: RMS there, in the place's unit, nothing taken out; rms (n,): the same of each healthy flight, nan where it was
    not there; trend (n,): how much of the place's trend each healthy flight has (0 none, 1 the same), nan where it
    does not have the quantity.
    """

    now: float
    rms: Array
    trend: Array


@dataclass(frozen=True)
class Beside:
    """Healthy flights beside what was located: paths, the error at each place and pair (in their order), and by
    flight the statistics of all axes."""

    paths: tuple[str, ...]
    places: tuple[Usual, ...]
    pairs: tuple[Usual, ...]
    by_flight: tuple[Statistics, ...]

    def bias(self, axis: str) -> Array:
        """The mean error of one axis on each healthy flight that says it."""
        every = np.array([s.bias[AXES.index(axis)] for s in self.by_flight])
        return every[np.isfinite(every)]


def beside(located: Located, model: Model, flights: Sequence[Flight], **how: Any) -> Beside:
    """The errors of healthy flights at the places of `located`.

    how: window, force_from, start and stop, as they were given to `locate`. InputError where a flight lacks what the
    vehicle needs.
    """
    flights = [for_vehicle(f, model.vehicle) for f in flights]
    errors = [equation_error(model, f, **how) for f in flights]
    theirs = samples(flights, model.vehicle, errors)
    ours = [f.samples for f in located.found]
    return Beside(
        tuple(str(f.meta.get("source", f"flight {k}")) for k, f in enumerate(flights)),
        tuple(_usual(p, ours, theirs, len(flights)) for p in located.places),
        tuple(_usual(p, ours, theirs, len(flights)) for p in located.pairs),
        tuple(statistics([e]) for e in errors),
    )


def _usual(place: Place, ours: Sequence[Samples], theirs: Sequence[Samples], flights: int) -> Usual:
    mine = next(s for s in ours if place.axis in s.axes)
    now = _rms(mine, place, np.ones(len(mine.t), dtype=bool))
    healthy = next((s for s in theirs if place.axis in s.axes), None)
    if healthy is None:
        return Usual(now, np.full(flights, np.nan), np.full(flights, np.nan))
    own = [healthy.flight == k for k in range(flights)]
    rms = np.array([_rms(healthy, place, rows) for rows in own])
    return Usual(now, rms, np.array([_trend(healthy, place, rows) for rows in own]))


def _rms(of: Samples, place: Place, among: NDArray[np.bool_]) -> float:
    """RMS of the place's axis over the rows at the place; everywhere where it has no region."""
    values = [_values(of, q) for q in (place.quantity, place.other) if q is not None]
    known = [v for v in values if v is not None]
    if len(known) < len(values):
        return float("nan")
    rows = among.copy()
    if place.cell is not None:
        for v, (low, high) in zip(known, place.cell, strict=True):
            rows &= (v >= low) & (v <= high)
    elif place.region is not None and place.region.low > 1.0:
        rows &= place.region.holds(known[0])
    if rows.sum() < LEAST_ROWS:
        return float("nan")
    return float(np.sqrt(np.mean(np.square(of.residual[rows, of.axes.index(place.axis)]))))


def _trend(of: Samples, place: Place, among: NDArray[np.bool_]) -> float:
    """How much of the place's trend the residual of these rows has: least squares, means left out."""
    values = _values(of, place.quantity)
    knots, heights = place.trend
    if values is None or not len(knots) or among.sum() < LEAST_ROWS:
        return float("nan")
    drawn = np.interp(values[among], knots, heights)
    drawn -= drawn.mean()
    square = float(drawn @ drawn)
    residual = of.residual[among, of.axes.index(place.axis)]
    return float(drawn @ residual) / square if square > 0 else float("nan")


def _values(of: Samples, quantity: Quantity) -> Array | None:
    return next((q.values for q in of.quantities if q.name == quantity.name), None)
