"""What the flown flights leave open: which explanations are to be told apart, or whose number is to be narrowed."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from infotraj.design.worth import Question, belief
from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.judge.groups import AS_PROBABLE
from infotraj.diagnosis.judge.numbers import OF_THRUST_OVER_MASS
from infotraj.diagnosis.select.fit import Fit
from infotraj.errors import InputError, UsageError, problem

_MOST = 3  # questions that are asked at once: the first of a long list


@dataclass(frozen=True)
class Asked:
    """A question and its words: the two explanations' names, the second empty where an effect is held against none.

    fitted: log odds of the first as the two fits have them, believed or not.
    """

    question: Question
    first: str
    second: str
    fitted: float

    @property
    def words(self) -> str:
        """What is asked, for people."""
        return f"{self.first} from {self.second}" if self.second else f"{self.first} from nothing of the kind"


def separated(found: Diagnosis, first: str, second: str) -> Asked:
    """One named effect against another. UsageError for a name that is none; InputError where one cannot be tested."""
    labels = [_label(found, n) for n in (first, second)]
    if labels[0] == labels[1]:
        raise UsageError(problem(f"--separate {first} {second}", "two effects", "Name another."))
    rest = [x for x in found.whole.labels if x not in labels]
    fits, straight = _both(found, [[*rest, x] for x in labels])
    said = [found.finding(x.split()[0]).verdict == "Supported" for x in labels]
    return _asked(fits[0], fits[1], *labels, said=said[0] != said[1], straight=straight)


def determined(found: Diagnosis, name: str) -> tuple[Question, str]:
    """One effect's numbers, beside all that is named, and its label: the file may hold other rotors' of that name."""
    label = _label(found, name)
    labels = found.whole.labels
    return _alone(_fitted(found, labels if label in labels else [*labels, label])), label


def open_questions(found: Diagnosis) -> list[Asked]:
    """What the diagnosis could not tell: members of a group from each other, what is Plausible from nothing.

    A mass and a thrust are not asked about: a scale tells them apart, and hardly any flight does.
    """
    asked: list[Asked] = []
    groups = dict.fromkeys(f.group for f in found.findings if f.verdict == "Not separable")
    for group in groups:
        pairs = combinations(group[:_MOST], 2)
        told = [p for p in pairs if "mass_offset" not in p or not set(p) <= OF_THRUST_OVER_MASS]
        asked += [separated(found, a, b) for a, b in told]
    inside = set(found.whole.labels)
    for f in found.findings:
        if f.verdict == "Plausible" and not f.of_file and f.evidence is not None and len(asked) < _MOST:
            label = _label(found, f.name)
            rest = [x for x in found.whole.labels if x != label]
            with_it = found.whole if label in inside else _fitted(found, [*rest, label])
            asked.append(_asked(with_it, _fitted(found, rest), label, "", said=False))
    return asked[:_MOST]


def everything(found: Diagnosis) -> tuple[Question, tuple[str, ...]]:
    """All numbers of what was found and of the file, no question being open, and the labels of what was found."""
    return _alone(found.whole), found.whole.labels


def _alone(fit: Fit) -> Question:
    return Question(belief(fit), None, spread=overdispersion(fit)[0])


def _asked(first: Fit, second: Fit, *names: str, said: bool, straight: bool = False) -> Asked:
    """said: whether the diagnosis says which it is; straight: both fits are in one linearisation.

    Each explanation is fitted around its own numbers, and a wrong file can be bent to either: odds that would pass for
    a verdict, where the flights that were not fitted gave none, are no evidence. They count as even.
    """
    spread = overdispersion(first)[0]
    odds = float((first.solution.score - second.solution.score) / spread)
    believed = odds if said or abs(odds) < AS_PROBABLE else 0.0
    return Asked(Question(belief(first), belief(second), believed, spread, straight), names[0], names[1], odds)


def _both(found: Diagnosis, sets: list[list[str]]) -> tuple[list[Fit], bool]:
    """Two sets, each fitted around its own numbers; where that lost what the straight model had, both in that one.

    Around its own numbers a fit should only gain. Beside an effect that few data bear (a load found in hover) it may
    lose a hundred nats instead, each fit another hundred, and their odds mean nothing.
    """
    settled = [_fitted(found, x) for x in sets]
    straight = [found.search.fitted(x, found.whole, rounds=0) for x in sets]
    least = AS_PROBABLE * overdispersion(found.whole)[0]
    lost = [
        np.isfinite(b.solution.score) and not a.solution.score > b.solution.score - least
        for a, b in zip(settled, straight, strict=True)
    ]
    return (straight, True) if any(lost) else (settled, False)


def _fitted(found: Diagnosis, labels: list[str] | tuple[str, ...]) -> Fit:
    if set(labels) == set(found.whole.labels):
        return found.whole
    return found.search.fitted(list(labels), found.whole)


def _label(found: Diagnosis, name: str) -> str:
    """The candidate of that name: the one that was found, else the most probable of them.

    UsageError for a name that is none, and for a place that the effect has not.
    """
    name, _, place = name.partition(":")
    every = [f.name for f in found.findings]
    if name not in every:
        raise UsageError(problem(f"no effect {name!r}", "a name of `infotraj effects`", "Correct it."))
    linear = found.whole.linear
    there = list(dict.fromkeys(c.label.replace(" ", ":") for c in linear.choices if c.label.split()[0] == name))
    if place and there and f"{name}:{place}" not in there:
        what = f"{name}:{place}: the effect has no places" if there == [name] else f"{name} has no place {place}"
        raise UsageError(problem(what, " or ".join(there), "Correct it."))
    own = [x for x in found.whole.labels if x.split()[0] == name and (not place or x.split()[1:] == [place])]
    if own:
        return own[0]
    mine = [
        i
        for i, c in enumerate(linear.choices)
        if c.label.split()[0] == name and (not place or c.label.split()[1:] == [place]) and np.isfinite(c.price)
    ]
    if not mine:
        why = found.finding(name).reason or "the model has it already"
        raise InputError(problem(f"{name} cannot be tested: {why}", "an effect that flights can show", "Name another."))
    scores = found.whole.scorer.scores([(*found.whole.chosen, i) for i in mine])
    return linear.choices[mine[int(np.argmax(scores))]].label
