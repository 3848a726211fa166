"""A model made linear around a point: residual, one column a number, and what is known of each number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from infotraj.diagnosis.linear.candidates import Candidate, Variant, firsts, only_more, places, read, written
from infotraj.diagnosis.linear.candidates import variants as own_variants
from infotraj.diagnosis.linear.observation import Member, Observation
from infotraj.diagnosis.linear.sensitivities import sensitivities
from infotraj.diagnosis.linear.sums import Sums, gathered
from infotraj.diagnosis.noise.spectra import Spectrum, Weights, binned, spectra, weights
from infotraj.diagnosis.select.prior import SCALES, SLAB, Scales, is_file_number, price, spikes
from infotraj.diagnosis.select.score import Choice, Scorer
from infotraj.effects.base import Effect
from infotraj.rotations import Array

_STILL = 1e-6  # usual sizes: deviation of a number that stays absent


@dataclass(frozen=True)
class Column:
    """One number: its candidate, place in the form, usual size, value now and bounds, usual sizes from absent (or from
    what is healthy).

    idle: it changes nothing on its own (the length of a cable without a load); slope: by how much the number
    changes with its coordinate, which is what all this is of; lowest: the lower bound where it corrects the file: one
    may declare too long a lag, while a lag that is missing is longer.
    """

    candidate: Candidate
    place: int
    scale: float
    now: float
    low: float
    high: float
    idle: bool = False
    slope: float = 1.0
    lowest: float = -np.inf


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

    def scorer(self, scales: Scales, held: Sequence[Member] | None = None, bounded: bool = True) -> Scorer:
        """What scores sets of effects when the file is off by as much as `scales` says.

        held: the effects that the model has already, with numbers that stay; where not given they are fitted along.
        bounded: numbers stop at their bounds.
        """
        low = np.array([c.lowest if c.candidate.label in scales.corrects else c.low for c in self.columns])
        high = np.array([c.high for c in self.columns])
        idle = np.array([c.idle for c in self.columns])
        now = np.array([c.now for c in self.columns])
        # An idle number is told as a step from where it is.
        low, high = np.where(idle, low - now, low), np.where(idle, high - now, high)
        lowest = np.minimum(low, [c.lowest for c in self.columns])
        if not bounded:
            low, high, lowest = np.full_like(low, -np.inf), np.full_like(high, np.inf), np.full_like(low, -np.inf)
        healthy = self.observation.healthy
        if healthy is not None and scales.common > 0.0:
            # Held against what the healthy flights would have, identified or not: no less is known of a sum than that.
            mean = healthy.mean([(c.candidate.label, c.place) for c in self.columns])
            at_mean = self.absent.shifted(mean)
            prior = self.prior(scales)
            bounds = {"low": low - mean, "high": high - mean, "lowest": lowest - mean}
            return Scorer(at_mean, self.choices, self.kept, prior, **bounds, given=mean, scatter=self.scatter)
        known = {"scatter": self.scatter, "slab": self._slab(scales), "lowest": lowest}
        if held is None:
            return Scorer(self.absent, self.choices, self.kept, self.prior(scales), low, high, **known)
        given = self._numbers(held)
        shifted = self.absent.shifted(given)
        return Scorer(shifted, self.choices, (), self.prior(scales), low, high, given, **known)

    @property
    def scatter(self) -> Array | None:
        """What every number differs by from flight to flight, (p,), where that is known."""
        known = self.observation.scatter
        return np.array([known.get((c.candidate.label, c.place), 0.0) for c in self.columns]) if known else None

    @property
    def scales(self) -> tuple[Scales, ...]:
        """How far the numbers may be off, to choose from: one, where healthy flights have told it."""
        return tuple(map(Scales, SCALES)) if self.observation.healthy is None else (Scales(1.0),)

    def prior(self, scales: Scales) -> Array:
        """Covariance (p, p) of all numbers where none is chosen: of the file, or of what is healthy."""
        healthy = self.observation.healthy
        if healthy is None:
            corrects = [c.candidate.label in scales.corrects for c in self.columns]
            return np.diag(np.where(corrects, 0.0, self.spike(scales)) ** 2)
        owners = [(c.candidate.label, c.place) for c in self.columns]
        alone = len(self.observation.samples) == 1 or not self.observation.scatter
        known = healthy.prior(owners, alone)
        return known if scales.common > 0.0 else np.zeros_like(known)

    def _slab(self, scales: Scales) -> Array:
        """Deviation (p,) of the numbers of what is chosen: what corrects the file is as far off as files are."""
        corrects = np.array([c.candidate.label in scales.corrects for c in self.columns], dtype=bool)
        still = np.array([(c.candidate.label, c.place) in self.observation.still for c in self.columns], dtype=bool)
        slab = np.where(still, _STILL, SLAB)
        if not corrects.any():
            return slab
        of_files = self._of_files(scales)
        return np.where(corrects & (of_files > 0), of_files, slab)

    def _of_files(self, scales: Scales) -> Array:
        """Deviation (p,) of every column's number in files, 0 for what is no number of a file."""
        owners = [(c.candidate, c.scale) for c in self.columns]
        return spikes(owners, scales, self.observation.command_step, self.observation.vehicle)

    def spike(self, scales: Scales) -> Array:
        """Deviation of every column's file number, 0 for what is none; one linearisation of a number counts."""
        out = self._of_files(scales)
        seen: dict[tuple[str, int], int] = {}
        for i, c in enumerate(self.columns):
            number = c.candidate.label, c.place
            if seen.setdefault(number, i) != i or number in self.observation.still:
                out[i] = 0.0
        return out

    def without_axes(self, axes: AbstractSet[str]) -> Linear:
        """The same columns where further axes do not count. The others weigh what they did: around what was found there
        is little left to measure weights by."""
        made = self._weighed(self.weights.without(axes))
        return replace(made, observation=self.observation.without_axes(axes))

    def _weighed(self, weighed: Weights) -> Linear:
        return replace(self, weights=weighed, sums=gathered(self.found, weighed, self.observation.blocks))

    def weighed_beside(self, columns: Sequence[int] | None = None) -> Linear:
        """The same where all that these columns leave is noise: an axis on which a file fails that is taken as it is,
        says little of them. columns: all where not given."""
        parts = self.found
        if columns is not None:
            parts = tuple(replace(s, values=s.values[:, [0, *(1 + c for c in columns)]]) for s in self.found)
        o = self.observation
        return self._weighed(weights(parts, o.ignored, None, o.balance, self.weights.beyond))

    def moved(self, point: Sequence[Member]) -> Linear | None:
        """The same columns around another point, at which the model itself is computed; None where it cannot be.

        What is left changes much sooner than how it changes (simplified Newton; Deuflhard, "Newton methods for
        nonlinear problems", 2004, 2.2): one evaluation in place of one a number.
        """
        o = self.observation
        raw = o.raw(o.model(point))
        if raw is None:
            return None
        inside = {m.candidate.label: m for m in point}
        columns = []
        for c in self.columns:
            m = inside.get(c.candidate.label)
            if m is None:
                columns.append(c if c.idle or c.now == 0.0 else self._renumbered(c, o.base(c.candidate)))
            else:
                columns.append(self._renumbered(c, m.effect))
        first = self.labelled([c.label for c in self.choices])
        kept = [i for i, c in enumerate(self.choices) if c.label not in inside or i in first]
        choices = tuple(self.choices[i] for i in kept)
        variants = tuple(None if self.choices[i].label in inside else self.variants[i] for i in kept)
        parts = []
        for s, new in zip(self.found, spectra(o.samples, o.transforms, binned(o.transforms, raw)), strict=True):
            values = s.values.copy()
            values[:, 0] = new.values[:, 0]
            parts.append(replace(s, values=values))
        same = range(1, 1 + self.sums.width)
        sums = gathered(parts, self.weights, o.blocks, self.sums, same, same)
        return replace(
            self,
            point=tuple(point),
            columns=tuple(columns),
            choices=choices,
            variants=variants,
            found=tuple(parts),
            sums=sums,
        )

    def _renumbered(self, c: Column, effect: Effect) -> Column:
        """A column whose number is now that of an effect."""
        at = places(c.candidate, self.observation.vehicle)
        base, value = (float(read(e, at)[c.place]) for e in (self.observation.base(c.candidate), effect))
        return replace(c, now=(value - base) / c.scale, slope=at[c.place].slope(at[c.place].value(value)))

    def labelled(self, labels: Sequence[str]) -> tuple[int, ...]:
        """The choices with these labels, the first of each."""
        first = firsts(c.label for c in self.choices)
        return tuple(first[label] for label in labels)

    def _numbers(self, members: Sequence[Member]) -> Array:
        """The numbers of these members, usual sizes from absent, (p,); 0 for all others."""
        out = np.zeros(len(self.columns))
        for m in members:
            at = places(m.candidate, self.observation.vehicle)
            values = read(m.effect, at) - read(self.observation.base(m.candidate), at)
            for i, c in enumerate(self.columns):
                if c.candidate.label == m.candidate.label and not c.idle:
                    out[i] = values[c.place] / c.scale
        return out

    def members(self, chosen: Sequence[int], theta: Array, shift: float, straight: bool = False) -> tuple[Member, ...]:
        """Held and chosen effects, and file numbers that shift the residual, with numbers theta (p,).

        shift: weighted squared error above which a file number is taken along.
        """
        vehicle = self.observation.vehicle
        labels = {self.choices[i].label for i in chosen}
        held = {m.candidate.label: m for m in self.point if m.held}
        gram = np.diag(self.sums.total)[1:]
        by_label: dict[str, dict[int, float]] = {}
        variant = {self.choices[i].label: self.variants[i] for i in chosen}
        moved: dict[str, float] = {}
        candidates: dict[str, Candidate] = {}
        chosen_columns = {c for i in chosen for c in self.choices[i].columns}
        for i, c in enumerate(self.columns):
            label = c.candidate.label
            taken = label in held or (label in labels and i in chosen_columns)
            # Of a healthy model every number is known with an error, as those of a file are.
            known = is_file_number(c.candidate) or self.observation.healthy is not None
            loose = label not in labels and label not in held and known and (straight or not c.candidate.cls.linear)
            if not taken and not (loose and theta[i] != 0.0):
                continue
            candidates[label] = c.candidate
            number = theta[i] + (c.now if c.idle else 0.0)
            stays = (label, c.place) in self.observation.still
            by_label.setdefault(label, {})[c.place] = 0.0 if stays else number * c.scale
            moved[label] = moved.get(label, 0.0) + theta[i] ** 2 * gram[i]
        out = []
        for label, numbers in by_label.items():
            if label not in held and label not in labels and moved[label] < shift:
                continue
            candidate = candidates[label]
            at = places(candidate, vehicle)
            start = variant.get(label)
            base = read(self.observation.base(candidate), at)
            x = start.start.copy() if start is not None else read(self._effect_now(candidate), at)
            for place, value in numbers.items():
                p = at[place]
                x[place] = np.clip(base[place] + value, p.low, p.high)
            effect = written(candidate, at, x)
            out.append(Member(candidate, effect, held=label in held))
        if self.observation.healthy is not None:
            moved_labels = {m.candidate.label for m in out}
            own = {m.candidate.label: m for m in self.point}
            base_of = self.observation.healthy.effects
            out += [replace(own[k], effect=e) for k, e in base_of.items() if k not in moved_labels and k in own]
        return tuple(sorted(out, key=lambda m: not m.held))

    def with_numbers(self, members: Sequence[Member], theta: Array) -> tuple[Member, ...]:
        """The members with numbers theta (p,), usual sizes from what is before anything is found."""
        out = []
        for m in members:
            at = places(m.candidate, self.observation.vehicle)
            x, base = read(m.effect, at), read(self.observation.base(m.candidate), at)
            for i, c in enumerate(self.columns):
                if c.candidate.label == m.candidate.label and not c.idle and theta[i] != 0.0:
                    x[c.place] = np.clip(base[c.place] + theta[i] * c.scale, at[c.place].low, at[c.place].high)
            out.append(replace(m, effect=written(m.candidate, at, x)))
        return tuple(out)

    def _effect_now(self, candidate: Candidate) -> Effect:
        for m in self.point:
            if m.candidate.label == candidate.label:
                return m.effect
        return self.observation.base(candidate)


