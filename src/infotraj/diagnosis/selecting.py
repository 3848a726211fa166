"""Which effects are missing: select from sums, fit, look at what is left, and again until the set settles.

One linearisation is not enough: a large offset leaves a second-order rest that recruits other effects. So the residual
is always that of the fitted model, and what was taken is questioned again: taken out, replaced, merged.
"""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from itertools import combinations

import numpy as np

from infotraj.diagnosis.allowance import ordinary
from infotraj.diagnosis.candidates import places
from infotraj.diagnosis.driving_noise import swings, weighted
from infotraj.diagnosis.fitting import Fit, beyond_bounds
from infotraj.diagnosis.noise import PRIOR
from infotraj.diagnosis.null import null_gains
from infotraj.diagnosis.observation import Member
from infotraj.diagnosis.search import (
    INEXACT,
    SIGNIFICANCE,
    Search,
    departure,
    heldout_error,
    plain_rise,
    rises,
    tolerance_scale,
)
from infotraj.diagnosis.sensitivities import start_of
from infotraj.diagnosis.standins import Screen, alternatives, newcomer
from infotraj.diagnosis.subsets import SubsetSearch
from infotraj.diagnosis.sums import held_out

_SHARE = 0.97  # of what the best larger set gains: a smaller set with that much is taken first
_ROUNDS = 8
_AT_ONCE = 3
_MOST = 6  # effects: physics of which six named ones are not enough is not of this catalogue
_ENOUGH = 50  # fits: three named effects among clutter take 10 to 35; after as many nothing more is replaced
_EXACT = 0.03  # times ordinary tolerances: the least that is allowed for
_CLEAR = 4.0  # times what matters: a linear rise above it needs no fit to be believed


def run(search: Search, held: Sequence[Member]) -> Fit:
    """The members that are needed, fitted.

    What the search took and had to give back, it does not take again beside the same members. What a fit drives to a
    physical bound leaves the search; it is tried once more when the others are in.
    """
    members = tuple(held)
    seen = {_labels(members)}
    barred: set[str] = set()
    second = False
    if swings(search.observation, members):
        search.renoised(members)
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
        if swings(search.observation, more):
            tried = _taken(search, tried, ())
        tried = _within_bounds(search, _questioned(search, tried))
        if weighted(search.observation) != swings(search.observation, tried):
            search.renoised(tried)
            tried = _taken(search, tried, ())
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
    reshaping = {name for c in search.known for name in c.cls.beside}
    if _reshaping(after, reshaping) != _reshaping(before, reshaping):
        search.rebased(search.fitted(after).members)
    return after


def _reshaping(members: Sequence[Member], others: AbstractSet[str]) -> frozenset[str]:
    """Labels of members that change the shape of what other effects do: lags, delays, limits, shifts of time.

    others: names of what must be there for another effect to do anything, drag for the wind.
    """
    places = ("actuators", "measurement")
    found = [m.candidate for m in members if m.candidate.cls.place in places or m.candidate.name in others]
    return frozenset(c.label for c in found)


def _labels(members: Sequence[Member]) -> frozenset[str]:
    return frozenset(m.candidate.label for m in members)


def _within_bounds(search: Search, members: tuple[Member, ...]) -> tuple[Member, ...]:
    """The members without those whose numbers end at a physical bound, which `search.at_bound` then names."""
    while True:
        whole = search.fitted(members)
        beyond = beyond_bounds(whole.members, search.observation.vehicle)
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
