"""Finds where to linearise an effect whose column changes its shape with a number: the length of a swinging load.

An undamped swing drifts out of step with one of another length within seconds, so a few starts are not enough. The
number is scanned over a fine grid on one flight: what the column explains of the whitened residual once every other
column has explained what it can (the profile of the squared error; Golub and Pereyra 1973, variable projection).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from infotraj.diagnosis.candidates import Candidate, Variant, places, read, variants, written
from infotraj.diagnosis.noise import PRIOR
from infotraj.diagnosis.observation import Member, Observation
from infotraj.diagnosis.residual import FlightSamples, flight_samples
from infotraj.diagnosis.sensitivities import sensitivities
from infotraj.diagnosis.whitened import whiten
from infotraj.errors import InputError
from infotraj.rotations import Array

_STEPS = 56
_BEYOND = 1.6  # the grid reaches this far beyond the effect's own starts
_NEARBY = 1.15  # times the number that is sharpened, and its inverse: the ends of the fine grid
_FINE_STEPS = 41
_ROWS = 4000  # of the flight: enough to tell swings apart


def shape_of(candidate: Candidate, observation: Observation) -> int | None:
    """Which fitted number of a candidate changes nothing alone and has several starts; None for most effects."""
    found = variants(candidate, observation.vehicle)
    if len(found) < 2:
        return None
    used = {i for i, _, _ in found[0].points}
    idle = [i for i in range(len(found[0].start)) if i not in used]
    return idle[0] if len(idle) == 1 and found[0].points else None


def scanned(
    observation: Observation, members: Sequence[Member], candidate: Candidate, joint: list[list[Array]], skip: list[int]
) -> Variant | None:
    """The best linearisation of a candidate on the grid, or None for one without a shape.

    joint: residual and all columns, one (m, 3, 1 + p) a channel of a flight, not whitened; skip: the candidate's own.
    """
    shape = shape_of(candidate, observation)
    if shape is None:
        return None
    vehicle = observation.vehicle
    at = places(candidate, vehicle)
    own = variants(candidate, vehicle)
    values = np.array([v.start[shape] for v in own])
    low = max(values.min() / _BEYOND, at[shape].low)
    high = min(values.max() * _BEYOND, at[shape].high)
    s, short = _part(observation, members)
    cut = short(joint)
    moved = [np.any(x[:, :, [1 + c for c in skip]] != 0.0, axis=(0, 2)) for x in cut]
    kept = [i for i in range(cut[0].shape[2]) if i not in {1 + c for c in skip}]

    def stacked(columns: list[Array]) -> Array:
        """Whitened columns on the axes that the candidate moves, one below the other."""
        white = whiten(s, observation.noise, columns)
        return np.concatenate([w[:, axes].reshape(-1, w.shape[2]) for w, axes in zip(white, moved, strict=True)])

    profile = _Profile(stacked([x[:, :, kept] for x in cut]))
    base = observation.model(members)
    before = s.residual(base)
    best: tuple[float, Array] | None = None
    for value in np.geomspace(low, high, _STEPS):
        start = own[0].start.copy()
        for i, _, size in own[0].points:
            start[i] += size
        start[shape] = value
        try:
            after = s.residual(base.with_effects(written(candidate, at, start)))
        except InputError:
            continue
        raw = [(b - a)[:, :, None] for a, b in zip(after, before, strict=True)]
        gain, _ = profile.gain(stacked(raw)[:, 0])
        if best is None or gain > best[0]:
            best = (gain, start)
    if best is None:
        return None
    return _variant(candidate, observation, best[1], own[0])


def sharpened(observation: Observation, members: Sequence[Member], member: Member) -> Member | None:
    """`member` of a fitted model with the best number of its shape near the present one, None for one without a shape.

    The scan's grid is coarser than the valley of a swing that has run for long, and one flight may not show it. Here
    all flights are asked on a fine grid, with all other numbers of the model free to follow.
    """
    shape = shape_of(member.candidate, observation)
    if shape is None:
        return None
    at = places(member.candidate, observation.vehicle)
    now = read(member.effect, at)
    scale = [i for i in range(len(at)) if i != shape]
    rest = [m for m in members if m.candidate.label != member.candidate.label]
    joint = sensitivities(observation, rest, []).joint
    profile = _Profile(_stacked(observation, joint))
    best, found = 0.0, None
    for value in now[shape] * np.geomspace(1 / _NEARBY, _NEARBY, _FINE_STEPS):
        x = now.copy()
        x[shape] = np.clip(value, at[shape].low, at[shape].high)
        after = observation.raw(observation.model([*rest, Member(member.candidate, written(member.candidate, at, x))]))
        if after is None:
            continue
        raw = [
            [(b[:, :, 0] - a)[:, :, None] for a, b in zip(flight, before, strict=True)]
            for flight, before in zip(after, joint, strict=True)
        ]
        gain, times = profile.gain(_stacked(observation, raw)[:, 0])
        if gain > best:
            # The column is linear in the other numbers: as many times theirs as explains most.
            x[scale] = np.clip(x[scale] * times, [at[i].low for i in scale], [at[i].high for i in scale])
            best, found = gain, x
    return None if found is None else Member(member.candidate, written(member.candidate, at, found))


class _Profile:
    """The squared error as a function of one column, all other columns free; every: the residual, then the others."""

    def __init__(self, every: Array) -> None:
        self._residual, self._others = every[:, 0], every[:, 1:]
        gram = self._others.T @ self._others
        self._inverse = np.linalg.inv(gram + np.eye(len(gram)) / PRIOR**2)
        self._along = self._others.T @ self._residual

    def gain(self, column: Array) -> tuple[float, float]:
        """What the column takes off the squared error, and how many times it does; 0, 0 where only less than none."""
        cross = self._others.T @ column
        known = self._inverse @ cross
        size = float(column @ column - known @ cross)
        shared = float(column @ self._residual - known @ self._along)
        if shared <= 0 or size <= 1e-9 * float(column @ column):
            return 0.0, 0.0
        return shared**2 / size, shared / size


def _stacked(observation: Observation, joint: Sequence[Sequence[Array]]) -> Array:
    """Whitened columns (m, 3, c) of all channels and flights, one below the other."""
    parts = []
    for s, columns in zip(observation.samples, joint, strict=True):
        for w in whiten(s, observation.noise, columns):
            parts += [w[:, i] for i in range(3)]
    return np.concatenate(parts)


def _part(observation: Observation, members: Sequence[Member]) -> tuple[FlightSamples, Callable]:
    """The flight to scan on, its first part where it is long, and what cuts the columns of all flights to it."""
    number = int(np.argmax([min(len(s.flight.t), _ROWS) for s in observation.samples]))
    s = observation.samples[number]
    if len(s.flight.t) > 2 * _ROWS:
        t = s.flight.t
        part = flight_samples(observation.model(members), s.flight.between(t[0], t[_ROWS]))
        if [c.key for c in part.channels] == [c.key for c in s.channels]:
            s = part
    counts = [len(c.last) for c in s.channels]
    return s, lambda joint: [x[:n] for x, n in zip(joint[number], counts, strict=True)]


def _variant(candidate: Candidate, observation: Observation, start: Array, like: Variant) -> Variant:
    vehicle = observation.vehicle
    at = places(candidate, vehicle)
    absent = read(candidate.absent(vehicle), at)
    points = []
    used = [i for i, _, _ in like.points]
    for i in used:
        x = start.copy()
        for j in used:
            if j != i:
                x[j] = absent[j]
        points.append((i, written(candidate, at, x), float(start[i] - absent[i])))
    return Variant(candidate, tuple(points), start)
