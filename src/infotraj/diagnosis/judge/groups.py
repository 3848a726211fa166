"""Which effects these flights cannot tell apart: each replaced by every other, and fitted as freely.

An effect belongs to the group of another when, in its place, it leaves the data as probable (odds below twenty to one,
tempered by how much the data scatter beyond the noise model), or when it takes most of the same error off flights that
were not fitted and what it leaves does not matter: beside a file as wrong as this one nobody could tell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj.diagnosis.judge.evidence import overdispersion, rise_beside
from infotraj.diagnosis.select.bounds import beyond_bounds
from infotraj.diagnosis.select.search import Fit, Search

AS_PROBABLE = float(np.log(20.0))
_NEAR = 0.5  # of what an effect gains: a linear rival with as much is fitted before it is compared
_MOSTLY = 0.5  # of the error that an effect takes off: what a rival may leave of it
_MOST = 4  # rivals that are fitted


@dataclass(frozen=True)
class Rival:
    """An effect that explains the flights as well in another's place, and the fit with it."""

    label: str
    fit: Fit


def rivals(search: Search, whole: Fit, label: str, matters: float) -> list[Rival]:
    """The effects that are as good in the place of one member of a fitted set. matters: least rise that counts."""
    linear = whole.linear
    rest = tuple(i for i in whole.chosen if linear.choices[i].label != label)
    mine = [i for i, c in enumerate(linear.columns) if c.candidate.label == label]
    inside = set(whole.labels)
    open_to = [i for i, c in enumerate(linear.choices) if np.isfinite(c.price) and c.label not in inside]
    if not open_to:
        return []
    scores = whole.scorer.scores([rest, *((*rest, i) for i in open_to)])
    least = AS_PROBABLE * overdispersion(whole)[0]
    gain = whole.solution.score - scores[0]
    alone = rise_beside(whole, rest, mine)
    best: dict[str, tuple[float, float]] = {}
    # What is hardly needed is as probable with anything in its place.
    sure = gain > least
    for i, score in zip(open_to, scores[1:], strict=True):
        if not np.isfinite(score):
            continue
        near = sure and (score - scores[0] > _NEAR * gain or whole.solution.score - score < least)
        rise = rise_beside(whole, (*rest, i), mine) if near or score > scores[0] else np.inf
        if near or rise < min(matters, _MOSTLY * alone):
            name = linear.choices[i].label
            best[name] = max(best.get(name, (-np.inf, 0.0)), (float(score), rise))
    found = []
    for name in sorted(best, key=lambda n: -best[n][0])[:_MOST]:
        made = search.fitted([*(linear.choices[i].label for i in rest), name], whole)
        ended = name in beyond_bounds(made.members, linear.observation.vehicle)
        as_good = best[name][1] < min(matters, _MOSTLY * alone)
        if not ended and (as_good or (sure and whole.solution.score - made.solution.score < least)):
            found.append(Rival(name, made))
    return found
