"""A model made linear around a point: residual, one column a number, and what is known of each number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from infotraj.diagnosis.linear.candidates import Candidate, Variant, places, read, written
from infotraj.diagnosis.linear.observation import Member, Observation
from infotraj.diagnosis.linear.sensitivities import sensitivities
from infotraj.diagnosis.linear.sums import Sums, gathered
from infotraj.diagnosis.noise.spectra import Spectrum, Weights, spectra, weights
from infotraj.diagnosis.select.prior import Scales, is_file_number, price, spikes
from infotraj.diagnosis.select.score import Choice, Scorer
from infotraj.rotations import Array

_NEAR = 0.3  # usual sizes within which a number's column stays what it is


@dataclass(frozen=True)
class Column:
    """One number: its candidate, place in the form, usual size, value now and bounds, usual sizes from absent.

    idle: it changes nothing on its own (the length of a cable without a load).
    """

    candidate: Candidate
    place: int
    scale: float
    now: float
    low: float
    high: float
    idle: bool = False


@dataclass(frozen=True)
class Linear:
    """The model around `point`: its members now (held effects, chosen ones, file numbers that are off).

    columns: every number; choices: sets of columns that stand for an effect, held ones left out; variants: of each
    choice, None where it is a member; found: residual and columns as spectra; weights, sums: see there.
    """

    observation: Observation
    point: tuple[Member, ...]
    columns: tuple[Column, ...]
    choices: tuple[Choice, ...]
    variants: tuple[Variant | None, ...]
    found: tuple[Spectrum, ...]
    weights: Weights
    sums: Sums

    @cached_property
    def now(self) -> Array:
        """Every number now, usual sizes from absent, (p,)."""
        return np.array([0.0 if c.idle else c.now for c in self.columns])

    @cached_property
    def absent(self) -> Sums:
        """The sums of the model without any of the numbers, extrapolated."""
        return self.sums.shifted(-self.now)

    @cached_property
    def kept(self) -> tuple[int, ...]:
        """Columns of the effects that the model has already."""
        held = {m.candidate.label for m in self.point if m.held}
        return tuple(i for i, c in enumerate(self.columns) if c.candidate.label in held)

    def scorer(self, scales: Scales, held: Sequence[Member] | None = None) -> Scorer:
        """What scores sets of effects when the file is off by as much as `scales` says.

        held: the effects that the model has already, with numbers that stay; where not given they are fitted along.
        """
        low, high = np.array([c.low for c in self.columns]), np.array([c.high for c in self.columns])
        idle = np.array([c.idle for c in self.columns])
        now = np.array([c.now for c in self.columns])
        # An idle number is told as a step from where it is.
        low, high = np.where(idle, low - now, low), np.where(idle, high - now, high)
        if held is None:
            return Scorer(self.absent, self.choices, self.kept, self.spike(scales), low, high)
        given = self._numbers(held)
        return Scorer(self.absent.shifted(given), self.choices, (), self.spike(scales), low, high, given)

    def spike(self, scales: Scales) -> Array:
        """Deviation of every column's file number, 0 for what is none; one linearisation of a number counts."""
        step = self.observation.command_step
        out = spikes([(c.candidate, c.scale) for c in self.columns], scales, step, self.observation.vehicle)
        seen: dict[tuple[str, int], int] = {}
        for i, c in enumerate(self.columns):
            if seen.setdefault((c.candidate.label, c.place), i) != i:
                out[i] = 0.0
        return out

    def weighed_by(self, observation: Observation) -> Linear:
        """The same columns where other axes count."""
        weighed = weights(self.found, observation.ignored)
        sums = gathered(self.found, weighed, observation.blocks)
        return replace(self, observation=observation, weights=weighed, sums=sums)

    def labelled(self, labels: Sequence[str]) -> tuple[int, ...]:
        """The choices with these labels, the first of each."""
        first: dict[str, int] = {}
        for i, c in enumerate(self.choices):
            first.setdefault(c.label, i)
        return tuple(first[label] for label in labels)

    def _numbers(self, members: Sequence[Member]) -> Array:
        """The numbers of these members, usual sizes from absent, (p,); 0 for all others."""
        out = np.zeros(len(self.columns))
        for m in members:
            at = places(m.candidate, self.observation.vehicle)
            values = read(m.effect, at)
            for i, c in enumerate(self.columns):
                if c.candidate.label == m.candidate.label and not c.idle:
                    out[i] = (values[c.place] - at[c.place].absent) / c.scale
        return out

    def members(self, chosen: Sequence[int], theta: Array, shift: float, straight: bool = False) -> tuple[Member, ...]:
        """Held and chosen effects, and file numbers that shift the residual, with numbers theta (p,).

        shift: weighted squared error above which a file number is taken along.
        """
        vehicle = self.observation.vehicle
        labels = {self.choices[i].label for i in chosen}
        held = {m.candidate.label: m for m in self.point if m.held}
        gram = np.diag(self.sums.gram.sum(axis=(0, 1)))[1:]
        by_label: dict[str, dict[int, float]] = {}
        variant = {self.choices[i].label: self.variants[i] for i in chosen}
        moved: dict[str, float] = {}
        candidates: dict[str, Candidate] = {}
        chosen_columns = {c for i in chosen for c in self.choices[i].columns}
        for i, c in enumerate(self.columns):
            label = c.candidate.label
            taken = label in held or (label in labels and i in chosen_columns)
            loose = (
                label not in labels
                and label not in held
                and is_file_number(c.candidate)
                and (straight or not c.candidate.cls.linear)
            )
            if not taken and not (loose and theta[i] != 0.0):
                continue
            candidates[label] = c.candidate
            by_label.setdefault(label, {})[c.place] = (theta[i] + (c.now if c.idle else 0.0)) * c.scale
            moved[label] = moved.get(label, 0.0) + theta[i] ** 2 * gram[i]
        out = []
        for label, numbers in by_label.items():
            if label not in held and label not in labels and moved[label] < shift:
                continue
            candidate = candidates[label]
            at = places(candidate, vehicle)
            start = variant.get(label)
            x = start.start.copy() if start is not None else read(_now(self.point, candidate, vehicle), at)
            for place, value in numbers.items():
                p = at[place]
                x[place] = np.clip(p.absent + value, p.low, p.high)
            effect = written(candidate, at, x)
            out.append(Member(candidate, effect, held=label in held))
        return tuple(sorted(out, key=lambda m: not m.held))


