"""A set of effects fitted to all flights: its numbers, how probable it is, and where the model has not come yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.select.around import Linear
from infotraj.diagnosis.select.prior import Scales
from infotraj.diagnosis.select.score import Scorer, Solution
from infotraj.rotations import Array

LOOSE = 10.0  # weighted squared error that a file number must be worth to be taken into the model: the rest is linear


@dataclass(frozen=True)
class Fit:
    """A set of effects fitted to all flights.

    linear: the model around the fitted numbers; chosen: choices of `linear` that are in the set; scales: how far the
    file is off; solution: its numbers, without each fold too; known: the candidates of the search; held: effects
    that the model had, where their numbers stay as they were; exact: the model was computed with every number of the
    file, so that its error is that of the numbers around which it is linear.
    """

    linear: Linear
    chosen: tuple[int, ...]
    scales: Scales
    solution: Solution
    known: tuple[Candidate, ...] = ()
    held: tuple[Member, ...] | None = None
    exact: bool = False

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the effects in the set."""
        return tuple(self.linear.choices[i].label for i in self.chosen)

    @cached_property
    def members(self) -> tuple[Member, ...]:
        """Held and chosen effects, with their numbers."""
        taken = set(self.labels)
        found = tuple(m for m in self.linear.point if m.held or m.candidate.label in taken)
        if self.linear.observation.healthy is None or self.scales.common == 0.0:
            return found
        # What changed, apart from what is not known of the healthy numbers.
        return self.linear.with_numbers(found, self.changes[0])

    @cached_property
    def changes(self) -> tuple[Array, Array, Array]:
        """By how much the chosen numbers differ from healthy ones, (p,), without each fold too, and their deviation."""
        return self.scorer.apart(self.chosen)

    @cached_property
    def scorer(self) -> Scorer:
        """What scores sets beside this one."""
        return self.linear.scorer(self.scales, self.held)

    @cached_property
    def _scorers(self) -> tuple[Scorer, ...]:
        """What scores sets beside files from exact to ten times ordinary, kinds as far apart as beside this one."""
        if self.scales.common == 0.0 or self.linear.observation.healthy is not None:
            return (self.scorer,)
        own = self.scales.common
        others = {x.common: self.scales.times(x.common / own) for x in self.linear.scales}
        return tuple(self.scorer if x == own else self.linear.scorer(s, self.held) for x, s in others.items())

    def log_probability(self, sets: Sequence[tuple[int, ...]]) -> Array:
        """Of sets of choices, (n,), nats up to a constant, however far the file is off: what is sure beside one that is
        nearly right may be nothing beside one that is not."""
        keys = [frozenset(s) for s in sets]
        new = {k: s for k, s in zip(keys, sets, strict=True) if k not in self._known}
        if new:
            scores = np.array([x.scores(list(new.values())) for x in self._scorers])
            self._known.update(zip(new, np.logaddexp.reduce(scores, axis=0).tolist(), strict=True))
        return np.array([self._known[k] for k in keys])

    @cached_property
    def _known(self) -> dict[frozenset[int], float]:
        """`log_probability` of sets so far: every effect of a set is asked for beside the same others."""
        return {}

    @property
    def worth(self) -> float:
        """Its score where the numbers are that its model was made linear around, not where that leads."""
        return self.solution.score - 0.5 * max(self.gain_left, 0.0)

    def may_fall(self, share: float) -> bool:
        """Whether the error would still fall by more than a share of what the solution leaves."""
        return self.gain_left > share * self.linear.absent.whole_error(self.solution.theta)

    @cached_property
    def gain_left(self) -> float:
        """By how much the weighted squared error would still fall from where the model is to the solution's numbers.

        Numbers that are left to the linear model, for they change little, are where they are in both.
        """
        now, theta = self.linear, self.solution.theta
        moving = {m.candidate.label for m in (*now.point, *self.next_point(theta))}
        here = np.where([c.candidate.label in moving for c in now.columns], now.now, theta)
        return float(now.absent.whole_error(here) - now.absent.whole_error(theta))

    def next_point(self, numbers: Array) -> tuple[Member, ...]:
        """What the model is computed with at numbers (p,): every number of the file, or those that change much."""
        if self.exact:
            return self.linear.members(self.chosen, numbers, shift=0.0, straight=True)
        return self.linear.members(self.chosen, numbers, shift=LOOSE)

    def error(self, theta: Array) -> Array:
        """Weighted squared error (axes, blocks) with numbers theta (folds, p), each fold under its own."""
        sums = self.linear.absent
        folds = np.unique(sums.fold)
        return sums.error(theta[np.searchsorted(folds, sums.fold)])
