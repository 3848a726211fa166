"""Which columns of a flight table a log profile changes, and how a changed table becomes a flight."""

from __future__ import annotations

import numpy as np

from infotraj.flight import Flight
from infotraj.rotations import Array


def numbered(flight: Flight, prefix: str) -> list[str]:
    """The columns prefix0, prefix1, ... that the flight has."""
    count = flight.numbered(prefix).shape[1]
    return [f"{prefix}{k}" for k in range(count)]


def replaced(flight: Flight, names: list[str] | tuple[str, ...], values: Array) -> Flight:
    """The flight with these columns (n, k) instead."""
    return Flight(flight.table.assign(**dict(zip(names, np.asarray(values).T, strict=True))), dict(flight.meta))


def step(flight: Flight) -> float:
    """The period (s) of the rows."""
    return float(np.median(np.diff(flight.t)))


def held(flight: Flight, names: list[str] | tuple[str, ...], period: float, phase: float = 0.0) -> Flight:
    """The columns sampled every `period` (s), from `phase` on, and held between."""
    t = flight.t
    marks = np.floor((t - t[0] - phase) / period + 1e-6)
    first = np.searchsorted(marks, marks, side="left")
    return replaced(flight, names, flight.get(*names)[first])
