"""Every reading of the log's conventions, and how well the three identities like each: one table of log likelihoods.

A reading says, for the pose, what the attitude holds, in which axes and unit positions are, and whether z points down;
and for each of rate, velocity and specific force, in which frame, axes and unit it is. The log likelihood of a joint
reading is the sum over the identities; a change from what is declared costs PENALTY (prior odds about 400 to 1), so
that the simplest explanation wins: one wrong attitude, not a wrong rate and a wrong accelerometer.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from infotraj import rotations
from infotraj.checking.attitude import READINGS
from infotraj.checking.kinematics import (
    WORLD_AXES,
    Channels,
    acceleration_of,
    body_increment,
    shifted,
    velocity_of,
)
from infotraj.checking.likelihood import AXES, Moments, moments
from infotraj.checking.sizes import Sizes, sizes
from infotraj.checking.streams import attitude_stream
from infotraj.rotations import Array

PENALTY = 6.0
# Constant rests that say nothing about conventions: a gyro without calibration; a mounting or trim angle of three
# degrees.
GYRO_BIAS = 0.1
FORCE_BIAS = 0.5
SHIFTS = np.arange(-0.2, 0.201, 0.02)
FEW_SHIFTS = np.arange(-0.2, 0.201, 0.04)
DEGREE = 180 / np.pi
RATE_UNITS = np.array([1.0, DEGREE, 1 / DEGREE])
FORCE_UNITS = np.array([1.0, 9.80665, 1 / 9.80665])
LENGTH_UNITS = np.array([1.0, 1000.0, 0.001, 100.0, 0.01, 3.6, 1 / 3.6, 3.28084, 0.3048])
POSITION_UNITS = (1.0, 1000.0, 0.001, 100.0, 0.01, 3.28084, 0.3048)
TURNS = (0, 1, -1)
AGAINST = 10.0  # nats: a flight below the ground, or upside down
NOISE = float("inf")


@dataclass(frozen=True)
class Pose:
    """A reading of the pose: index into attitude.READINGS, world axes of the position, its unit (declared / true), and
    whether the whole world has z down. Unit NOISE: the position's acceleration is noise, which it may well be where a
    vehicle hardly moves; that is no error."""

    attitude: int = 0
    axes: str = ""
    unit: float = 1.0
    down: bool = False

    @property
    def penalty(self) -> float:
        unit = 0.0 if self.unit == 1.0 else 0.5 if self.unit == NOISE else 1.1
        # one half of NED/FRD without the other is rarer than any other mistake
        half = READINGS[self.attitude].half
        changes = (self.attitude > 0) + 0.5 * half + 1.1 * (self.axes != "") + unit + 0.9 * self.down
        return PENALTY * changes


@dataclass(frozen=True)
class Vector:
    """A reading of a vector channel: declared = unit x axes x R^turn (true), `removed`: gravity is taken out."""

    turn: int = 0
    axes: int = 0
    unit: float = 1.0
    removed: bool = False

    @property
    def penalty(self) -> float:
        rare = 0.0 if self.axes == 0 else 1.0 if np.array_equal(AXES[self.axes], WORLD_AXES["z down"]) else 1.5
        return PENALTY * ((self.turn != 0) + rare + (self.unit != 1.0) + self.removed)


@dataclass(frozen=True)
class Joint:
    """One joint reading; a channel that the log does not have keeps its declared reading."""

    pose: Pose = field(default_factory=Pose)
    rate: Vector = field(default_factory=Vector)
    velocity: Vector = field(default_factory=Vector)
    force: Vector = field(default_factory=Vector)


@dataclass(frozen=True)
class Identity:
    """One identity: its moments, the log likelihood (poses, variants, axes, units) less the channel's own penalty, the
    best shift of each, and which prediction belongs to (pose, variant)."""

    name: str
    moments: Moments
    shifts: Array
    units: Array
    variants: tuple[tuple[int, bool], ...]
    index: Array
    values: Array
    shift: Array
    penalties: Array

    def row(self, vector: Vector) -> tuple[int, int, int]:
        variant = self.variants.index((vector.turn, vector.removed))
        unit = int(np.argmin(np.abs(np.log(self.units / vector.unit))))
        return variant, vector.axes, unit

    def likelihood(self, pose: int, vector: Vector) -> float:
        """Log likelihood without any penalty."""
        v, g, u = self.row(vector)
        return float(self.values[pose, v, g, u] + self.penalties[v, g, u])

    def residual(self, pose: int, vector: Vector) -> tuple[Array, int]:
        """Sums of squared residuals by block, (B, 3), and the index of the time shift, for one reading."""
        v, g, u = self.row(vector)
        shift = int(self.shift[pose, v, g, u])
        return self.moments.residual(self.index[pose, v], AXES[g], float(self.units[u]))[:, shift], shift

    def series(self, pose: int, vector: Vector) -> tuple[Array, Array]:
        """The channel at the reading's time shift and its prediction, (n, 3) each, less the allowed constant."""
        v, g, u = self.row(vector)
        shift = int(self.shift[pose, v, g, u])
        channel = self.moments.channel[shift]
        prediction = float(self.units[u]) * self.moments.predictions[self.index[pose, v]] @ AXES[g].T
        free = (channel - prediction).mean(axis=0)
        return channel, prediction + np.clip(free, -self.moments.allowance, self.moments.allowance)

    def unexplained(self, pose: int, vector: Vector) -> float:
        """Share of the channel's squares that the reading leaves."""
        residual, shift = self.residual(pose, vector)
        return float(residual.sum() / self.moments.own[:, shift].sum())

    def rms(self, pose: int, vector: Vector) -> float:
        """Root mean squared residual over samples and axes, in the channel's unit."""
        residual, _ = self.residual(pose, vector)
        return float(np.sqrt(max(residual.sum(), 0.0) / (3 * self.moments.count.sum())))


