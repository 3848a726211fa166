"""Which effects these flights cannot tell apart: each replaced by every other, and fitted as freely.

An effect belongs to the group of another when, in its place, it takes most of the same error off flights that were not
fitted, axis by axis, and leaves the data as probable (odds below twenty to one, tempered by how much the data scatter
beyond the noise model) or, beside the file as it is and beside one as wrong as this, nothing that matters. What it
explains elsewhere makes it no rival, however probable that is; what it explains beside the other as well, and predicts,
is none of the other's: only what the other adds to it tells them apart.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from infotraj.diagnosis.judge.anchor import anchored, off_by
from infotraj.diagnosis.judge.evidence import (
    acts,
    gain_beside,
    left_beside,
    left_by_set,
    overdispersion,
    rise_beside,
    translated,
)
from infotraj.diagnosis.judge.numbers import OF_THRUST_OVER_MASS, thrust_over_mass
from infotraj.diagnosis.select.around import linearised
from infotraj.diagnosis.select.bounds import beyond_bounds
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.predicting import TELLS
from infotraj.diagnosis.select.search import Search
from infotraj.rotations import Array

AS_PROBABLE = float(np.log(20.0))
_NEAR = 0.5  # of what an effect gains: a linear rival with as much is fitted before it is compared
_MOSTLY = 0.5  # of the error that an effect takes off: what a rival takes at least, and may leave
_ALONE = 10.0  # times the nats that tell two apart: a number that explains so much less could not stand there
_MOST = 4  # rivals that are fitted
_MASS = "mass_offset"
_MOMENTS = 0.02  # of moments of inertia, in a file that is right to 1 %
_TIMED = ("actuators", "measurement")  # places of effects that shift in time


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
    together = np.maximum(whole.scorer.scores([(*whole.chosen, i) for i in open_to]), whole.solution.score)
    for k in np.flatnonzero(together > whole.solution.score):
        if gain_beside(whole, open_to[k]) < TELLS:
            together[k] = whole.solution.score
    least = AS_PROBABLE * overdispersion(whole)[0]
    gain = whole.solution.score - scores[0]
    now = left_by_set(whole)
    alone = rise_beside(whole, rest, mine)
    best: dict[str, _Near] = {}
    # What is hardly needed is as probable with anything in its place.
    sure = gain > least
    for i, score, ceiling in zip(open_to, scores[1:], together, strict=True):
        if not np.isfinite(score):
            continue
        adds = ceiling - score
        beside = whole.scorer.solution((*whole.chosen, i)).each if ceiling > whole.solution.score else None
        near = sure and adds < max(_NEAR * gain, least)
        rise = rise_beside(whole, (*rest, i), mine, beside) if near or score > scores[0] else np.inf
        if near or rise < min(matters, _MOSTLY * alone):
            name = linear.choices[i].label
            found_now = _Near(adds, rise, ceiling)
            best[name] = min(best.get(name, found_now), found_now, key=lambda x: x.adds)
    own = acts(linear.absent, mine, whole.solution.theta, linear.absent.believed_error(whole.solution.each))
    as_it_is, without = (
        left_by_set(whole, rest),
        left_beside(whole, whole.scorer.beside(rest, whole.solution.each, mine), own),
    )
    left = left_beside(whole, whole.solution.each, own)
    takes, found = np.maximum(without - left, 0.0), []
    start, late = _in_time(search, whole, label) if sure else (whole, {})
    # Flights tell thrust over mass. Which of the two is off moments of inertia tell, as exactly as the file has them.
    of_ratio = label.split()[0] in OF_THRUST_OVER_MASS and linear.observation.healthy is None
    off = off_by(whole) if of_ratio else 0.0
    load = max(off, _as_a_load(whole)) if of_ratio else 0.0
    begun = {name: [whole] for name in best}
    for name, adds in late.items():
        i = next(i for i in open_to if linear.choices[i].label == name)
        if adds < max(_NEAR * gain, least):
            best.setdefault(name, _Near(adds, np.inf, float(together[open_to.index(i)])))
            begun.setdefault(name, []).append(start)
    for name in sorted(best, key=lambda n: best[n].adds)[:_MOST]:
        labels = [*(linear.choices[i].label for i in rest), name]
        made = max((search.fitted(labels, x) for x in begun[name]), key=lambda f: f.worth)
        if name in beyond_bounds(made.members, linear.observation.vehicle):
            continue
        both = best[name].both
        if of_ratio and name.split()[0] in OF_THRUST_OVER_MASS:
            far = load if name == _MASS else off
            made, beside_it = anchored(made, far), anchored(whole, far)
            # What the other explains beside the effect as well makes it no rival there either.
            more = [i for i in open_to if linear.choices[i].label == name] if both > whole.solution.score else []
            both = float(np.max(beside_it.scorer.scores([whole.chosen, *((*whole.chosen, i) for i in more)])))
        # What the effect leaves is not taken up by numbers that no file has.
        replaced = [i for i, c in enumerate(made.linear.columns) if c.candidate.label == label]
        near = translated(whole, whole.solution.each, made)
        there = left_beside(made, made.scorer.beside(made.chosen, near, replaced), own)
        if takes.sum() >= TELLS and _shared(takes, without - there) <= _MOSTLY:
            continue
        rise = best[name].rise if np.isfinite(best[name].rise) else float(np.expm1(2.0 * np.max(there - left)))
        as_good = rise < min(matters, _MOSTLY * alone)
        as_good = as_good and _shared(as_it_is - now, as_it_is - left_by_set(made)) > _MOSTLY
        if as_good or (sure and both - made.solution.score < least):
            found.append(Rival(name, _instead(search, made, label, least)))
    return found


def _as_a_load(whole: Fit) -> float:
    """How far moments of inertia are off, times 1 %, if what makes the thrust over mass less is a load; 0 where nothing
    beside it says so. A load that moves the centre of mass has moments, too: about as large a share as of the mass."""
    moved = any(x.split()[0] == "com_offset" for x in whole.labels)
    ratio = thrust_over_mass(whole, ()) if moved else []
    return max((abs(float(np.log(n.value))) / _MOMENTS for n in ratio), default=0.0)


def _instead(search: Search, made: Fit, label: str, least: float) -> Fit:
    """The fit with a rival, whose number is told as that of an effect in another's place: no part of what it stands for
    is there as what the file is off by, unless that explains far less. least: nats that are no difference."""
    o, spike = made.linear.observation, made.linear.spike(made.scales)
    mine = {
        (label, c.place) for c, s in zip(made.linear.columns, spike, strict=True) if s and c.candidate.label == label
    }
    if o.healthy is not None or not mine:
        return made
    alone = replace(search, observation=replace(o, still=o.still | mine))
    instead = alone.fitted(made.labels, replace(made, linear=replace(made.linear, observation=alone.observation)))
    return instead if instead.worth > made.worth - _ALONE * least else made


def _in_time(search: Search, whole: Fit, label: str) -> tuple[Fit, dict[str, float]]:
    """A set without one of its effects that shift in time, and by how many nats each other of them is worse in its
    place, by label.

    A delay and a lag do the same to what is slow. From a model that has one of them the other is two steps away that
    are not linear, from one without either it is one.
    """
    timed = {c.label: () for c in search.known if not c.cls.linear and c.cls.place in _TIMED}
    if label not in timed:
        return whole, {}
    now, stay = whole.linear, [x for x in whole.labels if x != label]
    point = [m for m in now.point if m.candidate.label != label]
    there = linearised(search.observation, point, search.known, timed, like=now, frozen=True)
    rest = there.labelled(stay)
    scorer = there.scorer(whole.scales, whole.held)
    others = [x for x in timed if x not in whole.labels and x not in search.barred]
    choices = [(*rest, i) for i in there.labelled([label, *others])]
    own, *scores = scorer.scores(choices)
    begun = replace(whole, linear=there, chosen=rest, solution=scorer.solution(rest))
    return begun, {x: float(own - y) for x, y in zip(others, scores, strict=True) if np.isfinite(y)}


def _shared(takes: Array, other: Array) -> float:
    """The share of the error that an effect takes off each axis which another takes, too: elsewhere it is another."""
    takes = np.maximum(takes, 0.0)
    return float(np.minimum(takes, np.maximum(other, 0.0)).sum() / max(takes.sum(), 1e-12))


@dataclass(frozen=True)
class _Near:
    """One effect in another's place: what the other adds to it (nats), by how much the error rises, the score of
    both."""

    adds: float
    rise: float
    both: float
