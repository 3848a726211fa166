"""The rows that are searched: residuals of all flights, thinned to what the filter leaves independent, with
quantities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.flight import Flight
from infotraj.locating.quantities import Quantity, quantities
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

# The filter's window holds about three independent values: denser rows add time, not evidence.
ROWS_A_WINDOW = 3
MOST_ROWS = 6000
_SPREAD = 1e-6


@dataclass(frozen=True)
class Samples:
    """n rows of one kind of residual, force or torque, that are searched together.

    axes: the names of the columns; residual (n, a) and floor (a,) in `unit`; flight (n,): which flight a row is of,
    rows of one flight together; t (n,) s; spacing: mean time between rows, s; quantities: values on these rows.
    """

    axes: tuple[str, ...]
    residual: Array
    floor: Array
    unit: str
    flight: NDArray[np.int_]
    t: Array
    spacing: float
    quantities: tuple[Quantity, ...]


def samples(flights: Sequence[Flight], vehicle: Vehicle, errors: Sequence[EquationError]) -> list[Samples]:
    """Force and torque samples; a kind that no flight can answer, or whose floor is unknown, is left out."""
    known = [quantities(f, vehicle, e.window) for f, e in zip(flights, errors, strict=True)]
    shared = _shared(known)
    found = []
    for kind, first in (("force", 0), ("torque", 3)):
        columns = slice(first, first + 3)
        rows = [np.flatnonzero(e.scored[:, columns].all(axis=1)) for e in errors]
        if not any(len(r) for r in rows):
            continue
        kept = _capped([r[_thinned(e.t[r], e.window / ROWS_A_WINDOW)] for e, r in zip(errors, rows, strict=True)])
        residual = np.concatenate([e.residual[r][:, columns] for e, r in zip(errors, kept, strict=True)])
        if len(residual) < 20:
            continue
        weight = np.array([len(r) for r in kept], dtype=float)
        squares = np.array([np.square(e.floor[columns]) for e in errors])
        used = weight > 0
        floor = np.sqrt(weight[used] @ squares[used] / weight[used].sum())
        spans = [e.t[r] for e, r in zip(errors, kept, strict=True)]
        steps = np.concatenate([np.diff(t) for t in spans if len(t) > 1])
        found.append(
            Samples(
                AXES[first : first + 3],
                residual,
                floor,
                errors[0].unit[kind],
                np.repeat(np.arange(len(kept)), [len(r) for r in kept]),
                np.concatenate(spans),
                float(np.median(steps)),
                tuple(_joined(name, known, kept) for name in shared),
            )
        )
    return found


def _thinned(t: Array, spacing: float) -> NDArray:
    if not len(t):
        return np.zeros(0, dtype=int)
    slot = np.floor((t - t[0]) / spacing + 1e-6)
    return np.unique(slot, return_index=True)[1]


def _capped(rows: list[NDArray]) -> list[NDArray]:
    total = sum(len(r) for r in rows)
    every = -(-total // MOST_ROWS)
    return [r[::every] for r in rows]


def _shared(known: list[list[Quantity]]) -> list[str]:
    """Names of the quantities that every flight has and that take more than one value, in order."""
    names = [q.name for q in known[0] if all(any(o.name == q.name for o in others) for others in known)]
    chosen = []
    for name in names:
        values = np.concatenate([q.values for flight in known for q in flight if q.name == name])
        if np.isfinite(values).all() and np.ptp(values) > _SPREAD * max(1.0, float(np.abs(values).max())):
            chosen.append(name)
    return chosen


def _joined(name: str, known: list[list[Quantity]], kept: list[NDArray]) -> Quantity:
    parts = [next(q for q in flight if q.name == name) for flight in known]
    first = parts[0]
    values = np.concatenate([q.values[r] for q, r in zip(parts, kept, strict=True)])
    return Quantity(name, first.group, first.unit, values, first.signed, first.axis)
