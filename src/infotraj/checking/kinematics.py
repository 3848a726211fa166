"""The three kinematic identities of a rigid body, as channels and predictions that pass the same averaging.

    rate:          the rotation from q(t - h/2) to q(t + h/2), over h       = mean of the angular velocity over h
    velocity:      (p(t + h/2) - p(t - h/2)) / h                            = mean of the velocity over h
    acceleration:  R' ((p(t + h) - 2 p(t) + p(t - h)) / h^2 + g e_z)        = mean of the specific force over sqrt(2) h

Both sides of the first two pass exactly the same box average; the second difference weighs with a triangle of half
width h, and the box of width sqrt(2) h has the same variance (and both are symmetric: no time shift).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj import rotations
from infotraj.checking.attitude import NED_TO_ENU
from infotraj.checking.streams import Stream, attitude_stream, runs, stream
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.rotations import Array, Mask

MOST_BLOCKS = 90
PIECES = 3
EDGE = 0.5
ACCELERATION_NOISE = 0.15

WORLD_AXES: dict[str, Array] = {
    "": np.eye(3),
    "NED": rotations.matrix(NED_TO_ENU),
    "z down": np.diag([1.0, -1.0, -1.0]),
}


@dataclass(frozen=True)
class Channels:
    """The streams of one flight that kinematics ties together (None where absent or derived from each other), the
    averaging width (s) for velocities and rates, the one for accelerations, and the sample times (n,) with their block
    numbers (n,), counted in s from `start`."""

    attitude: Stream | None
    position: Stream | None
    velocity: Stream | None
    rate: Stream | None
    force: Stream | None
    width: float
    wide: float
    centres: Array
    block: Array
    start: float


def channels(flight: Flight, airborne: Mask, most: int | None = MOST_BLOCKS) -> Channels:
    """Streams and sample times in the air: at most `most` blocks of 1 s, in PIECES pieces spread over the flight.

    Columns that the metadata call `derived` are left out: they agree with their source by construction. Half a second
    beside take-off and landing is left out too: impacts say nothing about conventions.
    """
    derived = derived_columns(flight)

    def own(columns: tuple[str, ...]) -> Stream | None:
        return None if set(columns) & derived else stream(flight, columns)

    attitude = own(ATTITUDE)
    attitude = attitude_stream(attitude) if attitude else None
    position, velocity = own(POSITION), own(VELOCITY)
    rates, force = own(RATE), own(SPECIFIC_FORCE)
    steps = [s.step for s in (attitude, position, velocity) if s] or [s.step for s in (rates, force) if s] or [0.01]
    width = float(max(0.08, 2 * max(steps)))
    wide = acceleration_width(position, width)
    centres = _centres(flight.t, airborne, width)
    block = np.floor(centres - flight.t[0]).astype(int)
    labels = np.unique(block)
    if most is not None and len(labels) > most:
        starts = np.linspace(0, len(labels) - most // PIECES, PIECES).round().astype(int)
        chosen = labels[np.unique(starts[:, None] + np.arange(most // PIECES))]
        keep = np.isin(block, chosen)
        centres, block = centres[keep], block[keep]
        near = [_near(s, centres) for s in (attitude, position, velocity, rates, force)]
        attitude, position, velocity, rates, force = near
    return Channels(attitude, position, velocity, rates, force, width, wide, centres, block, float(flight.t[0]))


def _near(stream: Stream | None, centres: Array) -> Stream | None:
    # what lies far from every sample time is not looked at; the hole that it leaves is a gap
    if stream is None:
        return None
    after = np.clip(np.searchsorted(centres, stream.t), 1, len(centres) - 1)
    distance = np.minimum(np.abs(stream.t - centres[after - 1]), np.abs(stream.t - centres[after]))
    keep = distance < 1.0
    return Stream(stream.t[keep], stream.x[keep], stream.gap) if keep.sum() > 20 else None


def derived_columns(flight: Flight) -> set[str]:
    """The columns that the metadata entry `derived` names (a list, or a mapping from column to source)."""
    derived = flight.meta.get("derived") or ()
    return {str(c) for c in derived}


def acceleration_width(p: Stream | None, width: float) -> float:
    """The width (s) at which the second difference of the position has at most ACCELERATION_NOISE of noise.

    The noise of a sample is that of its third differences (robust), which motion hardly reaches: std / sqrt(20). The
    second difference over h then has sqrt(6) sigma / h^2. Never below `width`, never above four times it.
    """
    if p is None or len(p.t) < 20:
        return width
    third = np.diff(p.x, 3, axis=0)
    sigma = float(1.4826 * np.median(np.abs(third)) / np.sqrt(20))
    return float(np.clip(np.sqrt(np.sqrt(6) * sigma / ACCELERATION_NOISE), width, 4 * width))


def body_increment(q: Stream, centres: Array, width: float) -> tuple[Array, Array]:
    """Mean angular velocity in the body frame (n, 3), rad/s, by the rotation over `width`, and q at the centres."""
    before, middle, after = (rotations.normalize(q.at(centres + s * width)) for s in (-0.5, 0.0, 0.5))
    # expressed at the middle of the interval: half the increment turns it back, which leaves the vector as it is
    return rotations.log(rotations.multiply(rotations.conjugate(before), after)) / width, middle


def velocity_of(p: Stream, centres: Array, width: float) -> Array:
    """Mean velocity (n, 3) over `width` from positions."""
    return (p.at(centres + width / 2) - p.at(centres - width / 2)) / width


def acceleration_of(p: Stream | None, v: Stream | None, centres: Array, width: float) -> Array:
    """Mean acceleration (n, 3): second difference of p, else first difference of v, else zero."""
    if p is not None:
        return (p.at(centres + width) - 2 * p.at(centres) + p.at(centres - width)) / width**2
    if v is not None:
        wide = np.sqrt(2) * width
        return (v.at(centres + wide / 2) - v.at(centres - wide / 2)) / wide
    return np.zeros((len(centres), 3))


def shifted(channel: Stream, centres: Array, width: float, shifts: Array) -> Array:
    """The channel averaged over `width` at centres + shift, (L, n, 3)."""
    return np.stack([channel.mean(centres + s, width) for s in shifts])


def _centres(t: Array, airborne: Mask, width: float) -> Array:
    pieces = []
    for a, b in runs(airborne):
        start, stop = t[a] + EDGE, t[b - 1] - EDGE
        if stop - start > 1.0:
            pieces.append(np.arange(start, stop, width / 3))
    return np.concatenate(pieces) if pieces else np.empty(0)
