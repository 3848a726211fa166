"""Searches sets of effects by their held-out error, from sums alone: all singles and pairs, then a beam.

Every set is fitted, with the numbers of the effects that are in the model already, on all folds but one and tested on
that one. Numbers that a fit wants outside their bounds are held at the bound and the others fitted again.
"""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from copy import copy
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from infotraj.diagnosis.lonely import fitted, halves, lonely
from infotraj.diagnosis.plain import Plain
from infotraj.diagnosis.sensitivities import Sensitivities
from infotraj.diagnosis.sums import RIDGE, Sums, held_out
from infotraj.rotations import Array

BEAM = 12
_SLACK = 0.05  # usual sizes by which a number may lie outside its bounds, beside three standard errors
_PASSES = 4


@dataclass(frozen=True)
class Scored:
    """A set of choices (indices), what it gains in held-out squared error, and the numbers (columns, values).

    free: for each number whether it was fitted; the others are held at a bound.
    """

    chosen: tuple[int, ...]
    gain: float
    columns: tuple[int, ...]
    theta: Array
    free: NDArray

    def plain(self, sums: Plain) -> Array:
        """Its mean squared error by axis, not whitened, (axes,)."""
        theta = np.zeros(len(sums.right[0]))
        theta[list(self.columns)] = self.theta
        return sums.error(theta)

    def held_out(self, sums: Sums) -> Array:
        """Its held-out squared error by axis and block, (axes, blocks)."""
        held = np.zeros(sums.gram.shape[-1])
        held[list(self.columns)] = np.where(self.free, 0.0, self.theta)
        columns = [c for c, free in zip(self.columns, self.free, strict=True) if free]
        return held_out(sums.shifted(held), columns)[0]


@dataclass(frozen=True)
class _Folds:
    """What is held out fold by fold, per unit of each column's size: training and testing sums, and those of all.

    train: (gram, right) a fold; test: the same, of its halves (2, ...); every: of all flights; sure: gain of what is
    not chosen (tolerances) alone; penalty: the quadratic and linear part, in a set's numbers, of what the tolerances'
    prior takes off the gain.
    """

    train: list[tuple[Array, Array]]
    test: list[tuple[Array, Array]]
    every: tuple[Array, Array]
    sure: float
    penalty: tuple[Array, Array]


