"""What the flown flights leave open: which explanations are to be told apart, or whose number is to be narrowed."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from infotraj.design.worth import Question, belief
from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.select.search import Fit
from infotraj.errors import InputError, UsageError, problem

_MOST = 3  # questions that are asked at once: the first of a long list


@dataclass(frozen=True)
class Asked:
    """A question and its words: the two explanations' names, the second empty where an effect is held against none."""

    question: Question
    first: str
    second: str

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
    fits = [_fitted(found, [*rest, x]) for x in labels]
    return Asked(_question(fits[0], fits[1]), *labels)


def determined(found: Diagnosis, name: str) -> Question:
    """One effect's numbers, beside all that is named."""
    label = _label(found, name)
    labels = found.whole.labels
    return _alone(_fitted(found, labels if label in labels else [*labels, label]))


def open_questions(found: Diagnosis) -> list[Asked]:
    """What the diagnosis could not tell: members of a group from each other, what is Plausible from nothing."""
    asked: list[Asked] = []
    groups = dict.fromkeys(f.group for f in found.findings if f.verdict == "Not separable")
    for group in groups:
        asked += [separated(found, a, b) for a, b in combinations(group[:_MOST], 2)]
    inside = set(found.whole.labels)
    for f in found.findings:
        if f.verdict == "Plausible" and f.evidence is not None and len(asked) < _MOST:
            label = _label(found, f.name)
            rest = [x for x in found.whole.labels if x != label]
            with_it = found.whole if label in inside else _fitted(found, [*rest, label])
            asked.append(Asked(_question(with_it, _fitted(found, rest)), label, ""))
    return asked[:_MOST]


def everything(found: Diagnosis) -> Question:
    """All numbers of what was found and of the file, no question being open."""
    return _alone(found.whole)


def _alone(fit: Fit) -> Question:
    return Question(belief(fit), None, spread=overdispersion(fit)[0])


def _question(first: Fit, second: Fit) -> Question:
    spread = overdispersion(first)[0]
    odds = (first.solution.score - second.solution.score) / spread
    return Question(belief(first), belief(second), float(odds), spread)


def _fitted(found: Diagnosis, labels: list[str] | tuple[str, ...]) -> Fit:
    if set(labels) == set(found.whole.labels):
        return found.whole
    return found.search.fitted(list(labels), found.whole)


def _label(found: Diagnosis, name: str) -> str:
    """The candidate of that name: the one that was found, else the most probable of them."""
    name, _, place = name.partition(":")
    every = [f.name for f in found.findings]
    if name not in every:
        raise UsageError(problem(f"no effect {name!r}", "a name of `infotraj effects`", "Correct it."))
    linear = found.whole.linear
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
