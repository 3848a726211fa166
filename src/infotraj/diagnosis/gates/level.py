"""What a log without attitude or gyro says all the same: a vehicle that holds its place is level, and does not spin.

Over seconds its thrust carries its weight and its torques balance. That is enough to hold one flight against another,
and too little for side forces and for anything fast.
"""

from __future__ import annotations

import numpy as np

from infotraj.flight import ATTITUDE, POSITION, RATE, VELOCITY, Flight

ASSUMED = "assumed"  # key of the metadata: channels that were not measured


def as_level(flight: Flight) -> Flight:
    """The flight with a level attitude and no rate where it has none; marked as assumed, and derived."""
    table, assumed = flight.table.copy(), []
    moves = flight.has(*POSITION) or flight.has(*VELOCITY)
    if moves and not flight.has(*ATTITUDE):
        assumed += list(ATTITUDE)
        table[list(ATTITUDE)] = np.tile([1.0, 0.0, 0.0, 0.0], (len(table), 1))
    if moves and not flight.has(*RATE) and not flight.has(*ATTITUDE):
        assumed += list(RATE)
        table[list(RATE)] = 0.0
    if not assumed:
        return flight
    derived = sorted({*(flight.meta.get("derived") or ()), *assumed})
    return Flight(table, {**flight.meta, "derived": derived, ASSUMED: assumed})


def unmeasured(flight: Flight) -> tuple[frozenset[str], frozenset[str]]:
    """Axes of the residual of which an assumed attitude says nothing, and those of which the balance alone counts."""
    assumed = set(flight.meta.get(ASSUMED) or ())
    level, still = bool(assumed & {*ATTITUDE}), bool(assumed & {*RATE})
    balance = {"vz"} if level else set()
    return frozenset({"vx", "vy"} if level else ()), frozenset(balance | ({"tx", "ty", "tz"} if still else set()))
