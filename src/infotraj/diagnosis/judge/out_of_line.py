"""A number that no file is wrong by is a finding: what makes it so has a name.

Beside a file that is free to be wrong nothing is needed that a number of the file does as well, however far off it is
then. Where it is further off than in the worst of files, or is one rotor's that is out of line with the others', and
takes half of an error off flights that were not fitted, beside the file as it is, silence would leave that error
without a name. What takes as much in its place is not told from it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.diagnosis.judge.evidence import evidence
from infotraj.diagnosis.judge.giving import Given, given
from infotraj.diagnosis.judge.lone_rotor import lone_rotor
from infotraj.diagnosis.judge.numbers import OF_THRUST_OVER_MASS, ORDINARY, in_fit, off, out_of_line_freed
from infotraj.diagnosis.judge.verdicts import CONFIDENT, HALVES, Finding, group_of
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.prior import IN_NO_FILE, SCALES, Scales
from infotraj.diagnosis.select.search import Search

_ROUNDS = 4
_MOST = 3  # other effects that are tried in its place


def with_out_of_line(
    search: Search, findings: tuple[Finding, ...], told: Fit, made: Given, rng: np.random.Generator
) -> tuple[tuple[Finding, ...], Fit, Given]:
    """The findings, set and model that is given with what is out of line with any file, where something is.

    told: the set of what is needed, beside a file that is free to be wrong.
    """
    if told.linear.observation.healthy is not None:
        return findings, told, made
    lone = lone_rotor(told)
    for label in dict.fromkeys([*([lone] if lone else []), *beyond_any_file(told)]):
        told_already = any(f.verdict in CONFIDENT and label.split()[0] in (f.name, *f.group) for f in findings)
        if label not in search.barred and not told_already:
            findings, told, made = _with(search, findings, told, made, rng, label)
    return findings, told, made


def beyond_any_file(told: Fit) -> list[str]:
    """Labels of effects that are numbers of the file, further off than in files that are off by ten percent; none of
    thrust over mass, which is of several, nor of what files leave out."""
    freed = out_of_line_freed(told, {x.split()[0] for x in told.labels})
    worst = told.linear.spike(Scales(max(SCALES)))
    found = [
        c.candidate
        for i, c, theta, deviation, _ in off(freed, ())
        if abs(theta) >= ORDINARY * np.hypot(worst[i], deviation)
    ]
    written = [c.label for c in found if c.cls.declared is not None and c.cls.declared.kind not in IN_NO_FILE]
    named = {c.label for c in told.linear.choices if np.isfinite(c.price)} - {*told.labels}
    return [x for x in dict.fromkeys(written) if x in named and x not in OF_THRUST_OVER_MASS]


def _with(
    search: Search, findings: tuple[Finding, ...], told: Fit, made: Given, rng: np.random.Generator, label: str
) -> tuple[tuple[Finding, ...], Fit, Given]:
    """The same with one effect, where it halves an error, in a group with what leaves less than twice as much."""
    named = [x for x in made.fit.labels if x not in made.beside]
    ratio = [x for x in list(made.of_ratio)[:1] if x not in named]
    tried = [label, *_instead(search, told, [*named, *ratio], label)]
    fits = {x: search.fitted([*named, *ratio, x], told, Scales(0.0), _ROUNDS, go_on=True) for x in tried}
    falls = {x: evidence(fit, x, rng) for x, fit in fits.items()}
    axis = max(falls[label].falls, key=lambda a: falls[label].falls[a], default="")
    most = falls[label].falls.get(axis, 0.0)
    if most < HALVES:
        return findings, told, made
    # Around the set, or around what stands for a group of which the set has another member.
    sets = dict.fromkeys([(*told.labels, label), (*named, label)])
    around = [search.fitted(x, told, go_on=True) for x in sets]
    with_it, wider = max(((given(search, x, [*named, label]), x) for x in around), key=lambda pair: pair[0].gain)
    if label in with_it.lost or label in with_it.at_bound:
        return findings, told, made
    # What leaves twice as much there is told from it.
    group = [x for x, e in falls.items() if e.falls.get(axis, 0.0) > most - HALVES]
    new = {f.name: f for f in group_of([(*in_fit(fits[x], x, told), falls[x]) for x in group])}
    return tuple(new.get(f.name, f) for f in findings), wider, with_it


def _instead(search: Search, told: Fit, beside: Sequence[str], label: str) -> list[str]:
    """Labels of the effects that are most probable in another's place, beside the file as it is, one of a name."""
    linear, names = told.linear, {x.split()[0] for x in (label, *beside)}
    rest = linear.labelled(beside)
    open_to = [
        i
        for i, c in enumerate(linear.choices)
        if np.isfinite(c.price) and c.label.split()[0] not in names and c.label not in search.barred
    ]
    if not open_to:
        return []
    best: dict[str, tuple[float, str]] = {}
    scores = linear.scorer(Scales(0.0), search.held).scores([(*rest, i) for i in open_to])
    for i, score in zip(open_to, scores, strict=True):
        x = linear.choices[i].label
        best[x.split()[0]] = max(best.get(x.split()[0], (-np.inf, x)), (float(score), x))
    return [x for _, x in sorted(best.values(), reverse=True)[:_MOST]]
