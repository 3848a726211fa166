"""The state of a search for missing effects: flights, candidates, their columns, and the fits made so far."""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace

import numpy as np

from infotraj.diagnosis.allowance import scale_and_spread, stamp_variance
from infotraj.diagnosis.candidates import Candidate, read
from infotraj.diagnosis.doubt import Doubt
from infotraj.diagnosis.driving_noise import driving_variance, weighed
from infotraj.diagnosis.fitting import Fit, fit
from infotraj.diagnosis.noise import estimated, started
from infotraj.diagnosis.observation import Member, Observation
from infotraj.diagnosis.plain import Plain, binned, mean_products, plain
from infotraj.diagnosis.scanning import scanned, shape_of
from infotraj.diagnosis.sensitivities import Sensitivities, extended, sensitivities
from infotraj.diagnosis.sharpening import sharp_fit
from infotraj.diagnosis.silent import silent_axes
from infotraj.diagnosis.subsets import Scored
from infotraj.diagnosis.sums import Sums, extended_sums, held_out, products
from infotraj.diagnosis.whitened import Noise, whiten
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

MATTERS = 0.05  # rise of the squared error, in units of the floor, below which an effect does not matter
SIGNIFICANCE = 0.98  # of the largest gain that chance gives to any absent effect
INEXACT = 0.5  # times ordinary tolerances: above it the search is not repeated for small effects


@dataclass
class Search:
    """The state of a search.

    tolerance: how large tolerances are, times ordinary ones; trail: what it did, for the verbose output; at_bound:
    labels of what fits drove to a physical bound, and how;
    silent: doubts about axes on which these flights say nothing.
    """

    observation: Observation
    known: tuple[Candidate, ...]
    base: Sensitivities
    rng: np.random.Generator
    matters: float = MATTERS
    tolerance: float = 1.0
    fits: dict[frozenset[str], Fit | None] = field(default_factory=dict)
    trail: list[str] = field(default_factory=list)
    at_bound: dict[str, str] = field(default_factory=dict)
    silent: tuple[Doubt, ...] = ()
    made: int = 0  # fits, so far
    spreads: dict[int, tuple[Fit, Array]] = field(default_factory=dict)  # by the fit's identity
    _white: tuple[Noise, list[list[Array]], Array] | None = None
    _binned: tuple[list[list[Array]], Array] | None = None

    def fitted(self, members: Sequence[Member]) -> Fit | None:
        """The fit of a set of members, made once."""
        key = frozenset(m.candidate.label for m in members)
        if key not in self.fits:
            self.made += 1
            self.fits[key] = fit(self.observation, members)
        return self.fits[key]

    def sharp(self, members: Sequence[Member]) -> Fit | None:
        """The fit of a set in which shapes (the length of a swinging load) are the best there are."""
        made = self.fitted(members)
        if made is not None:
            made = sharp_fit(self.observation, made)
            self.fits[frozenset(m.candidate.label for m in made.members)] = made
        return made

    def renoised(self, members: Sequence[Member]) -> None:
        """Weighs the samples and estimates the noise again around the model with `members`.

        Fits made before no longer count.
        """
        joint = self.joint(members)[0]
        self.observation = estimated(weighed(self.observation, members), joint, rounds=1)
        self.fits = {}

    def rebased(self, members: Sequence[Member]) -> None:
        """Linearises the candidates anew around the model with `members`.

        What the members themselves would be beside themselves, and what was scanned for, keeps its columns.
        """
        o, old = self.observation, self.base
        taken = {m.candidate.label for m in members}
        absent = [c for c in self.known if c.label not in taken and shape_of(c, o) is None]
        fresh = sensitivities(o, members, absent)
        labels = {c.candidate.label for c in fresh.choices}
        kept = [c for c in old.choices if c.candidate.label not in labels]
        columns = [i for c in kept for i in c.columns]
        joint = [
            [np.concatenate([a, b[:, :, [1 + i for i in columns]]], axis=2) for a, b in zip(new, before, strict=True)]
            for new, before in zip(fresh.joint, old.joint, strict=True)
        ]
        first = fresh.joint[0][0].shape[2] - 1
        moved = [replace(c, columns=tuple(first + columns.index(i) for i in c.columns)) for c in kept]
        self.base = replace(fresh, choices=(*fresh.choices, *moved), joint=joint)
        self._white = self._binned = None

    def joint(self, members: Sequence[Member]) -> tuple[list[list[Array]], Sensitivities]:
        """Residual of the model with `members`, their columns, and the candidates' of the base model."""
        own, found = self._own(members)
        old = 1 + len(self.base.of_members)
        joint = [
            [np.concatenate([a, b[:, :, old:]], axis=2) for a, b in zip(new, before, strict=True)]
            for new, before in zip(own.joint, self.base.joint, strict=True)
        ]
        return joint, found

    def _own(self, members: Sequence[Member]) -> tuple[Sensitivities, Sensitivities]:
        """The members' own columns, and what all columns are when the candidates' follow them."""
        own = sensitivities(self.observation, members, [])
        shift = own.joint[0][0].shape[2] - 1
        taken = {m.candidate.label for m in members}
        old = len(self.base.of_members)
        choices = [
            replace(c, columns=tuple(i - old + shift for i in c.columns))
            for c in self.base.choices
            if c.candidate.label not in taken
        ]
        return own, replace(own, choices=tuple(choices), joint=[])

    def linear(self, members: Sequence[Member]) -> tuple[Sums, Sensitivities]:
        """Sums of the whitened residual of the model with `members` and of all columns, and what these are."""
        o = self.observation
        own, found = self._own(members)
        if self._white is None or self._white[0] is not o.noise:
            old = 1 + len(self.base.of_members)
            candidate = [[b[:, :, old:] for b in flight] for flight in self.base.joint]
            white = [whiten(s, o.noise, f) for s, f in zip(o.samples, candidate, strict=True)]
            self._white = o.noise, white, products(o.samples, o.blocks, white)
        new = [whiten(s, o.noise, x) for s, x in zip(o.samples, own.joint, strict=True)]
        sums = extended_sums(o.samples, o.noise, o.blocks, new, *self._white[1:])
        return replace(sums, plain=self._plain(sums.axes, own.joint)), found

    def _plain(self, axes: tuple[str, ...], own: list[list[Array]]) -> Plain:
        o = self.observation
        if self._binned is None:
            old = 1 + len(self.base.of_members)
            others = binned(o.samples, [[b[:, :, old:] for b in flight] for flight in self.base.joint])
            self._binned = others, mean_products(o.samples, axes, others, others, o.ignored)
        return plain(o.samples, axes, binned(o.samples, own), *self._binned, o.ignored)


