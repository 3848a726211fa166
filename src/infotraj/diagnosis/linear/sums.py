"""Sums over blocks of flights that carry everything a linear model needs: products of the residual and all columns.

From here on no flight is read again. Fitting any set of columns on any blocks and testing it on any others is one small
solve. Beside the weighted sums stand plain ones, of slow coefficients as they are: they say how large an error is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from infotraj.diagnosis.noise.spectra import Spectrum, Weights
from infotraj.rotations import Array

WINDOW = 0.05  # s: unit of time of a rise; what matters to a vehicle's motion lasts longer
BLOCK = 2.0  # s
_MOST_BLOCKS = 96


@dataclass(frozen=True)
class Sums:
    """Products of `made` (see there) after the residual r has become r - S theta; theta (p,).

    axes: names; fold, flight (blocks,): the group that is held out together, and the flight.
    """

    made: _OfSpectra
    axes: tuple[str, ...]
    fold: NDArray
    flight: NDArray
    theta: Array

    @property
    def width(self) -> int:
        """The number of columns beside the residual."""
        return len(self.theta)

    @property
    def slow(self) -> Array:
        """How many slow coefficients there are, (axes, folds)."""
        return self.made.slow

    @property
    def windows(self) -> Array:
        """Time of each block on each axis, (axes, blocks), in units of WINDOW."""
        return self.made.windows

    @property
    def noise(self) -> Array:
        """Weighted squared error (axes,) that the richest model leaves: what is expected of noise alone."""
        return self.made.noise

    @cached_property
    def by_fold(self) -> Array:
        """Products over all axes, (folds, 1 + p, 1 + p)."""
        return self._shifted(self.made.folds)

    @cached_property
    def total(self) -> Array:
        """Products over all axes and folds, (1 + p, 1 + p)."""
        return np.asarray(self.by_fold.sum(axis=0))

    @cached_property
    def gram(self) -> Array:
        """Weighted products, (axes, blocks, 1 + p, 1 + p)."""
        return self._shifted(self.made.gram)

    @cached_property
    def plain(self) -> Array:
        """Products of slow coefficients as they are, (axes, folds, 1 + p, 1 + p)."""
        return self._shifted(self.made.plain)

    @cached_property
    def believed(self) -> Array:
        """The same, each times the coherence of its band."""
        return self._shifted(self.made.believed)

    def shifted(self, theta: Array) -> Sums:
        """The same sums after the residual has become r - S theta."""
        return replace(self, theta=self.theta + theta)

    def whole_error(self, theta: Array) -> float:
        """Weighted squared error over all axes and blocks after r - S theta; theta (p,)."""
        along = np.concatenate([[1.0], -theta])
        return float(along @ self.total @ along)

    def error(self, theta: Array) -> Array:
        """Weighted squared error (axes, blocks) after r - S theta; theta (p,), or (blocks, p): each block its own."""
        return _squares(self.gram, np.broadcast_to(theta, (self.gram.shape[1], self.width)))

    def plain_error(self, theta: Array) -> Array:
        """Plain mean squared error (axes,) after r - S theta; theta (folds, p): each fold its own."""
        return self._mean_square(self.plain, theta)

    def believed_error(self, theta: Array) -> Array:
        """The same of what goes with the motion at all: frequencies weigh by their coherence."""
        return self._mean_square(self.believed, theta)

    def _mean_square(self, products: Array, theta: Array) -> Array:
        return _squares(products, theta).sum(axis=1) / np.maximum(self.slow.sum(axis=1), 1)

    def _shifted(self, products: Array) -> Array:
        return _shifted(products, self.theta) if self.theta.any() else products


def _shifted(products: Array, theta: Array) -> Array:
    """Products (..., 1 + p, 1 + p) after the residual has become r - S theta (p,)."""
    out = products.copy()
    right = products[..., 1:, 0] - products[..., 1:, 1:] @ theta
    out[..., 1:, 0] = out[..., 0, 1:] = right
    out[..., 0, 0] -= (products[..., 1:, 0] + right) @ theta
    return out


def _squares(products: Array, theta: Array) -> Array:
    """Squares (a, b) of r - S theta from products (a, b, 1 + p, 1 + p), theta (b, p)."""
    along = np.concatenate([np.ones((len(theta), 1)), -theta], axis=1)[:, :, None]
    return np.matmul(np.matmul(products, along).transpose(0, 1, 3, 2), along)[..., 0, 0]


@dataclass(frozen=True)
class Blocks:
    """Cuts each flight's time into blocks of about 2 s, and says which are held out together.

    edges: by flight, s; first: number of each flight's first block; flight, fold (blocks,).
    """

    edges: tuple[Array, ...]
    first: tuple[int, ...]
    flight: NDArray
    fold: NDArray

    def of(self, s: Spectrum) -> NDArray:
        """The block of each coefficient of a spectrum."""
        return self.at(s.flight, s.time)

    def at(self, flight: int, time: Array) -> NDArray:
        """The block of each time (s) of a flight."""
        return self.first[flight] + np.searchsorted(self.edges[flight], time, side="right")


def blocks(found: Sequence[Spectrum]) -> Blocks:
    """Blocks of the time that is used. Folds are flights; of one flight alone, five parts of it one after another."""
    flights = 1 + max(s.flight for s in found)
    times = [np.concatenate([s.time for s in found if s.flight == k] or [np.zeros(0)]) for k in range(flights)]
    spans = [float(np.ptp(t)) if len(t) else 0.0 for t in times]
    length = max(BLOCK, sum(spans) / max(_MOST_BLOCKS - flights, 8))
    edges: list[Array] = []
    first: list[int] = []
    owner: list[int] = []
    for k, (t, span) in enumerate(zip(times, spans, strict=True)):
        count = max(1, round(span / length))
        begin = float(t.min()) if len(t) else 0.0
        edges.append(begin + span / count * np.arange(1.0, count))
        first.append(len(owner))
        owner += [k] * count
    flight = np.array(owner)
    fold = flight.copy()
    if flights == 1:
        fold = (np.arange(len(flight)) * min(5, len(flight))) // len(flight)
    return Blocks(tuple(edges), tuple(first), flight, fold)


class _OfSpectra:
    """Products of the residual and all columns, the residual first, of spectra under weights.

    Those by block and axis are made when they are first asked for: no search does. folds (folds, 1 + p, 1 + p):
    weighted, over all axes; gram (axes, blocks, 1 + p, 1 + p): weighted; plain (axes, folds, 1 + p, 1 + p): of slow
    coefficients, without weights; believed: the same, each times the coherence of its band.
    like: earlier ones under the same weights, whose columns `old` stand at the places `same` here, (q,) each, the
    residual counted as the first: their products are not made again.
    """

    def __init__(
        self,
        found: Sequence[Spectrum],
        weights: Weights,
        cut: Blocks,
        like: _OfSpectra | None = None,
        same: Sequence[int] = (),
        old: Sequence[int] = (),
    ) -> None:
        self._found, self._weights, self._cut = found, weights, cut
        self._width = found[0].values.shape[1]
        self._folds = np.unique(cut.fold)
        self.folds = self._by_fold(like, np.array(same, dtype=int), np.array(old, dtype=int))

    def _by_fold(self, like: _OfSpectra | None, same: NDArray, old: NDArray) -> Array:
        out = np.zeros((len(self._folds), self._width, self._width))
        if like is not None:
            out[:, same[:, None], same] = like.folds[:, old[:, None], old]
        fresh = np.setdiff1d(np.arange(self._width), same)
        for number, s, moves in self._moving():
            new = np.isin(moves, fresh)
            if not new.any():
                continue
            x = s.values[:, moves] if len(moves) < self._width else s.values
            weight = self._weights.of(number, s)
            fold = np.searchsorted(self._folds, self._cut.fold[self._cut.of(s)])
            for f in np.unique(fold):
                own = x if len(np.unique(fold)) == 1 else x[fold == f]
                w = weight if len(own) == len(weight) else weight[fold == f]
                out[f][np.ix_(moves[new], moves)] += (own[:, new] * w[:, None]).T @ own
        out[:, same[:, None], fresh] = np.swapaxes(out[:, fresh[:, None], same], 1, 2)
        return out

    @cached_property
    def gram(self) -> Array:
        axes, cut = self._weights.axes, self._cut
        out = np.zeros((len(axes), len(cut.flight), self._width, self._width))
        for number, s, moves in self._moving():
            x = s.values[:, moves] * np.sqrt(self._weights.of(number, s))[:, None]
            a, block, at = axes.index(s.axis), cut.of(s), np.ix_(moves, moves)
            for first, stop in _stretches(block):
                out[a, block[first]][at] += x[first:stop].T @ x[first:stop]
        return out

    @cached_property
    def plain(self) -> Array:
        return self._slow(lambda a, s: np.ones(len(s.band)))

    @cached_property
    def believed(self) -> Array:
        return self._slow(lambda a, s: self._weights.coherence[a, s.band])

    def _slow(self, share: Callable[[int, Spectrum], Array]) -> Array:
        """Products (axes, folds, 1 + p, 1 + p) of slow coefficients, each times its share, (n,)."""
        axes = self._weights.axes
        out = np.zeros((len(axes), len(self._folds), self._width, self._width))
        for _, s, moves in self._moving():
            a, fold = axes.index(s.axis), np.searchsorted(self._folds, self._cut.fold[self._cut.of(s)])
            weight = share(a, s)
            if not weight.any():
                continue
            for f in np.unique(fold):
                below = (fold == f) & (s.band < self._weights.slow(s.axis))
                part = s.values[np.ix_(below, moves)] * np.sqrt(weight[below])[:, None]
                out[a, f][np.ix_(moves, moves)] += part.T @ part
        return out

    @cached_property
    def slow(self) -> Array:
        """How many slow coefficients there are, (axes, folds)."""
        axes = self._weights.axes
        out = np.zeros((len(axes), len(self._folds)))
        for s in self._found:
            fold = np.searchsorted(self._folds, self._cut.fold[self._cut.of(s)])
            below = fold[s.band < self._weights.slow(s.axis)]
            out[axes.index(s.axis)] += np.bincount(below, minlength=len(self._folds))
        return out

    @cached_property
    def noise(self) -> Array:
        """Weighted squares (axes,) of noise alone."""
        axes = self._weights.axes
        out = np.zeros(len(axes))
        for number, s in enumerate(self._found):
            a = axes.index(s.axis)
            out[a] += self._weights.of(number, s) @ self._weights.noise[a, s.band]
        return out

    @cached_property
    def windows(self) -> Array:
        """Time of each block on each axis, (axes, blocks), in units of WINDOW."""
        axes, cut = self._weights.axes, self._cut
        out = np.zeros((len(axes), len(cut.flight)))
        for s in self._found:
            block = cut.of(s)
            seconds = np.diff(np.unique(s.time)).min(initial=np.inf)
            for first, stop in _stretches(block):
                lasted = len(np.unique(s.time[first:stop])) * (seconds if np.isfinite(seconds) else 1.0)
                out[axes.index(s.axis), block[first]] += lasted / WINDOW
        return out

    def _moving(self) -> Iterator[tuple[int, Spectrum, NDArray]]:
        """Each spectrum that has coefficients, its number, and the columns that are not zero on its axis."""
        for number, s in enumerate(self._found):
            if len(s.band):
                yield number, s, np.flatnonzero(s.values.any(axis=0))


def gathered(
    found: Sequence[Spectrum],
    weights: Weights,
    cut: Blocks,
    like: Sums | None = None,
    same: Sequence[int] = (),
    old: Sequence[int] = (),
) -> Sums:
    """The sums of all spectra under these weights.

    like: sums under the same weights, whose columns `old` are the columns `same` here, both counted from the residual.
    """
    before = like.made if like is not None else None
    made = _OfSpectra(found, weights, cut, before, *((same, old) if before is not None else ()))
    return Sums(made, weights.axes, cut.fold, cut.flight, np.zeros(found[0].values.shape[1] - 1))


def _stretches(block: NDArray) -> Iterator[tuple[int, int]]:
    """First row of each block and the one after its last: a spectrum's rows lie in the order of time."""
    edges = [0, *(1 + np.flatnonzero(np.diff(block))), len(block)] if len(block) else []
    return pairwise(edges)
