"""A number that no file is wrong by is a finding: what makes it so has a name.

Beside a file that is free to be wrong nothing is needed that a number of the file does as well, however far off it is
then. Where it is further off than in the worst of files, or is one rotor's that is out of line with the others', and
takes half of an error off flights that were not fitted, beside the file as it is, silence would leave that error
without a name. What takes as much in its place is not told from it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Container, Mapping, Sequence

import numpy as np

from infotraj.diagnosis.gates import refusal
from infotraj.diagnosis.judge.evidence import evidence
from infotraj.diagnosis.judge.giving import Given, given
from infotraj.diagnosis.judge.lone_rotor import lone_rotor
from infotraj.diagnosis.judge.numbers import OF_THRUST_OVER_MASS, ORDINARY, in_fit, off, out_of_line_freed
from infotraj.diagnosis.judge.verdicts import CONFIDENT, HALVES, Finding, group_of
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.prior import IN_NO_FILE, SCALES, Scales
from infotraj.diagnosis.select.search import Search
from infotraj.effects.base import Effect

_ROUNDS = 4
_MOST = 3  # other effects that are tried in its place


def with_out_of_line(
    search: Search,
    findings: tuple[Finding, ...],
    told: Fit,
    made: Given,
    rng: np.random.Generator,
    never: Container[str] = (),
    faint: Callable[[Fit], Mapping[str, float]] = lambda _: {},
) -> tuple[tuple[Finding, ...], Fit, Given]:
    """The findings, set and model that is given with what is out of line with any file, where something is.

    told: the set of what is needed, beside a file that is free to be wrong; never: names that have left it for a reason
    of their own; faint: axes of torque that a set hardly predicts.
    """
    if told.linear.observation.healthy is not None:
        return findings, told, made
    lone = lone_rotor(told)
    for label in dict.fromkeys([*([lone] if lone else []), *beyond_any_file(told)]):
        name = label.split()[0]
        taken = {x for f in findings if f.verdict in CONFIDENT for x in (f.name, *f.group)}
        if label in search.barred or name in never or name in taken:
            continue
        hardly = faint(told) if _class(told, label).like_commands else {}
        findings, told, made = _with(search, findings, told, made, rng, label, taken, hardly)
    return findings, told, made


def _class(told: Fit, label: str) -> type[Effect]:
    return next(c.candidate.cls for c in told.linear.columns if c.candidate.label == label)


def beyond_any_file(told: Fit) -> list[str]:
    """Labels of effects that are numbers of the file, further off than in files that are off by ten percent, the
    furthest first; none of thrust over mass, which is of several, nor of what files leave out."""
    freed = out_of_line_freed(told, {x.split()[0] for x in told.labels})
    worst = told.linear.spike(Scales(max(SCALES)))
    far = [(abs(theta) / np.hypot(worst[i], deviation), c.candidate) for i, c, theta, deviation, _ in off(freed, ())]
    found = [c for times, c in sorted(far, key=lambda x: -x[0]) if times >= ORDINARY]
    written = [c.label for c in found if c.cls.declared is not None and c.cls.declared.kind not in IN_NO_FILE]
    named = {c.label for c in told.linear.choices if np.isfinite(c.price)} - {*told.labels}
    return [x for x in dict.fromkeys(written) if x in named and x not in OF_THRUST_OVER_MASS]


def _with(
    search: Search,
    findings: tuple[Finding, ...],
    told: Fit,
    made: Given,
    rng: np.random.Generator,
    label: str,
    taken: Collection[str],
    faint: Container[str],
) -> tuple[tuple[Finding, ...], Fit, Given]:
    """The same with one effect, where it halves an error, in a group with what leaves less than twice as much; or with
    what leaves less than half as much as it does.

    taken: names that are told already; faint: axes on which a smaller prediction makes a smaller error.
    """
    named = [x for x in made.fit.labels if x not in made.beside]
    ratio = [x for x in list(made.of_ratio)[:1] if x not in named]
    tried = [label, *_instead(search, told, [*named, *ratio], label, taken)]
    fits = {x: search.fitted([*named, *ratio, x], told, Scales(0.0), _ROUNDS, go_on=True) for x in tried}
    falls = {x: evidence(fit, x, rng) for x, fit in fits.items()}
    axis = max(falls[label].falls, key=lambda a: falls[label].falls[a], default="")
    if falls[label].falls.get(axis, 0.0) < HALVES or refusal.axis_group(axis) in faint:
        return findings, told, made
    by_fall = {x: e.falls.get(axis, 0.0) for x, e in falls.items()}
    group = [x for x, fall in by_fall.items() if fall > max(by_fall.values()) - HALVES]
    head = label if label in group else max(group, key=by_fall.__getitem__)
    group.sort(key=lambda x: x != head)
    # Around the set, or around what stands for a group of which the set has another member.
    around = [search.fitted(x, told, go_on=True) for x in dict.fromkeys([(*told.labels, head), (*named, head)])]
    tried_around = [(given(search, x, [*named, head]), x) for x in around]
    kept = [(g, x) for g, x in tried_around if not {*named, head} & (g.lost.keys() | g.at_bound.keys() - made.at_bound)]
    if not kept:
        return findings, told, made
    with_it, wider = max(kept, key=lambda pair: pair[0].gain)
    new = {f.name: f for f in group_of([(*in_fit(fits[x], x, told), falls[x]) for x in group])}
    return tuple(new.get(f.name, f) for f in findings), wider, with_it


def _instead(search: Search, told: Fit, beside: Sequence[str], label: str, taken: Collection[str]) -> list[str]:
    """Labels of the effects that are most probable in another's place, beside the file as it is, one of a name."""
    linear, names = told.linear, {*taken, *(x.split()[0] for x in (label, *beside))}
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
