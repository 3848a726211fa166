"""Rotors at full throttle: they may give less than their command says, and a change of them is then told too small."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.checking.airborne import airborne_rows
from infotraj.diagnosis.gates.doubt import Doubt
from infotraj.dynamics.inputs import input_columns
from infotraj.flight import Flight
from infotraj.vehicle import Vehicle

_FULL = 0.98  # of the throttle
_AT = 0.999  # of it
_LIMIT = 0.9  # and more of it, held time and again as the most that is ever given: an autopilot's own limit
_OFTEN = 0.02  # of the time in the air


def saturated(flights: Sequence[Flight], vehicle: Vehicle) -> list[Doubt]:
    """One note for each rotor that is often at full throttle in the air. It refuses nothing."""
    share: dict[str, float] = {}
    for flight in flights:
        columns = input_columns(vehicle, flight)
        if columns is None or not any(r.input == "throttle" for r in vehicle.rotors):
            continue
        flying = flight.get(*columns)[np.asarray(airborne_rows(flight, vehicle).rows, dtype=bool)]
        for r, x in zip(vehicle.rotors, flying.T, strict=False):
            if r.input == "throttle" and np.isfinite(x).any():
                given = x[np.isfinite(x)]
                full = (given >= _FULL) | ((given >= _LIMIT) & (given >= _AT * given.max()))
                share[r.name] = max(share.get(r.name, 0.0), float(np.mean(full)))
    return [
        Doubt(
            "rotor_saturated",
            name,
            (),
            f"{name} is at full throttle in {100 * often:.0f} % of a flight: it may give less than its command says",
            refuses=False,
        )
        for name, often in share.items()
        if often > _OFTEN
    ]