class SubsetSearch:
    """Scores sets of choices in addition to the model's members.

    tolerances: columns that are always fitted, and the standard deviations of their numbers about 0 (usual sizes): a
    set gains what these do not explain, and what their prior loses less. They are eliminated from the sums beforehand
    (Schur complement), so that sets cost what they cost without them.
    """

    def __init__(self, sums: Sums, found: Sensitivities, tolerances: tuple[Sequence[int], Array] | None = None) -> None:
        self.found = found
        self.gram, self.right, self.square = sums.total()
        self.fold = sums.fold
        p = self.gram.shape[-1]
        half = halves(self.fold)
        parts = [[(self.fold == f) & (half == h) for h in (0, 1)] for f in np.unique(self.fold)]
        gram_of = np.array([[self.gram[part].sum(axis=0) for part in fold] for fold in parts])
        right_of = np.array([[self.right[part].sum(axis=0) for part in fold] for fold in parts])
        self._gram_of = np.pad(gram_of, ((0, 0), (0, 0), (0, 1), (0, 1)))
        self._right_of = np.pad(right_of, ((0, 0), (0, 0), (0, 1)))
        self._lonely = lonely(self._gram_of.sum(axis=1))
        diagonal = np.diag(self._gram_of.sum(axis=(0, 1))).copy()
        self._size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        self._gram_of /= self._size[:, None] * self._size
        self._right_of /= self._size
        columns, deviation = tolerances if tolerances is not None else ([], np.zeros(0))
        self._tolerated = np.array(columns, dtype=int)
        self._precision = 1.0 / (np.asarray(deviation) * self._size[self._tolerated]) ** 2
        self._folds = self._eliminated()
        self._low = np.full(p + 1, -np.inf)
        self._high = np.full(p + 1, np.inf)
        m = list(found.of_members)
        self._low[m], self._high[m] = _distances(found.now, found.scale, found.low, found.high)
        for c in found.choices:
            self._low[list(c.columns)], self._high[list(c.columns)] = _distances(c.now, c.scale, c.low, c.high)

    @property
    def width(self) -> int:
        """How many columns there are."""
        return len(self._size) - 1

    def moved(self, theta: Array) -> SubsetSearch:
        """The same after the residual has become r - S theta; bounds are those of the numbers where they were."""
        step = np.append(theta, 0.0)
        made = copy(self)
        made._right_of = self._right_of - self._gram_of @ (step * self._size)
        made._folds = made._eliminated()
        made._low, made._high = self._low - step, self._high - step
        return made

    def score(self, sets: Sequence[tuple[int, ...]], members: Sequence[int] | None = None) -> list[Scored]:
        """Scores sets of choices; `members`: the columns of the model that are fitted along (all by default)."""
        kept = tuple(self.found.of_members if members is None else members)
        columns = [kept + tuple(c for i in s for c in self.found.choices[i].columns) for s in sets]
        if not columns:
            return []
        width = max(map(len, columns), default=0)
        if width == 0:
            return [Scored(tuple(s), self._folds.sure, (), np.zeros(0), np.zeros(0, dtype=bool)) for s in sets]
        none = len(self._size) - 1
        index = np.full((len(sets), width), none)
        for k, c in enumerate(columns):
            index[k, : len(c)] = c
        gain, theta, free = self._bounded(index, none)
        return [
            Scored(tuple(s), float(g), c, t[: len(c)], f[: len(c)])
            for s, g, c, t, f in zip(sets, gain, columns, theta, free, strict=True)
        ]

    def _bounded(self, index: Array, none: int) -> tuple[Array, Array, NDArray]:
        held = np.full(index.shape, np.nan)
        gain, theta, error = self._solve(index, none, held)
        todo = np.arange(len(index))
        for _ in range(_PASSES):
            low, high = self._low[index[todo]], self._high[index[todo]]
            slack = np.maximum(_SLACK, 3 * error)
            free = np.isnan(held[todo])
            below, above = free & (theta[todo] < low - slack), free & (theta[todo] > high + slack)
            out = (below | above).any(axis=1)
            if not out.any():
                break
            todo, error = todo[out], error[out]
            held[todo] = np.where(below[out], low[out], np.where(above[out], high[out], held[todo]))
            gain[todo], theta[todo], error = self._solve(index[todo], none, held[todo])
        else:
            gain[todo] = -np.inf
        return gain, theta, np.isnan(held)

    def _solve(self, index: Array, none: int, held: Array) -> tuple[Array, Array, Array]:
        """Held-out gain (n,), numbers and errors (n, width) of n sets; held: values that are not fitted, else NaN."""
        free = np.isnan(held)
        value = np.where(free, 0.0, held) * self._size[index]
        eye = np.eye(index.shape[1])
        rows, cols = index[:, :, None], index[:, None, :]
        both = free[:, :, None] & free[:, None, :]
        all_gram, all_right = self._folds.every
        filler = ((index == none) | ~free)[:, :, None] * eye + RIDGE * eye
        fixed = not free.all()

        def right(gram: Array, b: Array) -> Array:
            if not fixed:
                return b[index]
            return np.where(free, b[index] - np.einsum("nij,nj->ni", gram[rows, cols], value), value)

        gain = np.full(len(index), self._folds.sure)
        for k, (rest, of_rest) in enumerate(self._folds.train):
            theta = np.linalg.solve(rest[rows, cols] * both + filler, right(rest, of_rest)[..., None])[..., 0]
            g, b = (x.sum(axis=0) for x in self._folds.test[k])
            fall = 2 * np.sum(theta * b[index], axis=1) - np.einsum("ni,nij,nj->n", theta, g[rows, cols], theta)
            for i in np.flatnonzero((self._lonely[k][index] & free).any(axis=1)):
                fall[i] = self._by_halves(k, index[i], free[i], value[i])
            gain += fall
        inverse = np.linalg.inv(all_gram[rows, cols] * both + filler)
        theta = np.einsum("nij,nj->ni", inverse, right(all_gram, all_right))
        quadratic, linear = self._folds.penalty
        gain += 2 * np.sum(theta * linear[index], axis=1)
        gain -= np.einsum("ni,nij,nj->n", theta, quadratic[rows, cols], theta)
        error = np.sqrt(np.maximum(np.einsum("nii->ni", inverse), 0.0))
        return gain, theta / self._size[index], error / self._size[index]

    def _by_halves(self, k: int, index: Array, free: NDArray, value: Array) -> float:
        """Held-out gain of one set in fold k, where one of its columns shows in that fold only (`lonely`)."""
        at = index[free & (index < self.width)]
        place = np.zeros(self.width + 1)
        place[index[~free]] = value[~free]
        (rest, of_rest), (grams, rights) = self._folds.train[k], self._folds.test[k]
        inner = np.ix_(at, at)
        total = 0.0
        for h in (0, 1):
            g, b, other, of_other = grams[h], rights[h], grams[1 - h], rights[1 - h]
            left, of_left = of_rest - rest @ place, of_other - other @ place
            theta = place.copy()
            alone, tested = self._lonely[k][at], np.diag(g)[at]
            theta[at] = fitted(rest[inner], left[at], other[inner], of_left[at], alone, tested, RIDGE)
            total += float(2 * theta @ b - theta @ g @ theta)
        return total

    def _eliminated(self) -> _Folds:
        t = self._tolerated
        all_gram, all_right = self._gram_of.sum(axis=(0, 1)), self._right_of.sum(axis=(0, 1))
        pairs = list(zip(self._gram_of, self._right_of, strict=True))
        if len(t) == 0:
            train = [(all_gram - g.sum(axis=0), all_right - b.sum(axis=0)) for g, b in pairs]
            return _Folds(train, pairs, (all_gram, all_right), 0.0, (0.0 * all_gram, 0.0 * all_right))

        def reduced(gram: Array, b: Array) -> tuple[Array, Array, Array, Array]:
            """Sums without tolerances, and how these follow from the rest: tau = alone - along theta."""
            both = np.linalg.solve(gram[np.ix_(t, t)] + np.diag(self._precision), np.column_stack([gram[t], b[t]]))
            along, alone = both[:, :-1], both[:, -1]
            return gram - gram[:, t] @ along, b - gram[:, t] @ alone, along, alone

        train, test, sure = [], [], 0.0
        for g, b in pairs:
            gram, right, along, alone = reduced(all_gram - g.sum(axis=0), all_right - b.sum(axis=0))
            train.append((gram, right))
            turn = np.eye(len(gram))
            turn[t] -= along
            left = b - g[:, :, t] @ alone
            test.append((turn.T @ g @ turn, left @ turn))
            sure += float(2 * alone @ b.sum(axis=0)[t] - alone @ g.sum(axis=0)[np.ix_(t, t)] @ alone)
        gram, right, along, alone = reduced(all_gram, all_right)
        weighted = along.T * self._precision
        sure -= float(alone @ (self._precision * alone))
        return _Folds(train, test, (gram, right), sure, (weighted @ along, weighted @ alone))

    def allowed(self, chosen: Sequence[int]) -> bool:
        """Whether no candidate stands twice in a set."""
        labels = [self.found.choices[i].candidate.label for i in chosen]
        return len(set(labels)) == len(labels)

    def search(self, most: int, exhaustive: int = 2, without: AbstractSet[str] = frozenset()) -> list[Scored]:
        """The best set of each size from 0 to `most`; sizes up to `exhaustive` try every set.

        without: labels of candidates that are left out.
        """
        open_to = [i for i, c in enumerate(self.found.choices) if c.candidate.label not in without]
        best = [self.score([()])[0]]
        beam: list[Scored] = []
        for size in range(1, most + 1):
            if size <= exhaustive:
                sets = [s for s in combinations(open_to, size) if self.allowed(s)]
            else:
                sets = sorted(
                    {tuple(sorted((*b.chosen, i))) for b in beam for i in open_to if self.allowed((*b.chosen, i))}
                )
            scored = sorted(self.score(sets), key=lambda s: -s.gain)
            beam = scored[:BEAM]
            if not beam or not np.isfinite(beam[0].gain):
                break
            best.append(beam[0])
        return best


def _distances(now: Array, scale: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Bounds as steps from now in usual sizes; a negative scale turns them round."""
    sides = np.array([(low - now) / scale, (high - now) / scale])
    return sides.min(axis=0), sides.max(axis=0)
