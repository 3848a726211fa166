"""Which effects are missing: select from sums, fit, look at what is left, and again until the set settles.

One linearisation is not enough: a large offset leaves a second-order rest that recruits other effects. So the residual
is always that of the fitted model, and what was taken is questioned again: taken out, replaced, merged.
"""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from itertools import combinations, product

import numpy as np

from infotraj.diagnosis.allowance import ordinary, scale_and_spread, stamp_variance
from infotraj.diagnosis.candidates import Candidate, Variant, places, read
from infotraj.diagnosis.fitting import Fit, beyond_bounds, fit
from infotraj.diagnosis.noise import PRIOR, estimated, started
from infotraj.diagnosis.null import null_gains
from infotraj.diagnosis.observation import Member, Observation
from infotraj.diagnosis.plain import Plain, binned, mean_products, plain
from infotraj.diagnosis.scanning import scanned, shape_of, sharpened
from infotraj.diagnosis.sensitivities import Sensitivities, extended, sensitivities, start_of
from infotraj.diagnosis.silent import silent_axes
from infotraj.diagnosis.subsets import Scored, SubsetSearch
from infotraj.diagnosis.sums import Sums, extended_sums, held_out, products
from infotraj.diagnosis.whitened import Noise, whiten
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

MATTERS = 0.05  # rise of the squared error, in units of the floor, below which an effect does not matter
SIGNIFICANCE = 0.98  # of the largest gain that chance gives to any absent effect
_SHARE = 0.97  # of what the best larger set gains: a smaller set with that much is taken first
_ROUNDS = 8
_AT_ONCE = 3
_MOST = 6  # effects: physics of which six named ones are not enough is not of this catalogue
_ENOUGH = 50  # fits: three named effects among clutter take 10 to 35; after as many nothing more is replaced
_EXACT = 0.03  # times ordinary tolerances: the least that is allowed for
INEXACT = 0.5  # times ordinary tolerances: above it the search is not repeated for small effects
_CLEAR = 4.0  # times what matters: a linear rise above it needs no fit to be believed


