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

    What has gone may have stood for an effect outside the set, which is then taken in. So may it for one
    that had gone before it, which comes back once.
    """
    gone: list[Judged] = []
    back: set[str] = set()  # what has come back, which happens once
    whole, judged = _predicting(search, whole, rng, gone)
    while gone:
        further = _further(search, whole, {_label(gone[-1]), *({_label(j) for j in gone} & back)}, rng)
        if further is None:
            break
        back.add(further)
        gone = [j for j in gone if _label(j) != further]
        wider = search.fitted([*whole.labels, further], whole, go_on=True)
        as_before = {_label(j): j.evidence for j in judged if _bends(j)}
        _, least, _ = _weakest(search, wider, rng, as_before, each=True)
        if least is not None and _label(least) == further:
            gone.append(least)
        else:
            whole, judged = _predicting(search, wider, rng, gone)
    return whole, judged, gone


def _predicting(search: Search, whole: Fit, rng: np.random.Generator, gone: list[Judged]) -> tuple[Fit, list[Judged]]:
    """The set, fitted, of what stays where what predicts least goes, one after the other into `gone`; as judged."""
    count, changed = len(whole.labels) + 1, False
    sure: dict[str, Evidence] = {}
    while True:
        reached("weighing", len(gone), count)
        judged, least, rest = _weakest(search, whole, rng, sure, each=not changed)
        if least is not None:
            gone.append(least)
            left = [x for x in whole.labels if x != _label(least)]
            whole, changed = search.fitted(left, whole) if rest is None else rest, True
        elif changed:
            whole, changed, sure = search.afresh(whole), False, {}
        else:
            return whole, judged


def _weakest(
    search: Search, whole: Fit, rng: np.random.Generator, sure: dict[str, Evidence], each: bool
) -> tuple[list[Judged], Judged | None, Fit | None]:
    """The effects of a set as they are judged, the one that goes, and the set without it where that was fitted.

    None goes where each predicts. An effect that is not linear in its numbers is held against a fit without it, what a
    derivative calls weakest first: what it says of the others need not be exact for as long as one goes. each: those
    are, too, that a derivative does not call weak. sure: what such fits beside more effects have said, which holds for
    what predicts; added to.
    """
    numbers = dict(zip((m.candidate.label for m in whole.members), fitted_numbers(whole), strict=True))
    own = {m.candidate.label: m for m in whole.members if not m.held}
    found = {label: sure.get(label) or evidence(whole, label, rng) for label in own}
    rests: dict[str, Fit] = {}
    while True:
        of_set = shared(whole, found)
        judged = [Judged(m, numbers[label], of_set[label]) for label, m in own.items()]
        weak = [j for j in judged if not j.needed]
        asked = rests.keys() | sure.keys()
        unasked = [j for j in judged if each and _bends(j) and _label(j) not in asked]
        least = min(weak or unasked, key=_gain, default=None)
        if least is None or not _bends(least) or _label(least) in rests:
            sure.update({x: found[x] for x in rests if least is None or x != _label(least)})
            return judged, least, None if least is None else rests.get(_label(least))
        label = _label(least)
        rests[label] = search.fitted([x for x in whole.labels if x != label], whole)
        found[label] = evidence(whole, label, rng, rests[label])


def _label(j: Judged) -> str:
    return j.member.candidate.label


def _gain(j: Judged) -> float:
    return j.evidence.gain


def _bends(j: Judged) -> bool:
    """Whether an effect is not linear in its numbers."""
    return not j.member.candidate.cls.linear


def _further(search: Search, whole: Fit, gone: set[str], rng: np.random.Generator) -> str | None:
    """The label of the effect outside the set that is sure and predicts most, if one does; none of `gone`."""
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
