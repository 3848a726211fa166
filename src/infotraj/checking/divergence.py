"""Times at which a flight contradicts itself: an estimator that diverged, a reference that was not followed."""

from __future__ import annotations

import numpy as np

from infotraj import rotations
from infotraj.checking.finding import Finding, Span, spans_text
from infotraj.checking.kinematics import Channels, acceleration_of, body_increment, velocity_of
from infotraj.checking.streams import runs
from infotraj.flight import POSITION, REFERENCE_POSITION, Flight
from infotraj.rotations import Array, Mask

# Rests that no sensor in order leaves over a second, by identity: rad/s, m/s, m/s^2 (a third of g).
LARGE = {"rate": 1.0, "velocity": 0.5, "force": 3.3}
TIMES_USUAL = 6.0
SMALL_SHARE = 0.15
_PAIRS = {
    "rate": ("attitude and angular velocity", ("qw", "qx", "qy", "qz", "wx", "wy", "wz")),
    "velocity": ("position and velocity", ("px", "py", "pz", "vx", "vy", "vz")),
    "force": ("specific force and the motion of the pose", ("ax", "ay", "az", "px", "py", "pz")),
}


def contradictions(ch: Channels, down: bool, gravity: float) -> list[Finding]:
    """Blocks of 1 s, at least two in a row, in which an identity that holds elsewhere is broken grossly.

    `ch` holds all of the flight, with its conventions corrected; `down`: the world's z axis points down.
    """
    found = []
    for name, (block, squares) in _rests(ch, down, gravity).items():
        labels, index, count = np.unique(block, return_inverse=True, return_counts=True)
        if len(labels) < 5:
            continue
        rms = np.sqrt(np.bincount(index, weights=squares) / count)
        limit = max(LARGE[name], TIMES_USUAL * float(np.median(rms)))
        bad = rms > limit
        in_row = [(a, b) for a, b in runs(bad) if b - a >= 2]
        if not in_row:
            continue
        spans: tuple[Span, ...] = tuple(
            (float(ch.start + labels[a]), float(ch.start + labels[b - 1] + 1)) for a, b in in_row
        )
        share = sum(b - a for a, b in in_row) / len(labels)
        what, columns = _PAIRS[name]
        found.append(
            Finding(
                "contradiction",
                "cut" if share > SMALL_SHARE else "warning",
                f"{what} contradict each other ({spans_text(spans)}): "
                f"{rms[bad].max() / max(np.median(rms), 1e-9):.0f} times the usual difference",
                "an estimator diverged or a sensor failed: the state there is not the vehicle's",
                "use the rest of the flight",
                sure=0.99,
                spans=spans,
                channels=columns,
                values={"usual": float(np.median(rms)), "worst": float(rms.max()), "share": share},
                drop=True,
            )
        )
    return found


def _rests(ch: Channels, down: bool, gravity: float) -> dict[str, tuple[Array, Array]]:
    rests: dict[str, Array] = {}
    turned = body_increment(ch.attitude, ch.centres, ch.width) if ch.attitude is not None else None
    if turned is not None and ch.rate is not None:
        rests["rate"] = ch.rate.mean(ch.centres, ch.width) - turned[0]
    if ch.velocity is not None and ch.position is not None:
        rests["velocity"] = ch.velocity.mean(ch.centres, ch.width) - velocity_of(ch.position, ch.centres, ch.width)
    if turned is not None and ch.force is not None and (ch.position is not None or ch.velocity is not None):
        up = np.array([0.0, 0.0, -gravity if down else gravity])
        world = acceleration_of(ch.position, ch.velocity, ch.centres, ch.wide) + up
        rests["force"] = ch.force.mean(ch.centres, np.sqrt(2) * ch.wide) - rotations.to_body(turned[1], world)
    out = {}
    for name, rest in rests.items():
        good = np.isfinite(rest).all(axis=1)
        out[name] = (ch.block[good], (rest[good] ** 2).sum(axis=1))
    return out


def reference_not_followed(flight: Flight, airborne: Mask) -> list[Finding]:
    """A vehicle that is far from its reference most of the flight: more than half the reference's own extent."""
    if not flight.has(*REFERENCE_POSITION, *POSITION) or airborne.sum() < 20:
        return []
    ref, p = flight.get(*REFERENCE_POSITION)[airborne], flight.get(*POSITION)[airborne]
    error = np.linalg.norm(p - ref, axis=1)
    good = np.isfinite(error)
    if good.sum() < 20:
        return []
    middle = float(np.median(error[good]))
    extent = float(np.linalg.norm(np.nanpercentile(ref, 95, axis=0) - np.nanpercentile(ref, 5, axis=0)))
    if middle < max(0.3, 0.5 * extent):
        return []
    return [
        Finding(
            "reference_not_followed",
            "warning",
            f"the vehicle is {middle:.2g} m from its reference in half of the flight "
            f"(the reference extends over {extent:.2g} m)",
            "the flight is not the one that was asked for: a failed flight, or a reference in another frame",
            "look at the flight before using it",
            values={"median_error": middle, "reference_extent": extent},
        )
    ]