@dataclass
class Search:
    """The state of a search.

    tolerance: how large tolerances are, times ordinary ones; trail: what it did, for the verbose output; at_bound:
    labels of what fits drove to a physical bound, and how;
    silent: axes on which these flights say nothing, and why.
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
    silent: dict[str, str] = field(default_factory=dict)
    made: int = 0  # fits, so far
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
        """The fit of a set in which shapes (the length of a swinging load) are the best nearby, not of one valley."""
        made = self.fitted(members)
        for m in () if made is None else made.members:
            better = None if m.held else sharpened(self.observation, made.members, m)
            if better is None:
                continue
            moved = [better if x.candidate.label == m.candidate.label else x for x in made.members]
            again = fit(self.observation, moved)
            made = again if again is not None and again.cost < made.cost else made
        if made is not None:
            self.fits[frozenset(m.candidate.label for m in made.members)] = made
        return made

    def renoised(self, members: Sequence[Member]) -> None:
        """Estimates the noise again around the model with `members`; fits made before no longer count."""
        joint = self.joint(members)[0]
        self.observation = estimated(self.observation, joint, rounds=1)
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
) -> Search:
    """Linearises every candidate around the model and estimates the noise from what their richest fit leaves."""
    base = sensitivities(observation, held, known)
    silent = silent_axes(observation.samples, base.joint)
    observation = started(observation.without_axes(silent.keys()), base.joint)
    before = len(base.choices)
    for candidate in known:
        for _ in range(2 if shape_of(candidate, observation) is not None else 0):
            own = [i for c in base.choices if c.candidate.label == candidate.label for i in c.columns]
            variant = scanned(observation, held, candidate, base.joint, own)
            if variant is None or _tried(variant, base):
                break
            base = extended(base, observation, held, variant)
    if len(base.choices) > before:
        observation = estimated(observation, base.joint, rounds=1)
    return Search(observation, tuple(known), base, rng, matters, silent=silent)


def _tried(variant: Variant, base: Sensitivities) -> bool:
    same = [c.variant.start for c in base.choices if c.candidate.label == variant.candidate.label]
    return any(np.allclose(variant.start, start, rtol=0.01) for start in same)


def run(search: Search, held: Sequence[Member]) -> Fit:
    """The members that are needed, fitted.

    What the search took and had to give back, it does not take again beside the same members. What a fit drives to a
    physical bound leaves the search; it is tried once more when the others are in.
    """
    members = tuple(held)
    seen = {_labels(members)}
    barred: set[str] = set()
    second = False
    for _ in range(_ROUNDS):
        more = _additional(search, members, barred | set(search.at_bound))
        if not more and search.tolerance == 1.0:
            # How exact the vehicle file is shows when nothing else is left: an exact one hides no small effect.
            search.tolerance = max(tolerance_scale(search, search.fitted(members)), _EXACT)
            if search.tolerance < INEXACT:
                search.trail.append(f"tolerances times {search.tolerance:.2g}")
                # What stood for a number within ordinary tolerances may be that number itself.
                members = _moved_to(search, members, _within_bounds(search, _questioned(search, members)))
                seen.add(_labels(members))
                continue
        if not more:
            if second or not search.at_bound:
                break
            second = True
            search.trail.append(f"once more {' '.join(sorted(search.at_bound))}")
            search.at_bound.clear()
            continue
        tried = _taken(search, members, more)
        search.renoised(tried)
        tried = _within_bounds(search, _questioned(search, tried))
        search.trail.append(" ".join(sorted(_labels(tried))) or "nothing")
        if _labels(tried) in seen:
            back = {m.candidate.label for m in more} - _labels(tried)
            if not back - barred - set(search.at_bound) and not search.at_bound:
                members = tried
                break
            barred |= back
        else:
            barred = set()
        members = _moved_to(search, members, tried)
        seen.add(_labels(members))
    return search.fitted(members)


def _moved_to(search: Search, before: Sequence[Member], after: tuple[Member, ...]) -> tuple[Member, ...]:
    """`after`, with all candidates linearised anew around it where what they do has another shape there."""
    if _reshaping(after) != _reshaping(before):
        search.rebased(search.fitted(after).members)
    return after


def tolerance_scale(search: Search, whole: Fit) -> float:
    """How large tolerances are on these flights beside a fitted model, times ordinary ones."""
    return scale_and_spread(*search.linear(whole.members))[0]


def spread(search: Search, made: Fit) -> Array:
    """Variance (p,) that ordinary tolerances and time stamps give to a fit's numbers, in usual sizes."""
    o = search.observation
    by_tolerances = scale_and_spread(*search.linear(made.members))[1]
    return by_tolerances + stamp_variance(made.members, o.vehicle, o.command_step)


def _reshaping(members: Sequence[Member]) -> frozenset[str]:
    """Labels of members that change the shape of what other effects do: lags, delays, limits, shifts of time."""
    return frozenset(m.candidate.label for m in members if m.candidate.cls.place in ("actuators", "measurement"))


def _labels(members: Sequence[Member]) -> frozenset[str]:
    return frozenset(m.candidate.label for m in members)


def _within_bounds(search: Search, members: tuple[Member, ...]) -> tuple[Member, ...]:
    """The members without those whose numbers end at a physical bound, which `search.at_bound` then names."""
    while True:
        whole = search.fitted(members)
        beyond = beyond_bounds(whole, search.observation.vehicle)
        ended = {m.candidate.label: beyond[m.candidate.label] for m in members if m.candidate.label in beyond}
        ended = {label: where for label, where in ended.items() if not _member(members, label).held}
        if not ended:
            return members
        search.at_bound |= ended
        search.trail.append(f"at a bound: {' '.join(sorted(ended))}")
        members = _questioned(search, tuple(m for m in whole.members if m.candidate.label not in ended))


def _member(members: Sequence[Member], label: str) -> Member:
    return next(m for m in members if m.candidate.label == label)


