"""Which effects these flights cannot tell apart: each replaced by every other, fitted, and compared held-out.

An effect belongs to the group of a supported one when, in its place and fitted as freely, its held-out error is within
the noise of the best's (the paired difference over blocks is not significantly above zero) and rises by less than what
matters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj.diagnosis.allowance import TIMING
from infotraj.diagnosis.candidates import Candidate
from infotraj.diagnosis.evidence import resampled
from infotraj.diagnosis.fitting import Fit
from infotraj.diagnosis.observation import Member
from infotraj.diagnosis.search import Search, departure, heldout_error, rises
from infotraj.diagnosis.standins import Screen, alternatives, newcomer
from infotraj.rotations import Array

WITHIN = 0.99  # share of the resamples in which a member of the group may be worse


@dataclass(frozen=True)
class Group:
    """members: what explains the flights equally well, the simplest first; rivals: held-out errors of the others."""

    members: tuple[Member, ...]
    fits: tuple[Fit, ...]
    rivals: tuple[Array, ...]


def group(
    search: Search,
    whole: Fit,
    member: Member,
    rng: np.random.Generator,
    order: list[str],
    chance: float,
    screen: Screen | None = None,
) -> Group:
    """The group of one member of the model `whole`. order: names of the catalogue, which decides among equals.

    chance: held-out gain that the best of all absent effects gets; a third of it is no difference.
    """
    rest = tuple(m for m in whole.members if m.candidate.label != member.candidate.label)
    label = member.candidate.label
    maybe = (screen or Screen(search, whole)).passed({label}, share=0.4)
    lags = frozenset(c.label for c in search.known if _shifts(c)) if _shifts(member.candidate) else frozenset()
    tried = bool(maybe or lags)
    others = alternatives(search, rest, {label}, whole.cost, 0.5, maybe, lags) if tried else []
    fits = [(whole, member), *((f, newcomer(f, rest)) for f in others)]
    errors = [heldout_error(f) for f, _ in fits]
    first = int(np.argmin([e.sum() for e in errors]))
    best, least = fits[first][0], errors[first]
    draws = resampled(whole.sums.flight, rng)
    equal: list[tuple[Member, Fit]] = []
    rivals = []
    for (other, new), error in zip(fits, errors, strict=True):
        worse = np.mean(draws @ (error - least).sum(axis=0) > 0)
        near = worse <= WITHIN or error.sum() - least.sum() < max(1.0, chance / 3)
        at_bound = bool(other.at_bound[departure(other, {new.candidate.label}, search.observation.vehicle)[1]].all())
        # What the fit to all flights preferred stays in, even where held out another does better.
        if other is whole or (near and not at_bound and rises(best, other).max() < search.matters):
            equal.append((new, other))
        else:
            rivals.append(error)
    vehicle = search.observation.vehicle
    equal.sort(key=lambda pair: (pair[0].candidate.count(vehicle), order.index(pair[0].candidate.name)))
    names: set[str] = set()
    unique = [pair for pair in equal if not (pair[0].candidate.name in names or names.add(pair[0].candidate.name))]
    return Group(tuple(m for m, _ in unique), tuple(f for _, f in unique), tuple(rivals))


def _shifts(candidate: Candidate) -> bool:
    """Whether an effect does little but shift things in time: a linearisation cannot say how alike two of them are."""
    return candidate.name in TIMING
