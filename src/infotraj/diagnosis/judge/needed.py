"""Which effects of the set that the search took are needed to predict flights that were not fitted.

The most probable set holds too much where noise is not what it is taken for: on real flights numbers that make up for
one another. What predicts least beside the others goes, the rest is fitted anew, until each that stays predicts
(backward elimination; its measure is prediction, as Geisser and Eddy 1979 have it).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from infotraj.diagnosis.judge.evidence import Evidence, evidence, evidence_of_absent, shared
from infotraj.diagnosis.judge.numbers import fitted_numbers
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.predicting import TELLS
from infotraj.diagnosis.select.search import Search
from infotraj.progress import reached

SURE = 0.95  # probability that an effect is needed, and share of resamples that must need it


@dataclass(frozen=True)
class Judged:
    """One effect of a set: with its numbers, their standard errors, and the evidence for it beside the others."""

    member: Member
    errors: dict[str, Any]
    evidence: Evidence

    @property
    def needed(self) -> bool:
        """Whether it predicts enough to stay."""
        return self.evidence.gain >= TELLS


def needed(search: Search, whole: Fit, rng: np.random.Generator) -> tuple[Fit, list[Judged], list[Judged]]:
    """The set without what does not predict, fitted; its effects, and what went as it was judged then.

    What has gone may have stood for an effect outside the set, which is then taken in.
    """
    gone: list[Judged] = []
    count, changed = len(whole.labels) + 1, False
    while True:
        reached("weighing", len(gone), count)
        judged, least, rest = _weakest(search, whole, rng)
        if least is not None:
            gone.append(least)
            label = least.member.candidate.label
            left = [x for x in whole.labels if x != label]
            whole, changed = search.fitted(left, whole) if rest is None else rest, True
            continue
        if changed:
            whole, changed = search.afresh(whole), False
            continue
        further = _further(search, whole, {j.member.candidate.label for j in gone}, rng) if gone else None
        if further is None:
            return whole, judged, gone
        whole = search.fitted([*whole.labels, further], whole, go_on=True)


def _weakest(search: Search, whole: Fit, rng: np.random.Generator) -> tuple[list[Judged], Judged | None, Fit | None]:
    """The effects of a set as they are judged, the one that goes, and the set without it where that was fitted.

    None goes where each predicts. An effect that is not linear in its numbers is held against a fit without it, what a
    derivative calls weakest first: what it says of the others need not be exact for as long as one goes.
    """
    numbers = dict(zip((m.candidate.label for m in whole.members), fitted_numbers(whole), strict=True))
    own = {m.candidate.label: m for m in whole.members if not m.held}
    found = {label: evidence(whole, label, rng) for label in own}
    rests: dict[str, Fit] = {}
    while True:
        of_set = shared(whole, found)
        judged = [Judged(m, numbers[label], of_set[label]) for label, m in own.items()]
        open_to = [j for j in judged if not (j.member.candidate.cls.linear or j.member.candidate.label in rests)]
        weak = [j for j in judged if not j.needed]
        least = min(weak or open_to, key=lambda j: j.evidence.gain, default=None)
        if least is None or not any(j is least for j in open_to):
            return judged, least, None if least is None else rests.get(least.member.candidate.label)
        label = least.member.candidate.label
        rests[label] = search.fitted([x for x in whole.labels if x != label], whole)
        found[label] = evidence(whole, label, rng, rests[label])


def _further(search: Search, whole: Fit, gone: set[str], rng: np.random.Generator) -> str | None:
    """The label of the effect outside the set that is sure and predicts most, if one does; none that has gone."""
    inside = {*whole.labels, *gone, *search.barred}
    choices = whole.linear.choices
    open_to = [i for i, c in enumerate(choices) if c.label not in inside and np.isfinite(c.price)]
    scores = whole.scorer.scores([(*whole.chosen, i) for i in open_to]) if open_to else np.zeros(0)
    found: dict[str, float] = {}
    for i, score in zip(open_to, scores, strict=True):
        if score <= whole.solution.score:
            continue
        e = evidence_of_absent(whole, i, rng)
        if e.probability >= SURE and e.selected >= SURE and e.gain >= TELLS:
            found[choices[i].label] = max(e.gain, found.get(choices[i].label, 0.0))
    return max(found, key=lambda x: found[x]) if found else None
