"""All checks of one log, in the order in which one needs the other."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from infotraj.checking import timing
from infotraj.checking.acceptance import accepted_codes, marked
from infotraj.checking.actuation import carrying_findings, column_findings
from infotraj.checking.beside import Beside
from infotraj.checking.conventions import convention_findings
from infotraj.checking.coverage import coverage, excitation_findings
from infotraj.checking.divergence import reference_not_followed
from infotraj.checking.finding import Finding, Outcome, Span, outcome, usable_spans
from infotraj.checking.load import Loaded
from infotraj.checking.motion import Judge, judge_motion
from infotraj.checking.questions import (
    incomplete_findings,
    missing_input_findings,
    question_findings,
    unanswerable,
)
from infotraj.checking.samples import sampled
from infotraj.checking.voids import Void
from infotraj.errors import InputError, problem
from infotraj.flight import Flight
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
    if isinstance(log, Loaded):
        flight, findings, others = log.flight, list(log.findings), log.beside
    else:
        flight, findings = _in_order(log)
    source = str(flight.meta.get("source", "flight"))
    flight, more = timing.time_unit(flight)
    findings += more
    samples = sampled(flight, vehicle)
    flight, air = samples.flight, samples.air
    findings += samples.findings
    findings += incomplete_findings(flight) + missing_input_findings(flight, vehicle)
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
        samples.voids,
        samples.rates,
    )


def _in_order(log: Flight | pd.DataFrame) -> tuple[Flight, list[Finding]]:
    if isinstance(log, Flight):
        return log, []
    if "t" not in log:
        raise InputError(problem("a table without a column t", "a flight table", "Import the log first."))
    table, findings = timing.order(log)
    return Flight(table, dict(log.attrs)), findings


def _distinct(findings: list[Finding]) -> list[Finding]:
    # impossible sizes are the shadow of a wrong unit that is named already
    units = {c for f in findings if f.code.endswith("_unit") for c in f.channels}
    return [f for f in findings if not (f.code.endswith("_impossible") and set(f.channels) & units)]