def _now(point: Sequence[Member], candidate: Candidate, vehicle):
    for m in point:
        if m.candidate.label == candidate.label:
            return m.effect
    return candidate.absent(vehicle)


def linearised(
    observation: Observation,
    point: Sequence[Member],
    known: Sequence[Candidate],
    more: Mapping[str, Sequence[Variant]] | None = None,
    like: Linear | None = None,
    frozen: bool = False,
) -> Linear:
    """The model around `point`, with the columns of all candidates.

    more: further linearisations by label; like: an earlier one, whose columns of absent effects are used again, but for
    those that act only beside others which have changed; frozen: its weights are used again, too.
    """
    vehicle, more = observation.vehicle, more or {}
    inside = {m.candidate.label for m in point}
    absent = [c for c in known if c.label not in inside]
    old: list[int] = []  # columns of `like` that are used again
    reused: list[Choice] = []
    of_reused: list[Variant | None] = []
    near: dict[str, list[int]] = {}
    if like is not None:
        names = {m.candidate.name for m in point}
        changed = names ^ {m.candidate.name for m in like.point}
        again = {c.label for c in known if c.label in more or changed & {*c.cls.beside}}
        near = {m.candidate.label: own for m in point if (own := _columns_near(like, m)) is not None}
        for choice, variant in zip(like.choices, like.variants, strict=True):
            if variant is not None and choice.label not in inside and choice.label not in again:
                reused.append(choice)
                of_reused.append(variant)
                old += choice.columns
        has = {c.label for c in reused}
        absent = [c for c in absent if c.label not in has]
        old += [i for own in near.values() for i in own]
    found = sensitivities(observation, point, absent, more, frozenset(near))
    first = found.joint[0][0].shape[2] - 1
    columns: list[Column] = [None] * (first + len(old))  # type: ignore[list-item]
    alike = {name: sum(c.name == name for c in known) for name in {c.name for c in known}}
    choices: list[Choice] = []
    variants: list[Variant | None] = []
    for m, fresh in zip(point, found.members, strict=True):
        label = m.candidate.label
        at = tuple(first + old.index(i) for i in near[label]) if label in near else tuple(fresh)
        now = read(m.effect, places(m.candidate, vehicle))
        for k, i in enumerate(at):
            columns[i] = _column(m.candidate, k, now[k], vehicle)
        if not m.held:
            choices.append(Choice(m.candidate.label, at, price(m.candidate, alike.get(m.candidate.name, 1))))
            variants.append(None)
    for c in found.choices:
        for column, (i, _, _) in zip(c.columns, c.variant.points, strict=True):
            columns[column] = _column(c.candidate, i, c.variant.start[i], vehicle, absent=True)
        choices.append(Choice(c.candidate.label, c.columns, price(c.candidate, alike[c.candidate.name])))
        variants.append(c.variant)
    parts = spectra(observation.samples, observation.transforms, found.joint)
    if like is not None:
        for choice, variant in zip(reused, of_reused, strict=True):
            again_at = tuple(first + old.index(i) for i in choice.columns)
            for i, k in zip(again_at, choice.columns, strict=True):
                columns[i] = like.columns[k]
            choices.append(replace(choice, columns=again_at))
            variants.append(variant)
        kept = [1 + i for i in old]
        parts = [
            replace(s, values=np.concatenate([s.values, b.values[:, kept]], axis=1))
            for s, b in zip(parts, like.found, strict=True)
        ]
    if like is not None and frozen:
        weighed = like.weights
    else:
        weighed = weights(parts, observation.ignored, None if like is None else like.weights)
    sums = gathered(parts, weighed, observation.blocks)
    return Linear(
        observation, tuple(point), tuple(columns), tuple(choices), tuple(variants), tuple(parts), weighed, sums
    )


