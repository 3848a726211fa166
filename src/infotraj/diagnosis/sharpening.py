"""The best number of an effect's shape, the length of a swinging load's cable, wherever a fit stands.

It is looked for over a horizon that extends (`horizons`), with all other numbers of the model free to follow (variable
projection, Golub and Pereyra 1973).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from infotraj.diagnosis.candidates import places as places_of
from infotraj.diagnosis.candidates import read, written
from infotraj.diagnosis.fitting import Fit, fit
from infotraj.diagnosis.horizons import best_on_grid, grid
from infotraj.diagnosis.observation import Member, Observation
from infotraj.diagnosis.scanning import Profile, shape_of
from infotraj.diagnosis.sensitivities import sensitivities
from infotraj.diagnosis.whitened import stacked
from infotraj.rotations import Array

_LITTLE = 0.3  # usual sizes of what multiplies the shape: a smaller effect shows none


def sharp_fit(observation: Observation, made: Fit) -> Fit:
    """The fit with the shapes of its members where they are best, the same where that is no better."""
    for m in made.members:
        better = None if m.held else sharpened(observation, made.members, m)
        if better is None:
            continue
        moved = [better if x.candidate.label == m.candidate.label else x for x in made.members]
        again = fit(observation, moved)
        made = again if again is not None and again.cost < made.cost else made
    return made


def sharpened(observation: Observation, members: Sequence[Member], member: Member) -> Member | None:
    """`member` of a fitted model with the best number of its shape, None for one without a shape."""
    shape = shape_of(member.candidate, observation)
    if shape is None:
        return None
    trials = _Trials(observation, members, member, shape)
    return trials.best(best_on_grid(len(trials.values), trials.gains))


class _Trials:
    """Models with other numbers of one member's shape: `values`, those of a grid within its bounds."""

    def __init__(self, observation: Observation, members: Sequence[Member], member: Member, shape: int) -> None:
        self._observation, self._member, self._shape = observation, member, shape
        self._at = places_of(member.candidate, observation.vehicle)
        starts = member.candidate.cls.starts(observation.vehicle, member.candidate.form)
        now, usual = (read(effect, self._at) for effect in (member.effect, member.candidate.at(starts[0])))
        absent, scale = (np.array([getattr(p, what) for p in self._at]) for what in ("absent", "scale"))
        # Where nearly nothing is left of the effect, its shape shows nothing.
        self._now = np.where(np.abs(now - absent) < _LITTLE * np.abs(scale), usual, now)
        self._rest = [m for m in members if m.candidate.label != member.candidate.label]
        self._joint = sensitivities(observation, self._rest, []).joint
        self._base = stacked(observation.samples, observation.noise, self._joint)
        parts = [s.times(c) for s in observation.samples for c in s.channels]
        first = [min(s.times(c)[0] for c in s.channels) for s in observation.samples for _ in s.channels]
        self._time = np.concatenate([np.tile(t - t0, 3) for t, t0 in zip(parts, first, strict=True)])
        self.values = grid(self._at[shape].low, self._at[shape].high)
        self._columns: dict[int, Array | None] = {}

    def gains(self, places: Iterable[int], horizon: float) -> tuple[dict[int, float], float]:
        """What the member takes off the squared error of the flights' first `horizon` seconds, and what is left."""
        rows = self._time <= horizon
        base = self._base[rows]
        profile = Profile(base)
        found = {}
        for p in places:
            column = self._column(p)
            found[p] = 0.0 if column is None else profile.gain(column[rows])[0]
        return found, (profile.left - max(found.values())) / len(base)

    def best(self, place: int) -> Member | None:
        """The member there, its other numbers as large as explains most; None where it explains nothing."""
        column = self._column(place)
        gain, times = (0.0, 0.0) if column is None else Profile(self._base).gain(column)
        if gain <= 0.0:
            return None
        x = self._numbers(place)
        for i, at in enumerate(self._at):
            if i != self._shape:
                x[i] = np.clip(x[i] * times, at.low, at.high)
        return replace(self._member, effect=written(self._member.candidate, self._at, x))

    def _numbers(self, place: int) -> Array:
        x = self._now.copy()
        x[self._shape] = self.values[place]
        return x

    def _column(self, place: int) -> Array | None:
        """The whitened change of the prediction by the member, None where no model can be evaluated."""
        if place not in self._columns:
            o = self._observation
            effect = written(self._member.candidate, self._at, self._numbers(place))
            after = o.raw(o.model([*self._rest, replace(self._member, effect=effect)]))
            self._columns[place] = (
                None if after is None else stacked(o.samples, o.noise, _change(self._joint, after))[:, 0]
            )
        return self._columns[place]


def _change(joint: Sequence[Sequence[Array]], after: Sequence[Sequence[Array]]) -> list[list[Array]]:
    return [
        [(before[:, :, 0] - a)[:, :, None] for a, before in zip(flight, joint_of, strict=True)]
        for flight, joint_of in zip(after, joint, strict=True)
    ]