def linearised(
    observation: Observation,
    point: Sequence[Member],
    known: Sequence[Candidate],
    more: Mapping[str, Sequence[Variant]] | None = None,
    like: Linear | None = None,
    frozen: bool = False,
    anew: bool = False,
) -> Linear:
    """The model around `point`, with the columns of all candidates.

    more: further linearisations by label; like: an earlier one, whose columns of absent effects are used again, but for
    those that act only beside others which have changed; frozen: its weights are used again, too; anew: no column is,
    only its linearisations.
    """
    vehicle, more, flights = observation.vehicle, dict(more or {}), len(observation.samples)
    inside, asked = {m.candidate.label for m in point}, {c.label for c in known}
    if like is not None and anew:
        more |= _further(like, known)
    absent = [c for c in known if c.label not in inside]
    old: list[int] = []  # columns of `like` that are used again
    reused: list[Choice] = []
    of_reused: list[Variant | None] = []
    if like is not None:
        names = {m.candidate.name for m in point}
        changed = names ^ {m.candidate.name for m in like.point}
        again = {c.label for c in known if anew or c.label in more or changed & {*c.cls.beside}}
        for choice, variant in zip(like.choices, like.variants, strict=True):
            if variant is not None and choice.label not in inside and choice.label not in again:
                reused.append(choice)
                of_reused.append(variant)
                old += choice.columns
        has = {c.label for c in reused}
        absent = [c for c in absent if c.label not in has]
    found = sensitivities(observation, point, absent, more)
    first = found.joint[0][0].shape[2] - 1
    columns: list[Column] = [None] * (first + len(old))  # type: ignore[list-item]
    alike = {name: sum(c.name == name for c in known) for name in {c.name for c in known}}
    of_change = observation.healthy is not None
    choices: list[Choice] = []
    variants: list[Variant | None] = []
    for m, at in zip(point, found.members, strict=True):
        now = read(m.effect, places(m.candidate, vehicle))
        for k, i in enumerate(at):
            columns[i] = _column(m.candidate, k, now[k], observation)
        if not m.held and m.candidate.label in asked:
            cost = price(m.candidate, alike.get(m.candidate.name, 1), flights, of_change)
            choices.append(Choice(m.candidate.label, at, cost))
            variants.append(None)
    for c in found.choices:
        for column, (i, _, _) in zip(c.columns, c.variant.points, strict=True):
            columns[column] = _column(c.candidate, i, c.variant.start[i], observation, absent=True)
        cost = price(c.candidate, alike[c.candidate.name], flights, of_change)
        choices.append(Choice(c.candidate.label, c.columns, cost))
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
    for s in parts:
        if s.axis in observation.balance:
            balanced(s, [1 + i for i, c in enumerate(columns) if not in_balance(c.candidate)])
    if like is not None and frozen:
        weighed = like.weights
        there = range(1 + first, 1 + len(columns))
        sums = gathered(parts, weighed, observation.blocks, like.sums, there, [1 + i for i in old])
    else:
        weighed = weights(parts, observation.ignored, None if like is None else like.weights, observation.balance)
        sums = gathered(parts, weighed, observation.blocks)
    made = (tuple(point), tuple(columns), tuple(choices), tuple(variants), tuple(parts))
    return Linear(observation, *made, weighed, sums)


