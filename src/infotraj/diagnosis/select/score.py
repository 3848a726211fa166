"""How probable a set of effects is, and what it predicts of flights that it has not seen, from sums alone.

For Gaussian noise, spikes and slabs the probability of the data is a closed form, with every number integrated out
(marginal likelihood; MacKay 1992). It says which set explains the flights beside a file as wrong as it is: a number
that is out of line with the file costs, a number of an effect does not. What each flight's data are worth after the
others have been seen (Geisser and Eddy 1979) does not: there the file number has been learned, however far off it is.
So the marginal likelihood chooses, and prediction of flights that were not fitted judges what it chose.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np
from numpy.typing import NDArray
from scipy import special

from infotraj.diagnosis.linear.sums import Sums
from infotraj.diagnosis.select.bounded import PASSES, bounded, densities
from infotraj.diagnosis.select.prior import SLAB
from infotraj.rotations import Array

BEAM = 12
_HEAVY = 1e12  # times its own weight: what is known of the numbers holds them where they are
_HALVINGS = 20  # of the logarithm of that weight
_OFF = 2.0  # standard deviations that a file number is off by at most
_DAY = 3.0  # standard deviations by which flights of one day differ from what is known in any one way


@dataclass(frozen=True)
class Choice:
    """One linearisation of an effect: its name with what is fixed, its columns, and its price in nats."""

    label: str
    columns: tuple[int, ...]
    price: float


@dataclass(frozen=True)
class Solution:
    """A set of choices, its score (nats, prices taken off), and its numbers.

    theta (p,): usual sizes from absent, file numbers too; each (folds, p): the same fitted without each fold.
    """

    chosen: tuple[int, ...]
    score: float
    theta: Array
    each: Array


class Scorer:
    """Scores sets of choices on the sums of a model without any of them.

    kept: columns of effects that stay (slab); prior (p, p): covariance of the numbers that are not chosen (spikes), 0
    where there is none; low, high (p,): bounds in usual sizes from absent; given (p,): numbers that are in the sums
    already, and in every solution; scatter (p,): what every number differs by from flight to flight; slab (p,):
    deviation of a number that is chosen, the usual one where not given; lowest (p,): lower bounds of numbers that are
    not chosen, where they are others.
    """

    def __init__(
        self,
        sums: Sums,
        choices: Sequence[Choice],
        kept: Sequence[int],
        prior: Array,
        low: Array,
        high: Array,
        given: Array | None = None,
        scatter: Array | None = None,
        slab: Array | None = None,
        lowest: Array | None = None,
    ) -> None:
        self.slab = np.full(sums.width, SLAB) if slab is None else slab
        self.choices = tuple(choices)
        self.given = np.zeros(sums.width) if given is None else given
        self.kept, self.prior = np.array(kept, dtype=int), prior
        self.spike = np.sqrt(np.diag(prior))
        self.correlated = np.count_nonzero(prior) > np.count_nonzero(self.spike)
        self.low, self.high, self.lowest = low, high, low if lowest is None else lowest
        folds = sums.by_fold
        if scatter is not None and len(folds) > 1 and np.array_equal(sums.fold, sums.flight):
            folds = np.array([diluted(f, scatter) for f in folds])
        every = folds.sum(axis=0)
        self.parts = [every, *(every - f for f in folds)]
        self._reduce()

    def _reduce(self) -> None:
        """Integrates what every set shares: file numbers under their spikes, and the effects that stay."""
        file = np.flatnonzero(self.spike > 0)
        self.shared = np.concatenate([self.kept, file])
        covariance = np.zeros((len(self.shared), len(self.shared)))
        k = len(self.kept)
        covariance[:k, :k] = SLAB**2 * np.eye(k)
        covariance[k:, k:] = self.prior[np.ix_(file, file)]
        self.precision = _inverse(covariance)
        self.reduced = _reduced(self.parts[0], self.shared, self.precision)
        products = np.ascontiguousarray(self.reduced.gram), np.ascontiguousarray(self.reduced.right)
        self._numbers = (*products, self.slab.astype(float), self.low.astype(float), self.high.astype(float))
        self._of_choice = [tuple(c.columns) for c in self.choices]
        self._prices = [c.price for c in self.choices]

    def scores(self, sets: Sequence[tuple[int, ...]]) -> Array:
        """Score of each set, (n,), nats: log marginal likelihood less prices, up to a constant of the data.

        Numbers that a fit drives beyond a bound are held there; -inf where none is left free, or columns are the same.
        """
        columns = [self._columns(s) for s in sets]
        starts = np.cumsum([0, *map(len, columns)])
        index = np.fromiter(chain.from_iterable(columns), dtype=np.int64, count=int(starts[-1]))
        prices = np.array([sum(self._prices[i] for i in s) for s in sets])
        found = densities(*self._numbers, index, starts)
        return self.reduced.known + found - prices

    def solution(self, chosen: tuple[int, ...]) -> Solution:
        """The numbers of one set, on all folds and without each; those beyond a bound stay at it, the file's too."""
        columns = np.array(self._columns(chosen), dtype=int)
        found = np.array([self._bounded(part, columns) for part in self.parts]) + self.given
        return Solution(tuple(chosen), float(self.scores([tuple(chosen)])[0]), found[0], found[1:])

    def _bounded(self, part: Array, columns: NDArray) -> Array:
        """Numbers (p,) of a set of columns for one part of the flights, within their bounds."""
        b, gram, prior = part[0, 1:], part[1:, 1:], self._with_slabs(columns)
        low = self.lowest.copy()
        low[columns] = self.low[columns]
        free = np.diag(prior) > 0
        theta = np.zeros(len(b))
        for _ in range(PASSES):
            precision = _inverse(prior[np.ix_(free, free)])
            theta[free] = 0.0
            theta[free] = _solve(gram[np.ix_(free, free)] + precision, (b - gram @ theta)[free])
            beyond = free & ((theta < low) | (theta > self.high))
            theta = np.clip(theta, low, self.high, where=free, out=theta)
            if not beyond.any():
                break
            free &= ~beyond
        return theta

    def beside(self, chosen: tuple[int, ...], near: Array, mine: Sequence[int] = ()) -> Array:
        """Numbers (folds, p) of a set of choices without each fold, beside a file that could be.

        No file number is further off than files are, or than in `near` (folds, p): what an effect leaves is not taken
        up by numbers that no file has. mine: columns of that effect, whose numbers in `near` are none of a file.
        """
        columns = np.array(self._columns(chosen), dtype=int)
        if self.correlated:
            return np.array([self._beside_known(part, columns, mine) for part in self.parts[1:]]) + self.given
        near = near.copy()
        near[:, list(mine)] = self.given[list(mine)]
        bound = self._bound_values(columns)
        prior = self._with_slabs(columns)
        variance = np.diag(prior)
        file = (self.spike > 0) & ~np.isin(np.arange(len(variance)), [*columns, *self.kept])
        out = np.zeros_like(near)
        for k, part in enumerate(self.parts[1:]):
            b, gram = part[0, 1:], part[1:, 1:]
            most = np.where(file, np.maximum(_OFF * self.spike, np.abs(near[k] - self.given)), np.inf)
            held = dict(bound)
            theta = np.zeros(len(b))
            for _ in range(PASSES):
                free = np.array([c for c in np.flatnonzero(variance > 0) if c not in held], dtype=int)
                theta[:] = 0.0
                theta[list(held)] = list(held.values())
                left = b - gram @ theta
                theta[free] = _solve(gram[np.ix_(free, free)] + _inverse(prior[np.ix_(free, free)]), left[free])
                beyond = np.flatnonzero(np.abs(theta) > most * (1.0 + 1e-9))
                if not len(beyond):
                    break
                held |= {int(c): float(np.sign(theta[c]) * most[c]) for c in beyond}
            out[k] = np.clip(theta, -most, most) + self.given
        return out

    def _beside_known(self, part: Array, columns: NDArray, mine: Sequence[int]) -> Array:
        """The same (p,) for one part where numbers are known together: near where they are with `mine` as well.

        They may be off from there by `_OFF` standard deviations in all (Mahalanobis' distance), along the one direction
        that makes up for `mine` as well as along any other. A bound on how unlikely they are themselves would leave
        that direction all that the others do not use. Numbers that are nearer are what they are without it;
        others are held about there, as tightly as it takes.
        """
        near = self._split(part, np.unique([*columns, *mine]).astype(int))[1]
        file, known, gram = self._together(part, columns)
        right, count, at = part[0, 1:][np.concatenate([file, columns])], len(file), known @ near[file]

        def held(weight: float) -> tuple[float, Array]:
            inside, wanted = gram.copy(), right.copy()
            inside[:count, :count] += (weight - 1.0) * known
            wanted[:count] += (weight - 1.0) * at
            found = _solve(inside, wanted)
            off = found[:count] - near[file]
            return float(off @ known @ off), found

        low, high = 1.0, _HEAVY
        distance, found = held(low)
        if distance > _OFF**2:
            found = held(high)[1]
            for _ in range(_HALVINGS):
                weight = np.sqrt(low * high)
                distance, tried = held(weight)
                low, high, found = (weight, high, found) if distance > _OFF**2 else (low, weight, tried)
        out = np.zeros(len(self.spike))
        out[file] = found[:count]
        out[columns] += found[count:]
        return out

    def of_a_day(self, chosen: tuple[int, ...]) -> Array:
        """Numbers (p,) of a set beside what is known together, as near these flights as one day's numbers may be.

        What is known is split into ways to differ that the flights tell independently of one another. Along none of
        them is it further off than `_DAY` standard deviations, nor in all than as many ways make as seldom.
        """
        columns, file = np.array(self._columns(chosen), dtype=int), np.flatnonzero(self.spike > 0)
        right, gram = self.parts[0][0, 1:], self.parts[0][1:, 1:]
        across, own = gram[np.ix_(file, columns)], gram[np.ix_(columns, columns)] + np.eye(len(columns)) / SLAB**2
        along = np.linalg.solve(own, across.T)
        size = self.spike[file]
        spread, axes = np.linalg.eigh(self.prior[np.ix_(file, file)] / np.outer(size, size))
        way = size[:, None] * axes * np.sqrt(np.maximum(spread, 0.0))
        told, turned = np.linalg.eigh(way.T @ (gram[np.ix_(file, file)] - across @ along) @ way)
        pull = turned.T @ way.T @ (right[file] - right[columns] @ along)
        off = np.clip(pull / (1.0 + np.maximum(told, 0.0)), -_DAY, _DAY)
        farthest = np.sqrt(special.chdtri(max(int(np.sum(told > 1.0)), 1), special.chdtrc(1, _DAY**2)))
        off *= min(1.0, farthest / max(float(np.linalg.norm(off)), 1e-12))
        out = np.zeros(len(self.spike))
        out[file] = way @ turned @ off
        out[columns] += np.linalg.solve(own, right[columns] - across.T @ out[file])
        return out + self.given

    def _split(self, part: Array, columns: NDArray) -> tuple[Array, Array]:
        """What is new in these columns (p,), and what the numbers that are known are off by beside it (p,)."""
        file, _, gram = self._together(part, columns)
        found = _solve(gram, part[0, 1:][np.concatenate([file, columns])])
        new, beside = np.zeros(len(self.spike)), np.zeros(len(self.spike))
        new[columns], beside[file] = found[len(file) :], found[: len(file)]
        return new, beside

    def _together(self, part: Array, columns: NDArray) -> tuple[NDArray, Array, Array]:
        """Columns (f,) of what is known, how exactly (f, f), and products (f + c, f + c) with it, then of `columns`."""
        file = np.flatnonzero(self.spike > 0)
        both = np.concatenate([file, columns])
        known = _inverse(self.prior[np.ix_(file, file)])
        precision = np.eye(len(both)) / SLAB**2
        precision[: len(file), : len(file)] = known
        return file, known, part[1:, 1:][np.ix_(both, both)] + precision

    def search(
        self, most: int, open_to: Iterable[int], start: tuple[int, ...] = (), exhaustive: int = 2, beam: int = BEAM
    ) -> Solution:
        """The best set: all sets of up to `exhaustive` further choices, then a beam, then exchanges."""
        open_to = list(open_to)
        best = (float(self.scores([start])[0]), start)
        kept = [best]
        for size in range(1, most + 1):
            if size <= exhaustive:
                sets = [(*start, *s) for s in combinations(open_to, size)]
            else:
                sets = sorted({tuple(sorted((*s, i))) for _, s in kept for i in open_to if i not in s})
            sets = [s for s in sets if self.allowed(s)]
            if not sets:
                break
            found = self.scores(sets)
            order = np.argsort(-found)[:beam]
            kept = [(float(found[k]), sets[k]) for k in order]
            if kept[0][0] > best[0]:
                best = kept[0]
            elif size > exhaustive:
                break
        return self.solution(self._polished(best, open_to))

    def _polished(self, best: tuple[float, tuple[int, ...]], open_to: Sequence[int]) -> tuple[int, ...]:
        """The set after removals and exchanges, of one or two for one, for as long as they pay."""
        value, now = best
        while True:
            sets = []
            for size in (1, 2):
                for out in combinations(now, size):
                    rest = tuple(i for i in now if i not in out)
                    sets += [rest, *((*rest, i) for i in open_to if i not in now)]
            sets = [s for s in sets if self.allowed(s)]
            found = self.scores(sets) if sets else np.zeros(0)
            if not len(found) or found.max() <= value + 1e-9:
                return tuple(sorted(now))
            value, now = float(found.max()), sets[int(np.argmax(found))]

    def allowed(self, chosen: Sequence[int]) -> bool:
        """Whether no effect stands twice in a set."""
        labels = [self.choices[i].label for i in chosen]
        return len(set(labels)) == len(labels)

    def covariance(self, chosen: tuple[int, ...]) -> tuple[NDArray, Array]:
        """Columns (q,) that are free with a set, file numbers too, and the covariance (q, q) of their numbers."""
        columns = np.array(self._columns(chosen), dtype=int)
        prior = self._with_slabs(columns)
        bound = self._bound_values(columns)
        free = np.array([c for c in np.flatnonzero(np.diag(prior) > 0) if c not in bound], dtype=int)
        gram = self.parts[0][1:, 1:][np.ix_(free, free)] + _inverse(prior[np.ix_(free, free)])
        size = 1.0 / np.sqrt(np.diag(gram))
        return free, np.linalg.inv(gram * np.outer(size, size)) * np.outer(size, size)

    def apart(self, chosen: tuple[int, ...]) -> tuple[Array, Array, Array]:
        """What is new in the numbers of a set, apart from what they could be without it.

        (p,) on all folds, (folds, p) without each, and its standard deviation (p,), usual sizes.
        """
        columns = np.array(self._columns(chosen), dtype=int)
        new = np.array([self._split(part, columns)[0] for part in self.parts])
        file, _, gram = self._together(self.parts[0], columns)
        error = np.zeros(len(self.spike))
        error[columns] = np.sqrt(np.diag(_solve(gram, np.eye(len(gram))))[len(file) :])
        new = np.clip(new, self.low, self.high)
        return new[0], new[1:], error

    def _with_slabs(self, columns: NDArray) -> Array:
        """Prior covariance (p, p) of all numbers: one with both a spike and a slab has the sum of their variances."""
        prior = self.prior.copy()
        prior[columns, columns] += self.slab[columns] ** 2
        prior[self.kept, self.kept] += SLAB**2
        return prior

    def _columns(self, chosen: Sequence[int]) -> tuple[int, ...]:
        return tuple(chain.from_iterable(self._of_choice[i] for i in chosen))

    def _bound_values(self, columns: NDArray) -> dict[int, float]:
        """Columns whose numbers a fit drives beyond a bound, and the bound at which they are held."""
        held, at = bounded(*self._numbers, np.ascontiguousarray(columns, dtype=np.int64))
        return {int(c): float(x) for c, x in zip(columns[held], at[held], strict=True)}


