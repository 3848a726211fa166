"""Finds where to linearise an effect whose column changes its shape with a number: the length of a swinging load.

An undamped swing drifts out of step with one of another length within seconds, so a few starts are not enough. The
number is looked for on one flight over a horizon that extends (`horizons`), by what the column explains of the whitened
residual once every other column has explained what it can (`profile`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from infotraj.diagnosis.candidates import Candidate, Variant, places, read, variants, written
from infotraj.diagnosis.horizons import best_on_grid, grid
from infotraj.diagnosis.observation import Member, Observation
from infotraj.diagnosis.profile import gains_within
from infotraj.diagnosis.residual import FlightSamples, flight_samples
from infotraj.diagnosis.whitened import whiten
from infotraj.errors import InputError
from infotraj.rotations import Array

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
    values = grid(at[shape], [v.start[shape] for v in own])
    s, short = _part(observation, members)
    cut = short(joint)
    moved = [np.any(x[:, :, [1 + c for c in skip]] != 0.0, axis=(0, 2)) for x in cut]
    kept = [i for i in range(cut[0].shape[2]) if i not in {1 + c for c in skip}]

    def stacked(columns: list[Array]) -> Array:
        """Whitened columns on the axes that the candidate moves, one below the other."""
        white = whiten(s, observation.noise, columns)
        return np.concatenate([w[:, axes].reshape(-1, w.shape[2]) for w, axes in zip(white, moved, strict=True)])

    if not any(axes.any() for axes in moved):
        return None
    time = np.concatenate([np.repeat(s.times(c), axes.sum()) for c, axes in zip(s.channels, moved, strict=True)])
    base = observation.model(members)
    before = s.residual(base)

    def start_at(place: int) -> Array:
        start = own[0].start.copy()
        for i, _, size in own[0].points:
            start[i] += size
        start[shape] = values[place]
        return start

    def column(place: int) -> Array | None:
        try:
            after = s.residual(base.with_effects(written(candidate, at, start_at(place))))
        except InputError:
            return None
        return stacked([(b - a)[:, :, None] for a, b in zip(after, before, strict=True)])[:, 0]

    every = stacked([x[:, :, kept] for x in cut])
    best = best_on_grid(len(values), gains_within(every, time - time.min(), column))
    return None if best is None else _variant(candidate, observation, start_at(best), own[0])


def _part(observation: Observation, members: Sequence[Member]) -> tuple[FlightSamples, Callable]:
    """The flight to scan on, its first part where it is long, and what cuts the columns of all flights to it."""
    number = int(np.argmax([min(len(s.flight.t), _ROWS) for s in observation.samples]))
    s = observation.samples[number]
    if len(s.flight.t) > 2 * _ROWS:
        t = s.flight.t
        part = flight_samples(observation.model(members), s.flight.between(t[0], t[_ROWS]))
        # Where another part is used (--from), the whole flight is scanned.
        if [c.key for c in part.channels] == [c.key for c in s.channels] and all(
            np.array_equal(a.last, b.last[: len(a.last)]) for a, b in zip(part.channels, s.channels, strict=True)
        ):
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
