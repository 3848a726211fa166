"""What a rigid body's motion says about a log: conventions first, then clocks and contradictions under them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from infotraj import rotations
from infotraj.checking.airborne import Airborne
from infotraj.checking.beside import Beside, beside_findings
from infotraj.checking.clocks import TIMES_ERROR, Offset, offset, offset_findings, one_clock
from infotraj.checking.conventions import Verdict, convention_findings
from infotraj.checking.correction import corrected
from infotraj.checking.divergence import contradictions
from infotraj.checking.finding import Finding
from infotraj.checking.following import unfollowed
from infotraj.checking.inertial import force_unit_findings
from infotraj.checking.kinematics import Channels, channels, velocity_of
from infotraj.checking.readings import Table, readings
from infotraj.checking.response import collective, response_findings, response_lag
from infotraj.flight import COMMANDED_FORCE, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.rotations import Array

# The filters of sensors and the transport of poses make lags of this size in logs that are in order: noted.
FILTER_LAG = 0.015
# An estimator's velocity follows its own position loosely: the one comes from the IMU, the other from what corrects it.
VELOCITY_LAG = 0.05
# An accelerometer that alone lags the pose by less is noted: forces can be derived from the pose as well, and an IMU
# away from the origin looks alike.
FORCE_LAG_TOLERATED = 0.1
Judge = Callable[[Table], Verdict]
_CLOCKS = {
    "rate": ("the angular velocity", "the attitude", "imu_clock", RATE, FILTER_LAG),
    "velocity": ("the velocity", "the position", "velocity_clock", VELOCITY, VELOCITY_LAG),
    "force": ("the specific force", "the pose", "accelerometer_clock", SPECIFIC_FORCE, FORCE_LAG_TOLERATED),
}


@dataclass(frozen=True)
class Motion:
    """Findings about units, frames, clocks and contradictions, and every lag that could be estimated, by name."""

    findings: list[Finding]
    lags: dict[str, Offset]


def judge_motion(
    flight: Flight, air: Airborne, gravity: float, others: list[Beside], judge: Judge = convention_findings
) -> Motion:
    """What the motion of a rigid body says about a flight's channels and about the streams beside them.

    `judge` decides about the conventions: by this flight alone, or by all that share its mapping (`pooled`).
    """
    ch = channels(flight, air.rows)
    if len(ch.centres) == 0:
        return Motion(force_unit_findings(flight, air.rows), {})
    table = readings(ch, gravity, _rise(flight, air))
    if table is None:
        return Motion(force_unit_findings(flight, air.rows) + _response(flight, ch), {})
    verdict = judge(table)
    unfollowing = unfollowed(table, verdict, flight.meta.get("notes") or ())
    unread = {c for f in unfollowing for c in f.channels}
    # a reading under which a channel still does not follow is none
    findings = [f for f in verdict.findings if not unread & set(f.channels)]
    if "force" not in table.identities:
        findings += force_unit_findings(flight, air.rows)
    every = corrected(channels(flight, air.rows, most=None), verdict.joint)
    findings += contradictions(every, verdict.joint.pose.down, gravity) + unfollowing
    step = float(np.median(np.diff(flight.t)))
    lags = {name: lag for name in ("rate", "velocity", "force") if (lag := _lag(table, verdict, name, ch)) is not None}
    # An IMU has one clock: what moves its gyroscope moves its accelerometer.
    imu = one_clock(lags.get("rate"), lags.get("force"))
    for name, lag in lags.items():
        if imu and name == "force":
            continue
        what, behind, code, columns, tolerated = _CLOCKS[name]
        if imu and name == "rate":
            what = "the IMU"
        findings += offset_findings(
            lag, what, behind, code, columns, step, tolerated, SPECIFIC_FORCE if imu and name == "rate" else ()
        )
    if not verdict.findings:
        findings += _response(flight, _on_time(ch, lags.get("force")))
    more, known = beside_findings(others, corrected(ch, verdict.joint), gravity, step)
    return Motion(findings + more, {**lags, **known})


def _on_time(ch: Channels, lag: Offset | None) -> Channels:
    """The channels with the specific force where the pose says it was: a command is not late for its clock."""
    known = lag is not None and lag.unexplained < 0.5 and abs(lag.lag) > max(FILTER_LAG, TIMES_ERROR * lag.error)
    if ch.force is None or lag is None or not known:
        return ch
    return replace(ch, force=replace(ch.force, t=ch.force.t - lag.lag))


def _lag(table: Table, verdict: Verdict, name: str, ch: Channels) -> Offset | None:
    identity = table.identities.get(name)
    stream = {"rate": ch.rate, "velocity": ch.velocity, "force": ch.force}[name]
    if identity is None or stream is None:
        return None
    m = identity.moments
    vector = getattr(verdict.joint, name)
    _, predicted = identity.series(verdict.pose, vector)
    width = np.sqrt(2) * ch.wide if name == "force" else ch.width
    return offset(stream, predicted, m.centres, m.labels[m.block], width)


def _air(ch: Channels) -> Array | None:
    """What inflow and lift of the rotors go with at the centres, (n, 3): the speed along body z, upwards, and squared;
    None where the speed is not known."""
    if ch.velocity is not None:
        v = ch.velocity.at(ch.centres)
    elif ch.position is not None:
        v = velocity_of(ch.position, ch.centres, ch.width)
    else:
        return None
    along = v[:, 2]
    if ch.attitude is not None:
        along = rotations.to_body(rotations.normalize(ch.attitude.at(ch.centres)), v)[:, 2]
    return np.stack([along, v[:, 2], (v**2).sum(axis=1)], axis=1)


def _response(flight: Flight, ch: Channels) -> list[Finding]:
    command = collective(flight)
    if command is None or ch.force is None:
        return []
    lag = response_lag(command, ch.force, ch.centres, ch.block, ch.width, _air(ch))
    channel = "commanded_force" if flight.has(*COMMANDED_FORCE) else "rotor_command"
    return response_findings(lag, float(np.median(np.diff(flight.t))), channel)


def _rise(flight: Flight, air: Airborne) -> float | None:
    if air.ground is None or not flight.has("pz"):
        return None
    return float(np.nanmedian(flight.get("pz")[air.rows, 0]) - air.ground)