@dataclass(frozen=True)
class _Reduced:
    """Products of the columns after shared numbers have been integrated out; known: log density without any other."""

    gram: Array
    right: Array
    known: float


def _reduced(part: Array, shared: NDArray, precision: Array) -> _Reduced:
    square, right, gram = part[0, 0], part[0, 1:], part[1:, 1:]
    if not len(shared):
        return _Reduced(gram, right, -0.5 * square)
    inner = gram[np.ix_(shared, shared)] + precision
    both = _solve(inner, np.column_stack([gram[shared], right[shared]]))
    along, alone = both[:, :-1], both[:, -1]
    # Numbers of a file that is nearly exact and of an effect differ by many powers of ten.
    root = np.sqrt(np.outer(np.diag(precision), np.diag(precision)))
    size = np.linalg.slogdet(inner / root)[1] - np.linalg.slogdet(precision / root)[1]
    known = -0.5 * square + 0.5 * (right[shared] @ alone - size)
    return _Reduced(gram - gram[:, shared] @ along, right - gram[:, shared] @ alone, float(known))


def diluted(part: Array, scatter: Array) -> Array:
    """Products of a flight, (1 + p, 1 + p), after its own deviations from common numbers have been integrated out."""
    along = part[:, 1:] * scatter
    inside = np.eye(len(scatter)) + part[1:, 1:] * np.outer(scatter, scatter)
    return part - along @ np.linalg.solve(inside, along.T)


def _inverse(covariance: Array) -> Array:
    """Precision of a positive definite covariance, which is scaled to a diagonal of ones."""
    if np.count_nonzero(covariance) == len(covariance):
        return np.diag(1.0 / np.diag(covariance))
    size = 1.0 / np.sqrt(np.diag(covariance))
    scaled = covariance * np.outer(size, size)
    return np.linalg.inv(scaled) * np.outer(size, size)


def _solve(gram: Array, right: Array) -> Array:
    """Solves a positive definite system, scaled to a diagonal of ones."""
    size = 1.0 / np.sqrt(np.diag(gram))
    solved = np.linalg.solve(gram * np.outer(size, size), (size * right.T).T)
    return (size * solved.T).T