def _additional(search: Search, members: Sequence[Member], barred: AbstractSet[str]) -> list[Member]:
    """Members that the residual asks for, by the smallest set that gains nearly as much as larger ones."""
    at_once = min(_AT_ONCE, _MOST - sum(not m.held for m in members))
    if at_once < 1:
        return []
    sums, found = search.linear(members)
    subsets = SubsetSearch(sums, found, ordinary(sums, found, search.tolerance))
    best = subsets.search(at_once, without=barred)
    singles = [(i,) for i in range(len(found.choices))]
    # What is still to be found is no noise: the surrogates are made of what the richest model leaves.
    gram, right, _ = sums.total()
    left = sums.shifted(np.linalg.solve(gram.sum(axis=0) + np.eye(gram.shape[-1]) / PRIOR**2, right.sum(axis=0)))
    threshold = float(np.quantile(null_gains(left, found, singles, search.rng), SIGNIFICANCE))
    top = best[-1].gain
    base = best[0].gain
    for scored in best:
        if scored.gain - base >= _SHARE * (top - base) or top - scored.gain < threshold:
            break
    if scored.gain - base < threshold:
        return []
    before, after = best[0].held_out(sums), scored.held_out(sums)
    white = (before - after).sum(axis=1) / np.maximum(sums.windows.sum(axis=1), 1)
    rise = float(np.maximum(white, plain_rise(sums.plain, best[0], scored, best[-1])).max())
    if rise < search.matters:
        return []
    new, place = [], len(found.of_members)
    for i in scored.chosen:
        choice = found.choices[i]
        theta = scored.theta[place : place + len(choice.columns)]
        place += len(choice.columns)
        at = places(choice.candidate, search.observation.vehicle)
        new.append(Member(choice.candidate, start_of(choice, at, theta)))
    search.trail.append(
        f"add {' '.join(m.candidate.label for m in new)}: gain {scored.gain - base:.0f} of {top - base:.0f}, "
        f"chance {threshold:.1f}, rise {rise:.2f}"
    )
    return new


def _taken(search: Search, members: Sequence[Member], more: Sequence[Member]) -> tuple[Member, ...]:
    found = search.sharp((*members, *more))
    return tuple(members) if found is None else found.members


def _questioned(search: Search, members: Sequence[Member]) -> tuple[Member, ...]:
    """Takes out what does not matter, replaces what another explains better, merges two that one explains."""
    members = tuple(members)
    for _ in range(2 * len(members) + 2):
        smaller = _without_idle(search, members)
        other = _replaced(search, smaller)
        if {m.candidate.label for m in other} == {m.candidate.label for m in members}:
            return other
        members = other
    return members


def _without_idle(search: Search, members: tuple[Member, ...]) -> tuple[Member, ...]:
    while True:
        whole = search.fitted(members)
        free = [m for m in members if not m.held]
        doubtful = sorted((linear_rise(search, whole, m), m.candidate.label) for m in free)
        for rough, label in doubtful:
            if rough > _CLEAR * search.matters:
                return whole.members
            rise = rise_without(search, whole, _member(members, label))
            if rise < search.matters:
                search.trail.append(f"drop {label}: rise {rise:.3f}")
                members = tuple(x for x in whole.members if x.candidate.label != label)
                break
        else:
            return whole.members


def rise_without(search: Search, whole: Fit, member: Member) -> float:
    """Rise of the held-out squared error per 50 ms, on the most affected axis, when `member` is taken out."""
    rest = [x for x in whole.members if x.candidate.label != member.candidate.label]
    out = search.fitted(rest)
    return float(rises(whole, out).max())


def linear_rise(search: Search, whole: Fit, member: Member) -> float:
    """The same from the fit's own linearisation, without another fit."""
    theta, mine = departure(whole, {member.candidate.label}, search.observation.vehicle)
    free = [c for c in np.flatnonzero(~whole.at_bound) if c not in mine]
    lost = held_out(whole.sums.shifted(theta), free)[0] - heldout_error(whole)
    return float((lost.sum(axis=1) / np.maximum(whole.sums.windows.sum(axis=1), 1)).max())


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


def _replaced(search: Search, members: tuple[Member, ...]) -> tuple[Member, ...]:
    """Replaces one member, or two, by one that is absent and explains the flights better or as well."""
    free = [m for m in members if not m.held]
    whole = search.fitted(members)
    if search.made > _ENOUGH:
        search.trail.append("nothing more is replaced")
        return members
    screen = Screen(search, whole)
    for size in (2, 1):
        for out in combinations(free, size):
            labels = {m.candidate.label for m in out}
            maybe = screen.passed(labels, share=0.5)
            if not maybe:
                continue
            rest = tuple(m for m in members if m.candidate.label not in labels)
            for other in alternatives(search, rest, labels, whole.cost, 0.8, maybe):
                better = whole.cost - other.cost
                count = sum(m.candidate.count(search.observation.vehicle) for m in out)
                new = newcomer(other, rest)
                simpler = count - new.candidate.count(search.observation.vehicle) + 4 * (size - 1)
                if better > -2.0 * max(simpler, 0) and (better > 2.0 or simpler > 0):
                    search.trail.append(f"replace {' '.join(sorted(labels))} by {new.candidate.label}: {better:.0f}")
                    return other.members
    return members