def _further(like: Linear, known: Sequence[Candidate]) -> dict[str, list[Variant]]:
    """The linearisations of each candidate that are not its own, by label."""
    found: dict[str, list[Variant]] = {}
    for c in known:
        every = [v for x, v in zip(like.choices, like.variants, strict=True) if x.label == c.label and v is not None]
        found[c.label] = every[len([v for v in own_variants(c, like.observation.vehicle) if v.points]) :]
    return {label: own for label, own in found.items() if own}


def balanced(s: Spectrum, without: Sequence[int]) -> None:
    """Leaves of the columns of an axis what they are in the mean of the flight's slowest band.

    A sum of torques that is zero says as much of rotors without thrust: what varies is not to be explained by them.
    """
    slowest = s.band == 0
    mean = s.values[slowest, 1:].mean(axis=0) if slowest.any() else 0.0
    s.values[:, 1:] = np.where(slowest[:, None], mean, 0.0)
    s.values[:, list(without)] = 0.0


def in_balance(candidate: Candidate) -> bool:
    """Whether an effect changes the balance of torques of a vehicle that stays level: not inertia, nor when it acts."""
    return candidate.cls.place in ("thrust", "wrench") or candidate.cls.balance


def _column(candidate: Candidate, place: int, value: float, observation: Observation, absent: bool = False) -> Column:
    vehicle = observation.vehicle
    at = places(candidate, vehicle)
    p = at[place]
    base = float(read(observation.base(candidate), at)[place])
    x = np.array([q.absent for q in at])
    x[place] += p.scale
    idle = written(candidate, at, np.clip(x, [q.low for q in at], [q.high for q in at])).is_absent(vehicle)
    longer = only_more(candidate, p)
    low, high = sorted((((p.absent if longer else p.low) - base) / p.scale, (p.high - base) / p.scale))
    lowest = (p.low - base) / p.scale if longer else low
    now = 0.0 if absent and not idle else (value - base) / p.scale
    slope = p.slope(p.value(base + now * p.scale))
    return Column(candidate, place, p.scale, float(now), low, high, idle, slope, lowest)
