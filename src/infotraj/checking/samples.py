"""What of a flight is a sample: each channel by itself, before anything is said about how channels go together.

Each step sees the flight without the cells that the steps before it found to be none.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from infotraj import rotations
from infotraj.checking import frozen, held, jumps, outliers, timing
from infotraj.checking.airborne import Airborne, airborne_rows, no_flight
from infotraj.checking.columns import dead_column_findings, dead_columns
from infotraj.checking.finding import Finding
from infotraj.checking.resolution import quantised
from infotraj.checking.voids import Void, emptied
from infotraj.flight import ATTITUDE, Flight
from infotraj.vehicle import Vehicle


@dataclass(frozen=True)
class Sampled:
    """The flight whose cells are samples, the rows in the air, what was found, the cells that became empty, and the
    rates of its streams (Hz). Single wrong commands are empty here, and stay for a model: they may have acted."""

    flight: Flight
    air: Airborne
    findings: list[Finding]
    voids: list[Void]
    rates: dict[str, dict[str, Any]]


def sampled(flight: Flight, vehicle: Vehicle | None = None) -> Sampled:
    """The channels of a flight, one by one: dead, stuck, held, wrapped, clipped, spiky."""
    findings = outliers.attitude_norm(flight)
    flight = _with_unit_attitudes(flight)
    voids: list[Void] = []

    def void(new: list[Void]) -> Flight:
        voids.extend(new)
        return emptied(flight, new)

    straight = frozen.straight_streams(flight)
    flight = void([Void("dead_stream", d.columns, flight.t[d.rows]) for d in straight])
    air = airborne_rows(flight, vehicle)
    findings += frozen.dead_findings(flight, straight, air.rows, "straight") + no_flight(flight, air)

    streams = held.held_streams(flight, air.rows)
    still = frozen.still_streams(flight, air.rows, streams)
    streams = frozen.beyond_still(streams, still)
    findings += frozen.dead_findings(flight, still, air.rows, "still") + held.held_findings(streams, air.rows)
    flight = void([Void("stuck", d.columns, flight.t[d.rows]) for d in still])
    flight = void([Void("held", h.columns, flight.t[h.rows]) for h in streams if h.rows.any()])
    findings += timing.gaps(flight, air.rows) + timing.jitter(flight) + timing.slow_rows(flight)

    dead = dead_columns(flight, air.rows, vehicle)
    findings += dead_column_findings(flight, dead) + quantised(flight, air.rows)
    flight = void([Void("dead_column", (d.column,), flight.t[d.rows]) for d in dead])
    jumped = jumps.jumped_columns(flight, air.rows)
    findings += jumps.jump_findings(flight, jumped)
    flight = void([Void(j.code, (j.column,), flight.t[j.rows]) for j in jumped])

    single = outliers.spikes(flight, air.rows)
    clipped, beyond = outliers.saturation(flight, air.rows)
    findings += outliers.impossible_commands(flight, air.rows, vehicle) + outliers.spike_findings(single) + clipped
    findings += outliers.pose_jumps(flight, air.rows)
    spiky = outliers.spike_voids(flight, single)
    flight = void(beyond + [v for v in spiky if not v.columns[0].startswith("cmd_")])
    flight = emptied(flight, spiky)
    findings += outliers.impossible_values(flight, air.rows)
    return Sampled(flight, air, findings, voids, held.rates(streams))


def _with_unit_attitudes(flight: Flight) -> Flight:
    if not flight.has(*ATTITUDE):
        return flight
    norm = np.linalg.norm(flight.get(*ATTITUDE), axis=1)
    with np.errstate(invalid="ignore"):
        bad = np.abs(norm - 1) > 0.01
    if bad.any() and bad.mean() <= 0.05:
        return emptied(flight, [Void("attitude_norm", ATTITUDE, flight.t[bad])])
    q = flight.get(*ATTITUDE).copy()
    good = np.isfinite(norm) & (norm > 1e-6)
    q[good] = rotations.normalize(q[good])
    q[~good] = np.nan
    return Flight(flight.table.assign(**dict(zip(ATTITUDE, q.T, strict=True))), dict(flight.meta))