def newcomer(made: Fit, rest: Sequence[Member]) -> Member:
    """The member of a fit that is not in `rest`: a fit that was made before may have its members in another order."""
    known = {m.candidate.label for m in rest}
    return next(m for m in made.members if m.candidate.label not in known)


class Screen:
    """Which absent effects may stand in for members of a fitted model, by the linearisation around that model.

    It asks more leniently than `alternatives`, which fits, and spares most of its fits.
    """

    def __init__(self, search: Search, whole: Fit) -> None:
        self._whole, self._vehicle = whole, search.observation.vehicle
        sums, self._found = search.linear(whole.members)
        self._subsets = SubsetSearch(sums, self._found, ordinary(sums, self._found, search.tolerance))
        self._open = [i for i, c in enumerate(self._found.choices) if c.candidate.label not in search.at_bound]

    def passed(self, labels: AbstractSet[str], share: float) -> frozenset[str]:
        """Labels of absent effects that regain `share` of what the members with these labels explain.

        Both explain it beside ordinary tolerances: an effect that takes up the clutter instead is no alternative.
        """
        theta, mine = departure(self._whole, labels, self._vehicle)
        moved = self._subsets.moved(np.concatenate([theta, np.zeros(self._subsets.width - len(theta))]))
        rest = [c for c in self._found.of_members if c not in mine]
        every = list(self._found.of_members)
        base, own = moved.score([()], rest)[0].gain, moved.score([()], every)[0].gain
        singles = moved.score([(i,) for i in self._open], rest)
        good = [s.chosen[0] for s in singles if s.gain - base > share * (own - base)]
        return frozenset(self._found.choices[i].candidate.label for i in good)


def alternatives(
    search: Search,
    rest: tuple[Member, ...],
    labels: set[str],
    cost: float,
    share: float,
    maybe: AbstractSet[str],
    always: AbstractSet[str] = frozenset(),
) -> list[Fit]:
    """Fits of `rest` with one absent effect, for those whose linear gain comes near what was there, best first.

    labels: what was taken out; cost: the squared error of the model that had it; maybe: labels of what to try;
    always: labels that are fitted whatever the linear gain says, from their usual size.
    """
    without = search.fitted(rest)
    if without is None:
        return []
    sums, found = search.linear(rest)
    subsets = SubsetSearch(sums, found)
    left = labels | set(search.at_bound)
    mine = [i for i, c in enumerate(found.choices) if c.candidate.label in maybe and c.candidate.label not in left]
    base = subsets.score([()])[0].gain
    own = [[i for i, c in enumerate(found.choices) if c.candidate.label == label] for label in sorted(labels)]
    linear = max((s.gain - base for s in subsets.score(list(product(*own)))), default=np.inf)
    # Both sides are judged by the same linearisation, which may gain much less than a fit.
    lost = min(without.cost - cost, linear)
    scored = [s for s in subsets.score([(i,) for i in mine]) if s.gain - base > share * lost]
    scored.sort(key=lambda s: -s.gain)
    fits, done = [], set()
    for s in scored[:8]:
        choice = found.choices[s.chosen[0]]
        if choice.candidate.label in done:
            continue
        done.add(choice.candidate.label)
        theta = s.theta[len(found.of_members) :]
        start = start_of(choice, places(choice.candidate, search.observation.vehicle), theta)
        made = search.fitted((*rest, Member(choice.candidate, start)))
        if made is not None:
            fits.append(made)
    vehicle = search.observation.vehicle
    for c in search.known:
        if c.label in always and c.label not in done | left:
            made = search.fitted((*rest, Member(c, c.at(c.cls.starts(vehicle, c.form)[0]))))
            fits += [] if made is None else [made]
    return sorted(fits, key=lambda f: f.cost)