def start_search(
    observation: Observation,
    held: Sequence[Member],
    known: Sequence[Candidate],
    rng: np.random.Generator,
    matters: float = MATTERS,
    trusted: AbstractSet[str] = frozenset(),
) -> Search:
    """Linearises every candidate around the model and estimates the noise from what their richest fit leaves.

    trusted: axes that are used even where these flights say nothing of them.
    """
    base = sensitivities(observation, held, known)
    silent = [
        Doubt("axis_unexplained", a, (a,), why) for a, why in silent_axes(observation.samples, base.joint).items()
    ]
    silent = [d for d in silent if d.about not in observation.ignored]
    observation = observation.without_axes({d.about for d in silent} - trusted)
    observation = started(observation, base.joint)
    before = len(base.choices)
    for candidate in known:
        own = [i for c in base.choices if c.candidate.label == candidate.label for i in c.columns]
        variant = scanned(observation, held, candidate, base.joint, own)
        if variant is not None:
            base = extended(base, observation, held, variant)
    if len(base.choices) > before:
        observation = estimated(observation, base.joint, rounds=1)
    return Search(observation, tuple(known), base, rng, matters, silent=tuple(silent))


def tolerance_scale(search: Search, whole: Fit) -> float:
    """How large tolerances are on these flights beside a fitted model, times ordinary ones."""
    return scale_and_spread(*search.linear(whole.members))[0]


def spread(search: Search, made: Fit) -> Array:
    """Variance (p,) that tolerances, time stamps and noise of the motion give to a fit's numbers, in usual sizes."""
    o = search.observation
    if id(made) not in search.spreads:
        by_tolerances = scale_and_spread(*search.linear(made.members))[1]
        by_stamps = stamp_variance(made.members, o.vehicle, o.command_step)
        search.spreads[id(made)] = made, by_tolerances + by_stamps + driving_variance(o, made)
    return search.spreads[id(made)][1]


def departure(whole: Fit, labels: AbstractSet[str], vehicle: Vehicle) -> tuple[Array, list[int]]:
    """The step (p,) in usual sizes that makes these members absent, and their columns."""
    theta, mine, place = np.zeros(len(whole.at_bound)), [], 0
    for m in whole.members:
        at = m.places(vehicle)
        if m.candidate.label in labels:
            columns = range(place, place + len(at))
            theta[columns] = (np.array([p.absent for p in at]) - read(m.effect, at)) / [p.scale for p in at]
            mine += columns
        place += len(at)
    return theta, mine


def rises(whole: Fit, out: Fit) -> Array:
    """Rise of the squared error per 50 ms from one fit to another, axis by axis, in units of the floor.

    The larger of two: that of the whitened held-out error, and that of the error as it is (see `plain`).
    """
    windows = np.maximum(whole.sums.windows.sum(axis=1), 1)
    white = (heldout_error(out) - heldout_error(whole)).sum(axis=1) / windows
    return np.maximum(white, (out.plain - whole.plain) / np.maximum(whole.plain, 1e-300))


def plain_rise(sums: Plain, without: Scored, with_it: Scored, floor: Scored) -> Array:
    """Rise of the plain error (axes,) from one scored set to another, in units of what a third one leaves."""
    return (without.plain(sums) - with_it.plain(sums)) / np.maximum(floor.plain(sums), 1e-300)


def heldout_error(found: Fit) -> Array:
    """Held-out squared error of a fit by axis and block: its numbers fitted again on the other folds, linearised.

    Numbers at a bound stay there.
    """
    return held_out(found.sums, np.flatnonzero(~found.at_bound))[0]
