"""From the set that the search took to what is named and to the model that is given.

What is named is judged beside what else is named: an effect that does not predict, that ends at a bound or that spoils
the model that is given leaves the set, and the others are fitted and judged anew without it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from infotraj.diagnosis.gates import refusal
from infotraj.diagnosis.judge.giving import Given, given
from infotraj.diagnosis.judge.groups import Rival
from infotraj.diagnosis.judge.in_line import in_line
from infotraj.diagnosis.judge.needed import Judged, needed
from infotraj.diagnosis.judge.numbers import values_of
from infotraj.diagnosis.judge.out_of_line import with_out_of_line
from infotraj.diagnosis.judge.products import Products
from infotraj.diagnosis.judge.ratio import with_ratio
from infotraj.diagnosis.judge.unexplained import NOTHING_LEFT, Unexplained, unexplained
from infotraj.diagnosis.judge.verdicts import CONFIDENT, Finding, Judge, named
from infotraj.diagnosis.select.bounds import beyond_bounds
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.learned import straight
from infotraj.diagnosis.select.predicting import TELLS
from infotraj.diagnosis.select.search import Search
from infotraj.progress import pieces, reached

_STAY = 2  # of so many effects that the search took one stays
_NO_BETTER = "all that is named takes less than a sixth of one error off on flights that were not fitted"
_AGAIN = 10  # times its mean takes judging anew, where it comes


@dataclass(frozen=True)
class Asked:
    """What verdicts are drawn from beside a set: the search, names of the catalogue, those without a candidate and why,
    axes on which nothing can be said, the least rise that counts; start, stop: s, the part of every flight to use;
    products: of inertia, where these flights show them and the file leaves them out; as_ever: axes of the residual on
    which the healthy model leaves no more than on some healthy flight."""

    search: Search
    order: tuple[str, ...]
    hidden: Mapping[str, str]
    refused: Mapping[str, str]
    matters: float
    seed: int
    rng: np.random.Generator
    start: float | None = None
    stop: float | None = None
    products: Products | None = None
    as_ever: frozenset[str] = frozenset()
    _left: dict[int, tuple[Fit, Unexplained]] = field(default_factory=dict)
    _faint: dict[int, tuple[Fit, dict[str, float]]] = field(default_factory=dict)

    def left(self, told: Fit) -> Unexplained:
        """Structure that a set leaves: what only effects explain that do not predict is left."""
        if not self.search.known:
            return NOTHING_LEFT
        if id(told) not in self._left:
            found = unexplained(told, self.matters, np.random.default_rng([self.seed, 0]))
            self._left[id(told)] = told, found
        return self._left[id(told)][1]

    def judged(self, told: Fit, judged: Sequence[Judged]) -> tuple[tuple[Finding, ...], dict[str, Rival]]:
        """Findings of a set, and rivals that stand for a group."""
        faint = self.faint(told) if any(j.member.candidate.cls.like_commands for j in judged) else {}
        judge = Judge(
            self.search,
            told,
            judged,
            self.order,
            self.left(told),
            self.refused,
            self.matters,
            self.rng,
            faint,
            self.as_ever,
        )
        return judge.findings(self.hidden)

    def faint(self, told: Fit) -> dict[str, float]:
        """Axes of torque that a set hardly predicts, and the share that it does; none against healthy flights, nor
        where nothing can be tested."""
        o = self.search.observation
        if o.healthy is not None or not self.search.known:
            return {}
        if id(told) not in self._faint:
            made, given = (
                refusal.compared(o.model(m), o.flights, self.start, self.stop)
                for m in (straight(told), self.search.held)
            )
            self._faint[id(told)] = told, refusal.hardly_predicted(made, given)
        return self._faint[id(told)][1]


def decided(asked: Asked, whole: Fit) -> tuple[tuple[Finding, ...], Fit, Given, tuple[Fit, ...]]:
    """Findings, the set of what is needed, the model that is given, and fits with what stands in the place of a name,
    from the set that the search took.

    Where nothing is named what has no column may have made the file look further off than it is: products of inertia
    are then searched beside.
    """
    out = _decided(asked, whole)
    if named(out[0]) or asked.products is None:
        return out
    reached("searching again")
    made = asked.products.beside(whole)
    search = asked.products.at(whole)
    return _decided(replace(asked, search=search, products=None), search.best(made.linear, made))


def _decided(asked: Asked, whole: Fit) -> tuple[tuple[Finding, ...], Fit, Given, tuple[Fit, ...]]:
    search, vehicle = asked.search, asked.search.observation.vehicle
    if not search.known:
        return asked.judged(whole, [])[0], whole, given(search, whole, []), ()
    out: dict[str, Finding] = {}  # what left the set because of the model that is given
    why: dict[str, str] = {}
    stay: set[str] = set()  # of them, those that correct the file
    impossible: set[str] = set()  # of them, those of which a number ends at a physical bound
    gone: list[Judged] = []
    told, changed = whole, True
    while True:
        if changed:
            told, judged, more = needed(search, told, asked.rng)
            gone += more
            pieces("naming", _STAY * len(judged))
            findings, stand = asked.judged(told, [*judged, *gone])
            findings = _demoted(tuple(out.get(f.name, f) for f in findings), why, impossible)
        labels = _labels(told, named(findings), {n: r.label for n, r in stand.items()})
        made = _made(search, told, labels, stand)
        at_bound = beyond_bounds(told.members, vehicle) | made.at_bound
        if search.hold_parts((*told.members, *made.fit.members), at_bound):
            told, changed = search.without_parts(told), True
            continue
        ended = at_bound | made.lost
        confident = {f.name for f in findings if f.verdict in CONFIDENT}
        # Of several rotors of one name one may go alone.
        of_name = {n: [x for x in told.labels if x.split()[0] == n] for n in confident}
        lost = {n: r for x, r in ended.items() if (n := x.split()[0]) in confident and set(of_name[n]) <= ended.keys()}
        if confident and not lost and made.gain < TELLS:
            # What makes up for one another takes nothing off the model as given.
            lost = dict.fromkeys(sorted(confident), _NO_BETTER)
        if asked.products is not None and not lost:
            lost = asked.products.explain(told, confident, asked.rng)
            if lost:
                # What is left is judged beside them.
                told, search = asked.products.beside(told), asked.products.at(told)
                asked = replace(asked, search=search, products=None)
        # What is the file's own error is corrected beside the rest, and stays in the set.
        own = {} if lost else in_line(findings, told, stand)
        rest = [x for x in told.labels if x not in ended or x.split()[0] not in confident]
        if not lost and not own and len(rest) == len(told.labels):
            findings, made = with_ratio(findings, told, made, asked.rng)
            before = told
            findings, told, made = with_out_of_line(search, findings, told, made, asked.rng, why, asked.faint)
            findings = _with_held_back(findings, made.held_back | _still(told))
            # What stood for a group did so without what is named last.
            others = _others(findings, stand) if told is before else ()
            return _with_apart(findings, made, others), told, made, others
        why |= lost | own
        impossible |= lost.keys() & {x.split()[0] for x in at_bound.keys() - made.lost.keys()}
        stay |= own.keys()
        demoted = _demoted(findings, why, impossible)
        demoted = tuple(replace(f, of_file=f.name in stay) for f in demoted)
        out |= {f.name: f for f in demoted if f.name in confident and f.verdict not in CONFIDENT}
        findings, rest = demoted, [x for x in rest if x.split()[0] not in out.keys() - stay]
        changed = len(rest) < len(told.labels)
        if changed:
            pieces("judging again", _AGAIN)
            reached("judging again")
            told = search.fitted(rest, told, go_on=True)


def _labels(told: Fit, supported: Sequence[str], stand: dict[str, str]) -> list[str]:
    """Labels of what is named: those of the set that was found, and what stands for a member of a group."""
    labels = [x for x in told.labels if x.split()[0] in supported]
    inside = {x.split()[0] for x in labels}
    return labels + [label for name, label in stand.items() if name in supported and name not in inside]


def _made(search: Search, told: Fit, labels: Sequence[str], stand: Mapping[str, Rival]) -> Given:
    """The model that is given, made around the set; or around a fit with what stands for a group of which the set has
    another member, where flights that were not fitted are predicted better for it.

    Around the set it stands beside what the file was found to be off by with that other member.
    """
    made = given(search, told, labels)
    for r in stand.values():
        if r.label in labels and r.label not in told.labels:
            other = given(search, r.fit, labels)
            made = other if other.gain > made.gain + TELLS else made
    return made


def _demoted(
    findings: tuple[Finding, ...], why: Mapping[str, str], impossible: AbstractSet[str]
) -> tuple[Finding, ...]:
    """The findings without confidence in the names of `why`. What flights could not tell from one of them stays, but
    where it is left alone: what is `impossible` is no rival of it."""
    out = []
    for f in findings:
        if f.verdict in CONFIDENT and f.name in why:
            f = replace(f, verdict="Plausible", group=(f.name,), reason=why[f.name])
        elif f.verdict in CONFIDENT and why.keys() & (old := set(f.group)):
            group = tuple(n for n in f.group if n not in why)
            f = replace(f, group=group)
            if len(group) == 1 and (lost := next(n for n in why if n in old)) in impossible:
                f = replace(f, verdict="Supported", reason="")
            elif len(group) == 1:
                f = replace(f, verdict="Plausible", reason=f"these flights cannot tell it from {lost}: {why[lost]}")
        out.append(f)
    return tuple(out)


def _still(told: Fit) -> dict[str, str]:
    """Labels of effects of which numbers stay absent, and why."""
    out: dict[str, list[str]] = {}
    for m in told.members:
        at = m.places(told.linear.observation.vehicle)
        for label, k in sorted(told.linear.observation.still):
            if label == m.candidate.label:
                out.setdefault(label, []).append(f"{at[k].parameter}[{at[k].component}]")
    return {x: f"without {', '.join(names)}, of which a fit ends at a physical bound" for x, names in out.items()}


def _with_held_back(findings: tuple[Finding, ...], held_back: Mapping[str, str]) -> tuple[Finding, ...]:
    """The findings, with what is held back of them and why."""
    by_name = {label.split()[0]: reason for label, reason in held_back.items()}
    return tuple(
        replace(f, reason="; ".join(filter(None, [f.reason, by_name[f.name]])))
        if f.name in by_name and f.verdict in CONFIDENT
        else f
        for f in findings
    )


def _others(findings: Sequence[Finding], stand: Mapping[str, Rival]) -> tuple[Fit, ...]:
    """The fits with what stands for a group that is told with confidence."""
    return tuple(stand[f.name].fit for f in findings if f.verdict in CONFIDENT and f.name in stand)


def _with_apart(findings: tuple[Finding, ...], made: Given, stand: Sequence[Fit]) -> tuple[Finding, ...]:
    """The findings, with errors of what the model that is given, and fits with what stands for a group, say otherwise.

    A number is told beside all that may be missing, the model has what is named, and a group what flights cannot tell
    from it: which of them stands beside it is not known either, and two that are as likely are half of their difference
    from their mean (Draper 1995).
    """
    others = [{m.candidate.label: values_of(m) for m in x.members} for x in stand]
    if made.fit.linear.observation.healthy is None:
        own = [m for m in made.fit.members if m.candidate.label not in made.held_back]
        others.append({m.candidate.label: values_of(m) for m in own})
    return tuple(_apart_from(f, others) if f.verdict in CONFIDENT else f for f in findings)


def _apart_from(f: Finding, others: Sequence[Mapping[str, Mapping[str, Any]]]) -> Finding:
    """A finding, its errors with half of what other models' numbers, by label, differ from it by at most."""
    same = [v for model in others for x, v in model.items() if x.split()[0] == f.name and _same(v, f)]
    errors = dict(f.standard_errors)
    for k, v in errors.items():
        apart = [0.5 * np.abs(np.subtract(own[k], f.parameters[k])) for own in same if k in own]
        if apart:
            errors[k] = np.hypot(v, np.max(apart, axis=0)).tolist()
    return replace(f, standard_errors=errors)


def _same(values: Mapping[str, Any], f: Finding) -> bool:
    """Whether numbers are of the same rotor or tilt as a finding's, which has no error of that."""
    return all(values.get(k) == v for k, v in f.parameters.items() if k not in f.standard_errors)
