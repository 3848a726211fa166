"""Which absent effects may stand in for members of a fitted model: screened linearly, then fitted."""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from itertools import product

import numpy as np

from infotraj.diagnosis.allowance import ordinary
from infotraj.diagnosis.candidates import places
from infotraj.diagnosis.fitting import Fit
from infotraj.diagnosis.observation import Member
from infotraj.diagnosis.search import Search, departure
from infotraj.diagnosis.sensitivities import start_of
from infotraj.diagnosis.subsets import SubsetSearch


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
    fits, done = [], {m.candidate.label for m in rest}
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