def _columns_near(like: Linear, m: Member) -> list[int] | None:
    """The columns of a member in an earlier linearisation that was made near its numbers now; None if there is none."""
    before = next((x for x in like.point if x.candidate.label == m.candidate.label), None)
    if before is None:
        return None
    at = places(m.candidate, like.observation.vehicle)
    moved = (read(m.effect, at) - read(before.effect, at)) / [p.scale for p in at]
    own = [i for i, c in enumerate(like.columns) if c.candidate.label == m.candidate.label]
    if np.max(np.abs(moved), initial=0.0) > _NEAR or len(own) != len(at):
        return None
    return sorted(own, key=lambda i: like.columns[i].place)


def _column(candidate: Candidate, place: int, value: float, vehicle, absent: bool = False) -> Column:
    at = places(candidate, vehicle)
    p = at[place]
    x = np.array([q.absent for q in at])
    x[place] += p.scale
    idle = written(candidate, at, np.clip(x, [q.low for q in at], [q.high for q in at])).is_absent(vehicle)
    # A file may declare too long a lag; a lag that is missing is longer.
    least = next(x for x in candidate.cls.parameters if x.name == p.parameter).bounds[0]
    low = max(p.low, least) if least == p.absent else p.low
    low, high = sorted(((low - p.absent) / p.scale, (p.high - p.absent) / p.scale))
    now = 0.0 if absent and not idle else (value - p.absent) / p.scale
    return Column(candidate, place, p.scale, float(now), low, high, idle)
