"""Streams that a log holds beside those in its table: a second gyro, an onboard estimate, angles beside quaternions.

They do not enter an answer, but they are declared in the mapping like the others, and a wrong unit or a clock that runs
apart in one of them says something about the log.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from infotraj.checking.clocks import Offset, offset, offset_findings
from infotraj.checking.conventions import convention_findings
from infotraj.checking.finding import Finding, Span, spans_text
from infotraj.checking.kinematics import Channels
from infotraj.checking.readings import readings
from infotraj.checking.streams import Stream, attitude_stream, runs
from infotraj.rotations import Array

FARTHEST = 0.5


@dataclass(frozen=True)
class Beside:
    """One channel (`position`, `attitude`, `velocity`, `rate`) of the stream `name`: `values` (n, k) at `t` (n,) s."""

    name: str
    channel: str
    t: Array
    values: Array


def beside_findings(
    others: list[Beside], ch: Channels, gravity: float, step: float
) -> tuple[list[Finding], dict[str, Offset]]:
    """Conventions (warnings) and clocks (notes) of each stream against the table's own channels; positions apart.

    With them the lags, reported or not, by `stream.channel`.
    """
    found: list[Finding] = []
    lags: dict[str, Offset] = {}
    for other in others:
        stream = _stream(other)
        if stream is None:
            continue
        if other.channel == "position":
            found += _apart(other, stream, ch)
            continue
        pair = _pair(other.channel, stream, ch)
        if pair is not None:
            judged, lag = _judged(other.channel, pair, gravity, step)
            found += [_named(other, f) for f in judged]
            if lag is not None:
                lags[f"{other.name}.{other.channel}"] = lag
    return found, lags


def _stream(other: Beside) -> Stream | None:
    good = np.isfinite(other.values).all(axis=1) & np.isfinite(other.t)
    if good.sum() < 20:
        return None
    t = other.t[good]
    stream = Stream(t, other.values[good], gap=max(5 * float(np.median(np.diff(t))), 0.05))
    return attitude_stream(stream) if other.channel == "attitude" else stream


def _pair(channel: str, stream: Stream, ch: Channels) -> Channels | None:
    alone = replace(ch, force=None)
    if channel == "rate" and ch.attitude is not None:
        return replace(alone, rate=stream, position=None, velocity=None)
    if channel == "attitude" and ch.rate is not None:
        return replace(alone, attitude=stream, position=None, velocity=None)
    if channel == "velocity" and ch.position is not None:
        return replace(alone, velocity=stream, rate=None)
    return None


def _judged(channel: str, pair: Channels, gravity: float, step: float) -> tuple[list[Finding], Offset | None]:
    table = readings(pair, gravity, None)
    name = "velocity" if channel == "velocity" else "rate"
    if table is None or name not in table.identities:
        return [], None
    verdict = convention_findings(table)
    identity = table.identities[name]
    m = identity.moments
    _, predicted = identity.series(verdict.pose, getattr(verdict.joint, name))
    measured = pair.velocity if name == "velocity" else pair.rate
    assert measured is not None
    lag = offset(measured, predicted, m.centres, m.labels[m.block], pair.width)
    if channel == "attitude" and lag is not None:
        # here the attitude is the stream in question: what is late for the rates is early for it
        lag = replace(lag, lag=-lag.lag, segments=tuple((t, -x, e) for t, x, e in lag.segments), drift=-lag.drift)
    texts = {
        "rate": ("the angular velocity", "the attitude", "imu_clock", ("wx", "wy", "wz")),
        "attitude": ("the attitude", "the angular velocity", "attitude_clock", ("qw", "qx", "qy", "qz")),
        "velocity": ("the velocity", "the position", "velocity_clock", ("vx", "vy", "vz")),
    }
    what, behind, code, columns = texts[channel]
    clocks = offset_findings(lag, what, behind, code, columns, step, 0.0)
    wrong = [replace(f, severity="warning") for f in verdict.findings]
    return wrong + [replace(f, severity="note") for f in clocks], lag


def _apart(other: Beside, stream: Stream, ch: Channels) -> list[Finding]:
    if ch.position is None or not len(ch.centres):
        return []
    difference = stream.at(ch.centres) - ch.position.at(ch.centres)
    good = np.isfinite(difference).all(axis=1)
    if good.sum() < 50:
        return []
    # another origin is no fault: the difference is taken from where the flight began
    difference = difference[good] - np.median(difference[good][:50], axis=0)
    distance, t = np.linalg.norm(difference, axis=1), ch.centres[good]
    far = distance > FARTHEST
    if far.mean() < 0.02:
        return []
    spans: tuple[Span, ...] = tuple((float(t[a]), float(t[b - 1])) for a, b in runs(far))
    return [
        Finding(
            "estimate_diverged",
            "note",
            f"stream {other.name} (not in the table): its position leaves the table's by up to {distance.max():.2g} m "
            f"({spans_text(spans)})",
            "whatever flew on that estimate did not fly where it meant to",
            "do not take the state from that stream",
            spans=spans,
            values={"largest": float(distance.max()), "share": float(far.mean())},
        )
    ]


def _named(other: Beside, finding: Finding) -> Finding:
    return replace(
        finding,
        what=f"stream {other.name} (not in the table): {finding.what}",
        effect="none on answers from the table; the mapping, or what is written about the log, is wrong"
        if finding.severity == "warning"
        else "none on answers from the table",
        values={**finding.values, "stream": other.name},
    )
