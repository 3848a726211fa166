"""All checks of one log, in the order in which one needs the other."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from infotraj import rotations
from infotraj.checking import outliers, timing
from infotraj.checking.airborne import Airborne, airborne_rows, no_flight
from infotraj.checking.beside import Beside, beside_findings
from infotraj.checking.clocks import Offset, offset, offset_findings
from infotraj.checking.conventions import Verdict, convention_findings
from infotraj.checking.coverage import coverage, excitation_findings
from infotraj.checking.divergence import contradictions, reference_not_followed, unexplained_rates
from infotraj.checking.finding import Finding, Outcome, Span, ordered, outcome, usable_spans
from infotraj.checking.frozen import dead_findings, still_streams, straight_streams
from infotraj.checking.inertial import force_unit_findings
from infotraj.checking.kinematics import Channels, channels
from infotraj.checking.load import Loaded
from infotraj.checking.questions import question_findings, unanswerable
from infotraj.checking.readings import Table, readings
from infotraj.checking.response import collective, response_findings, response_lag
from infotraj.errors import InputError, problem
from infotraj.flight import ATTITUDE, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

GRAVITY = 9.81
# An IMU whose accelerometer alone lags the pose by less is noted: forces can be derived from the pose as well.
FORCE_LAG_TOLERATED = 0.1


@dataclass(frozen=True)
class Check:
    """What came out for one log: findings (worst first), what becomes of it, the spans (s) that can be used, the time
    in the air and how it was judged, the coverage of states and inputs, and the questions that it cannot answer."""

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
) -> Check:
    """Checks one log: a flight, what `load` made of a raw log (with the streams that its table leaves out), or a table
    with a column t whose order is not known to be right. Raises InputError for a table without t.
    """
    others: list[Beside] = []
    if isinstance(log, Loaded):
        flight, findings, others = log.flight, list(log.findings), log.beside
    else:
        flight, findings = _in_order(log)
    source = str(flight.meta.get("source", "flight"))
    flight, more = timing.time_unit(flight)
    findings += more + outliers.attitude_norm(flight)
    flight = _without_bad_attitudes(flight)
    straight = straight_streams(flight)
    for dead in straight:
        flight = _voided(flight, dead.rows, dead.columns)
    air = airborne_rows(flight, vehicle)
    findings += dead_findings(flight, straight, air.rows, "straight")
    findings += no_flight(flight, air)
    still = still_streams(flight, air.rows)
    findings += dead_findings(flight, still, air.rows, "still")
    for dead in still:
        flight = _voided(flight, dead.rows, dead.columns)
    findings += timing.gaps(flight, air.rows) + timing.jitter(flight)
    commands = outliers.impossible_commands(flight, air.rows, vehicle)
    single = outliers.spikes(flight, air.rows)
    findings += commands + single + outliers.saturation(flight, air.rows) + outliers.pose_jumps(flight, air.rows)
    for finding in single:
        at = np.any([(flight.t >= a) & (flight.t <= b) for a, b in finding.spans], axis=0)
        flight = _voided(flight, at, finding.channels)
    findings += outliers.impossible_values(flight, air.rows)
    gravity = vehicle.gravity if vehicle else GRAVITY
    findings += _kinematics(flight, air, gravity, others)
    findings += reference_not_followed(flight, air.rows) + question_findings(flight)
    covered = coverage(flight, air.rows)
    findings += excitation_findings(covered)
    findings = ordered(_distinct(findings))
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
        unanswerable(flight),
    )


def _in_order(log: Flight | pd.DataFrame) -> tuple[Flight, list[Finding]]:
    if isinstance(log, Flight):
        return log, []
    if "t" not in log:
        raise InputError(problem("a table without a column t", "a flight table", "Import the log first."))
    table, findings = timing.order(log)
    return Flight(table, dict(log.attrs)), findings


def _kinematics(flight: Flight, air: Airborne, gravity: float, others: list[Beside]) -> list[Finding]:
    ch = channels(flight, air.rows)
    if len(ch.centres) == 0:
        return force_unit_findings(flight, air.rows)
    table = readings(ch, gravity, _rise(flight, air))
    if table is None:
        return force_unit_findings(flight, air.rows) + _response(flight, ch, None)
    verdict = convention_findings(table)
    findings = list(verdict.findings)
    if "force" not in table.identities:
        findings += force_unit_findings(flight, air.rows)
    findings += contradictions(table, verdict, float(flight.t[0])) + unexplained_rates(table, verdict)
    findings += _clocks(flight, ch, table, verdict)
    if not verdict.findings:
        findings += _response(flight, ch, table)
        findings += beside_findings(others, ch, gravity, float(np.median(np.diff(flight.t))))
    return findings


def _clocks(flight: Flight, ch: Channels, table: Table, verdict: Verdict) -> list[Finding]:
    step = float(np.median(np.diff(flight.t)))
    found = []
    rate = _lag(table, verdict, "rate", ch)
    found += offset_findings(rate, "the angular velocity", "the attitude", "imu_clock", RATE, step, 0.0)
    velocity = _lag(table, verdict, "velocity", ch)
    found += offset_findings(velocity, "the velocity", "the position", "velocity_clock", VELOCITY, step, 0.0)
    force = _lag(table, verdict, "force", ch)
    found += offset_findings(
        force, "the specific force", "the pose", "accelerometer_clock", SPECIFIC_FORCE, step, FORCE_LAG_TOLERATED
    )
    return found


def _lag(table: Table, verdict: Verdict, name: str, ch: Channels) -> Offset | None:
    identity = table.identities.get(name)
    stream = {"rate": ch.rate, "velocity": ch.velocity, "force": ch.force}[name]
    if identity is None or stream is None:
        return None
    m = identity.moments
    vector = getattr(verdict.joint, name)
    _, predicted = identity.series(verdict.pose, vector)
    width = ch.width * (np.sqrt(2) if name == "force" else 1.0)
    return offset(stream, predicted, m.centres, m.labels[m.block], width)


def _response(flight: Flight, ch: Channels, table: Table | None) -> list[Finding]:
    command = collective(flight)
    if command is None or ch.force is None:
        return []
    lag = response_lag(command, ch.force, ch.centres, ch.block, ch.width)
    return response_findings(lag, float(np.median(np.diff(flight.t))))


def _rise(flight: Flight, air: Airborne) -> float | None:
    if air.ground is None or not flight.has("pz"):
        return None
    return float(np.nanmedian(flight.get("pz")[air.rows, 0]) - air.ground)


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
