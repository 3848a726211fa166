"""All checks of one log, in the order in which one needs the other."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from infotraj import rotations
from infotraj.checking import outliers, timing
from infotraj.checking.acceptance import accepted_codes, marked
from infotraj.checking.actuation import carrying_findings, column_findings
from infotraj.checking.airborne import airborne_rows, no_flight
from infotraj.checking.beside import Beside
from infotraj.checking.columns import dead_column_findings, dead_columns
from infotraj.checking.conventions import convention_findings
from infotraj.checking.coverage import coverage, excitation_findings
from infotraj.checking.divergence import reference_not_followed
from infotraj.checking.finding import Finding, Outcome, Span, ordered, outcome, usable_spans
from infotraj.checking.frozen import beyond_still, dead_findings, still_streams, straight_streams
from infotraj.checking.held import held_findings, held_streams, rates
from infotraj.checking.jumps import jump_findings, jumped_columns
from infotraj.checking.load import Loaded
from infotraj.checking.motion import Judge, judge_motion
from infotraj.checking.questions import question_findings, unanswerable
from infotraj.checking.resolution import quantised
from infotraj.checking.voids import Void, emptied
from infotraj.errors import InputError, problem
from infotraj.flight import ATTITUDE, Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

GRAVITY = 9.81


@dataclass(frozen=True)
class Check:
    """What came out for one log.

    Findings (worst first) and what becomes of it, the spans (s) that can be used, the time in the air and how it was
    judged, the coverage of states and inputs, the questions that it cannot answer, the lags between its streams with
    their standard errors (s), reported or not, the cells that hold no sample (`cleaning.cleaned` empties them), and the
    rate of each measured stream's samples (Hz) with that of the rows over which they are held.
    """

    source: str
    rows: int
    start: float
    stop: float
    airborne_seconds: float
    airborne_share: float
    airborne_from: str
    findings: list[Finding]
    usable: list[Span]
    coverage: dict[str, dict[str, Any]] = field(default_factory=dict)
    unanswerable: dict[str, list[str]] = field(default_factory=dict)
    lags: dict[str, tuple[float, float]] = field(default_factory=dict)
    voids: list[Void] = field(default_factory=list)
    rates: dict[str, dict[str, Any]] = field(default_factory=dict)

    @property
    def outcome(self) -> Outcome:
        """passed, warning, cut or rejected."""
        return outcome(self.findings)


def check(flight: Flight, vehicle: Vehicle | None = None) -> list[Finding]:
    """The findings about one flight, the worst first. See `examine` for all that comes out."""
    return examine(flight, vehicle).findings


def examine(
    log: Flight | Loaded | pd.DataFrame,
    vehicle: Vehicle | None = None,
    judge: Judge = convention_findings,
) -> Check:
    """Checks one log: a flight, what `load` made of a raw log (with the streams that its table leaves out), or a table
    with a column t whose order is not known to be right. `judge` decides about conventions (see `pooled`). Raises
    InputError for a table without t.
    """
    others: list[Beside] = []
    voids: list[Void] = []
    if isinstance(log, Loaded):
        flight, findings, others = log.flight, list(log.findings), log.beside
    else:
        flight, findings = _in_order(log)
    source = str(flight.meta.get("source", "flight"))
    flight, more = timing.time_unit(flight)
    findings += more + outliers.attitude_norm(flight)
    flight = _without_bad_attitudes(flight)
    straight = straight_streams(flight)
    new = [Void("dead_stream", d.columns, flight.t[d.rows]) for d in straight]
    flight, voids = emptied(flight, new), voids + new
    air = airborne_rows(flight, vehicle)
    findings += dead_findings(flight, straight, air.rows, "straight")
    findings += no_flight(flight, air)
    held = held_streams(flight, air.rows)
    still = still_streams(flight, air.rows, held)
    held = beyond_still(held, still)
    findings += dead_findings(flight, still, air.rows, "still") + held_findings(held, air.rows)
    new = [Void("stuck", d.columns, flight.t[d.rows]) for d in still]
    new += [Void("held", h.columns, flight.t[h.rows]) for h in held if h.rows.any()]
    flight, voids = emptied(flight, new), voids + new
    findings += timing.gaps(flight, air.rows) + timing.jitter(flight)
    dead = dead_columns(flight, air.rows, vehicle)
    jumped = jumped_columns(flight, air.rows)
    findings += dead_column_findings(flight, dead) + jump_findings(flight, jumped) + quantised(flight, air.rows)
    new = [Void("dead_column", (d.column,), flight.t[d.rows]) for d in dead]
    new += [Void(j.code, (j.column,), flight.t[j.rows]) for j in jumped]
    flight, voids = emptied(flight, new), voids + new
    single = outliers.spikes(flight, air.rows)
    clipped, new = outliers.saturation(flight, air.rows)
    findings += (
        outliers.impossible_commands(flight, air.rows, vehicle)
        + outliers.spike_findings(single)
        + clipped
        + outliers.pose_jumps(flight, air.rows)
    )
    new += outliers.spike_voids(flight, single)
    flight, voids = emptied(flight, new), voids + [v for v in new if not v.columns[0].startswith("cmd_")]
    findings += outliers.impossible_values(flight, air.rows)
    findings += column_findings(flight, air.rows, vehicle) + carrying_findings(flight, air.rows, vehicle)
    gravity = vehicle.gravity if vehicle else GRAVITY
    moved = judge_motion(flight, air, gravity, others, judge)
    findings += moved.findings
    findings += reference_not_followed(flight, air.rows) + question_findings(flight, vehicle)
    covered = coverage(flight, air.rows)
    findings += excitation_findings(covered)
    findings = marked(_distinct(findings), accepted_codes(flight))
    start, stop = float(flight.t[0]), float(flight.t[-1])
    return Check(
        source,
        len(flight.table),
        start,
        stop,
        air.seconds(flight.t),
        float(air.rows.mean()),
        air.how,
        findings,
        usable_spans(start, stop, findings),
        covered,
        unanswerable(flight, vehicle),
        {name: (lag.lag, lag.error) for name, lag in moved.lags.items()},
        voids,
        rates(held),
    )


def _in_order(log: Flight | pd.DataFrame) -> tuple[Flight, list[Finding]]:
    if isinstance(log, Flight):
        return log, []
    if "t" not in log:
        raise InputError(problem("a table without a column t", "a flight table", "Import the log first."))
    table, findings = timing.order(log)
    return Flight(table, dict(log.attrs)), findings


def _voided(flight: Flight, rows: Array, columns: tuple[str, ...]) -> Flight:
    table = flight.table.copy()
    table.loc[rows, list(columns)] = np.nan
    return Flight(table, dict(flight.meta))


def _without_bad_attitudes(flight: Flight) -> Flight:
    if not flight.has(*ATTITUDE):
        return flight
    norm = np.linalg.norm(flight.get(*ATTITUDE), axis=1)
    with np.errstate(invalid="ignore"):
        bad = np.abs(norm - 1) > 0.01
    if not bad.any() or bad.mean() > 0.05:
        q = flight.get(*ATTITUDE).copy()
        good = np.isfinite(norm) & (norm > 1e-6)
        q[good] = rotations.normalize(q[good])
        q[~good] = np.nan
        return Flight(flight.table.assign(**dict(zip(ATTITUDE, q.T, strict=True))), dict(flight.meta))
    return _voided(flight, bad, ATTITUDE)


def _distinct(findings: list[Finding]) -> list[Finding]:
    # impossible sizes are the shadow of a wrong unit that is named already
    units = {c for f in findings if f.code.endswith("_unit") for c in f.channels}
    return [f for f in findings if not (f.code.endswith("_impossible") and set(f.channels) & units)]
