"""The best number of an effect's shape, the length of a swinging load's cable, wherever a fit stands.

It is looked for over a horizon that extends (`horizons`), all other numbers of the model free to follow (`profile`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from infotraj.diagnosis.candidates import places, read, written
from infotraj.diagnosis.fitting import Fit, fit
from infotraj.diagnosis.horizons import best_on_grid, grid
from infotraj.diagnosis.observation import Member, Observation
from infotraj.diagnosis.profile import Profile, gains_within
from infotraj.diagnosis.scanning import shape_of
from infotraj.diagnosis.sensitivities import sensitivities
from infotraj.diagnosis.whitened import stacked
from infotraj.rotations import Array

_LITTLE = 0.3  # usual sizes of what multiplies the shape: a smaller effect shows none


def sharp_fit(observation: Observation, made: Fit) -> Fit:
    """The fit with the shapes of its members, but not of held ones, where they are best; the same if no better."""
    for m in made.members:
        better = None if m.held else sharpened(observation, made.members, m)
        if better is None:
            continue
        moved = [better if x.candidate.label == m.candidate.label else x for x in made.members]
        again = fit(observation, moved)
        made = again if again is not None and again.cost < made.cost else made
    return made


def sharpened(observation: Observation, members: Sequence[Member], member: Member) -> Member | None:
    """`member` of a fitted model with the best number of its shape; None without a shape, or where none explains."""
    shape = shape_of(member.candidate, observation)
    if shape is None:
        return None
    o, cls, form = observation, member.candidate.cls, member.candidate.form
    at = places(member.candidate, o.vehicle)
    others = [i for i in range(len(at)) if i != shape]
    absent, scale = (np.array([getattr(p, what) for p in at]) for what in ("absent", "scale"))
    starts = [read(member.candidate.at(values), at) for values in cls.starts(o.vehicle, form)]
    now = read(member.effect, at)
    if np.all(np.abs(now - absent)[others] < _LITTLE * np.abs(scale[others])):
        now = starts[0]
    values = grid(at[shape], [x[shape] for x in starts])
    rest = [m for m in members if m.candidate.label != member.candidate.label]
    joint = sensitivities(o, rest, []).joint
    every = stacked(o.samples, o.noise, joint)

    def with_numbers(x: Array) -> Member:
        return replace(member, effect=written(member.candidate, at, x))

    def numbers(place: int) -> Array:
        return np.where(np.arange(len(at)) == shape, values[place], now)

    def column(place: int) -> Array | None:
        after = o.raw(o.model([*rest, with_numbers(numbers(place))]))
        return None if after is None else stacked(o.samples, o.noise, _change(joint, after))[:, 0]

    best = best_on_grid(len(values), gains_within(every, _since_first(o), column))
    if best is None:
        return None
    x = numbers(best)
    _, times = Profile(every).gain(column(best))
    x[others] = (absent + times * (x - absent))[others]
    return with_numbers(np.clip(x, [p.low for p in at], [p.high for p in at]))


def _since_first(observation: Observation) -> Array:
    """Time (s) of every whitened sample since the first of its flight, in the order of `stacked`."""
    parts = []
    for s in observation.samples:
        first = min(s.times(c)[0] for c in s.channels)
        parts += [np.tile(s.times(c) - first, 3) for c in s.channels]
    return np.concatenate(parts)


def _change(joint: Sequence[Sequence[Array]], after: Sequence[Sequence[Array]]) -> list[list[Array]]:
    return [
        [(before[:, :, 0] - a)[:, :, None] for a, before in zip(flight, joint_of, strict=True)]
        for flight, joint_of in zip(after, joint, strict=True)
    ]