@dataclass(frozen=True)
class Table:
    """All readings of one flight: the poses with their prior log odds, the identities that the log allows, and how
    large the flight is as declared."""

    poses: tuple[Pose, ...]
    prior: Array
    identities: dict[str, Identity]
    sizes: Sizes

    def best(self) -> tuple[Joint, int, float]:
        """The joint reading of the highest posterior, its pose's index, and its log posterior."""
        return max((self.best_for(k) for k in range(len(self.poses))), key=lambda found: found[2])

    def best_for(self, k: int) -> tuple[Joint, int, float]:
        """The same among the readings with pose number k: the channels then do not depend on each other."""
        total, parts = float(self.prior[k]), {}
        for name, identity in self.identities.items():
            flat = int(np.argmax(identity.values[k]))
            parts[name] = _vector(identity, flat)
            total += float(identity.values[k].flat[flat])
        return Joint(pose=self.poses[k], **parts), k, total


def _vector(identity: Identity, flat: int) -> Vector:
    v, g, u = np.unravel_index(flat, identity.values.shape[1:])
    turn, removed = identity.variants[v]
    return Vector(turn, int(g), float(identity.units[u]), removed)


def readings(ch: Channels, gravity: float, rise: float | None) -> Table | None:
    """The table of readings, or None where no identity can be formed. `rise` is how far (m) the vehicle's height
    changed between resting and flying, None where it is not known: a flight is above the place it took off from."""
    poses = _poses(ch)
    prior = np.array([-p.penalty for p in poses])
    if rise is not None and abs(rise) > 0.1:
        up = np.array([WORLD_AXES[p.axes][2, 2] * (-1.0 if p.down else 1.0) for p in poses])
        prior = prior - AGAINST * (up * rise < 0)
    attitudes = _attitudes(ch, poses)
    if attitudes:
        # whatever the axes are called, a vehicle hangs below its rotors for most of a flight
        upright = np.array([_upright(attitudes[p.attitude][1]) for p in poses])
        prior = prior - AGAINST * (upright < 0)
    found = [_rate(ch, poses, attitudes), _velocity(ch, poses, attitudes), _force(ch, poses, attitudes, gravity)]
    identities = {i.name: i for i in found if i is not None}
    return Table(poses, prior, identities, sizes(ch)) if identities else None


def _poses(ch: Channels) -> tuple[Pose, ...]:
    attitudes = range(len(READINGS)) if ch.attitude else range(1)
    frames = [k for k in attitudes if READINGS[k].code == "attitude_frame"]
    found = [Pose(attitude=k, down=d) for k in attitudes for d in (False, True)]
    moving = ch.position is not None
    if moving:
        found += [
            Pose(axes=a, unit=u, down=d)
            for a in WORLD_AXES
            for u in POSITION_UNITS
            for d in (False, True)
            if a or u != 1.0
        ]
        found += [Pose(attitude=k, axes=a) for k in frames for a in WORLD_AXES if a]
        found += [Pose(attitude=k, unit=NOISE, down=d) for k in attitudes for d in (False, True)]
    return tuple(found)


