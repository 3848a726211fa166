"""Whether an accelerometer shows vibration and little else, on a flight whose velocity was recorded as well.

Vibration of rotors is sampled at a few hundred hertz and aliases: means over a fifth of a second may show little else.
The velocity changes by the same force, with other noise. What the model lacks stands in its error beside either. An
error that is larger beside the accelerometer is vibration where the accelerometer shows more still above 5 Hz, for
aliases lie anywhere, and where it goes neither with the force, as a bias, a scale, a mount or a lag makes it, nor with
turning, as a lever to the point whose path is recorded makes it.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from infotraj.comparing.equation_error import EquationError, equation_error
from infotraj.effects.channels import FORCE_FROM, is_derived
from infotraj.flight import ATTITUDE, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.models import Model
from infotraj.rotations import Array

CODE = "accelerometer_shaken"
_SLOW = 0.2  # s, of the means that are compared: what moves a vehicle
_TIMES = 2.0  # as large: three quarters of the squared error are then the accelerometer's own
_FEWEST = 100  # rows
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def shaken(
    model: Model, flight: Flight, start: float | None = None, stop: float | None = None
) -> tuple[Array, Array] | None:
    """The accelerometer's own error and the model's whole error beside the velocity, N, (3,) each, over 0.2 s.

    None where on two of three axes the first is not vibration or not twice the second, or one of them cannot be had.
    start, stop: s, the part of the flight to use.
    """
    felt = flight.has(*SPECIFIC_FORCE) and not is_derived(flight, SPECIFIC_FORCE)
    if not (felt and _has_velocity(flight) and model.vehicle.mass is not None) or _slow(flight):
        return None
    error = partial(equation_error, model, flight, window=_SLOW, start=start, stop=stop)
    beside, by_velocity = error(force_from="accelerometer"), error(force_from="velocity")
    rows, moved_rows = (np.flatnonzero(e.scored[:, :3].all(axis=1)) for e in (beside, by_velocity))
    if min(len(rows), len(moved_rows)) < _FEWEST:
        return None
    left = np.std(by_velocity.residual[moved_rows, :3], axis=0)
    own = _own(beside, flight, rows)
    fast = np.std(model.vehicle.mass * flight.get(*SPECIFIC_FORCE)[rows] - beside.measured[rows, :3], axis=0)
    drowned = (own >= _TIMES * left) & (fast >= _TIMES * own)
    return (own, left) if drowned.sum() >= 2 else None


def told_by_velocity(flight: Flight) -> Flight:
    """The flight, marked: forces are told from its velocity. As it is where it has none of its own."""
    if not _has_velocity(flight):
        return flight
    return Flight(flight.table, {**flight.meta, FORCE_FROM: "velocity"})


def said(errors: tuple[Array, Array]) -> str:
    """What `shaken` found, in words."""
    own, left = (", ".join(f"{x:.2g}" for x in side) for side in errors)
    return (
        f"vibration of the accelerometer alone is {own} N (x, y, z; over {_SLOW:g} s), "
        f"the whole error beside the recorded velocity {left} N"
    )


def _has_velocity(flight: Flight) -> bool:
    return flight.has(*VELOCITY, *ATTITUDE) and not is_derived(flight, VELOCITY)


def _slow(flight: Flight) -> bool:
    """Whether the velocity was recorded too seldom for a slope over so short a time."""
    t = flight.t[np.isfinite(flight.get(*VELOCITY)).all(axis=1)]
    return len(t) < _FEWEST or bool(np.median(np.diff(t)) > _SLOW / 4)


def _own(beside: EquationError, flight: Flight, rows: NDArray) -> Array:
    """What varies (3,) of the error beside the accelerometer and goes neither with the force nor with turning."""
    force = beside.predicted[rows, :3]
    columns = [np.ones((len(rows), 1)), force, np.gradient(force, beside.t[rows], axis=0)]
    if flight.has(*RATE):
        rate = flight.get(*RATE)[rows]
        columns += [beside.measured[rows, 3:], np.column_stack([rate[:, i] * rate[:, j] for i, j in _PAIRS])]
    along = np.concatenate(columns, axis=1)
    known = np.isfinite(along).all(axis=1)
    error = beside.residual[rows, :3][known]
    if len(error) < _FEWEST:
        return np.zeros(3)
    return np.asarray(np.std(error - along[known] @ np.linalg.lstsq(along[known], error, rcond=None)[0], axis=0))