def _attitudes(ch: Channels, poses: tuple[Pose, ...]) -> dict[int, tuple[Array, Array]]:
    out: dict[int, tuple[Array, Array]] = {}
    if ch.attitude is None:
        return out
    for k in sorted({p.attitude for p in poses}):
        true = attitude_stream(replace(ch.attitude, x=READINGS[k].true(ch.attitude.x)))
        out[k] = body_increment(true, ch.centres, ch.width)
    return out


def _upright(q: Array) -> float:
    """Median cosine of the tilt."""
    return float(np.nanmedian(rotations.matrix(q)[:, 2, 2]))


def _rate(ch: Channels, poses: tuple[Pose, ...], attitudes: dict[int, tuple[Array, Array]]) -> Identity | None:
    if ch.rate is None or not attitudes:
        return None
    keys = [(k, turn) for k in attitudes for turn in TURNS]
    predictions = np.stack([_turned(attitudes[k][1], attitudes[k][0], turn) for k, turn in keys])
    index = np.array([[keys.index((p.attitude, turn)) for turn in TURNS] for p in poses])
    m = moments(shifted(ch.rate, ch.centres, ch.width, SHIFTS), predictions, ch.centres, ch.block, GYRO_BIAS)
    return _identity("rate", m, SHIFTS, RATE_UNITS, tuple((t, False) for t in TURNS), index)


def _velocity(ch: Channels, poses: tuple[Pose, ...], attitudes: dict[int, tuple[Array, Array]]) -> Identity | None:
    if ch.velocity is None or ch.position is None:
        return None
    moved = velocity_of(ch.position, ch.centres, ch.width)
    turns = TURNS if attitudes else (0,)
    keys = sorted({(p.attitude, p.axes, p.unit, turn) for p in poses for turn in turns})
    rows = []
    for k, axes, unit, turn in keys:
        v = moved @ WORLD_AXES[axes].T / unit
        rows.append(_turned(attitudes[k][1], v, turn) if turn else v)
    index = np.array([[keys.index((p.attitude, p.axes, p.unit, turn)) for turn in turns] for p in poses])
    # both in another unit of length than metres: then in the same one
    odd = np.array([[p.unit != 1.0 and u not in (1.0, p.unit) for u in LENGTH_UNITS] for p in poses])
    m = moments(shifted(ch.velocity, ch.centres, ch.width, FEW_SHIFTS), np.stack(rows), ch.centres, ch.block, 0.0)
    return _identity("velocity", m, FEW_SHIFTS, LENGTH_UNITS, tuple((t, False) for t in turns), index, odd)


def _force(
    ch: Channels, poses: tuple[Pose, ...], attitudes: dict[int, tuple[Array, Array]], gravity: float
) -> Identity | None:
    if ch.force is None or not attitudes:
        return None
    kinematic = acceleration_of(ch.position, ch.velocity, ch.centres, ch.wide)
    up = np.array([0.0, 0.0, gravity])
    variants = tuple((turn, removed) for removed in (False, True) for turn in TURNS)
    keys = sorted({(p, v) for p in poses for v in variants}, key=lambda key: (poses.index(key[0]), key[1]))
    rows = []
    for p, (turn, removed) in keys:
        world = kinematic @ WORLD_AXES[p.axes].T / p.unit
        if not removed:
            world = world + (-up if p.down else up)
        rows.append(_turned(attitudes[p.attitude][1], world, turn - 1))
    place = {key: k for k, key in enumerate(keys)}
    index = np.array([[place[p, v] for v in variants] for p in poses])
    data = shifted(ch.force, ch.centres, np.sqrt(2) * ch.wide, FEW_SHIFTS)
    m = moments(data, np.stack(rows), ch.centres, ch.block, FORCE_BIAS)
    return _identity("force", m, FEW_SHIFTS, FORCE_UNITS, variants, index)


def _turned(q: Array, vector: Array, turn: int) -> Array:
    for _ in range(abs(turn)):
        vector = rotations.to_world(q, vector) if turn > 0 else rotations.to_body(q, vector)
    return vector


def _identity(
    name: str,
    m: Moments | None,
    shifts: Array,
    units: Array,
    variants: tuple[tuple[int, bool], ...],
    index: Array,
    excluded: Array | None = None,
) -> Identity | None:
    if m is None:
        return None
    values, shift = m.scores(AXES, units)
    penalties = np.array(
        [
            [[Vector(turn, g, float(u), removed).penalty for u in units] for g in range(len(AXES))]
            for turn, removed in variants
        ]
    )
    table = values[index] - penalties
    if excluded is not None:
        table = np.where(excluded[:, None, None, :], -np.inf, table)
    return Identity(name, m, shifts, units, variants, index, table, shift[index], penalties)
