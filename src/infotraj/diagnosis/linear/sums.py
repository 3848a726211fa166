"""Sums over blocks of flights that carry everything a linear model needs: products of the residual and all columns.

From here on no flight is read again. Fitting any set of columns on any blocks and testing it on any others is one small
solve. Beside the weighted sums stand plain ones, of slow coefficients as they are: they say how large an error is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
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
    """gram (axes, blocks, 1 + p, 1 + p) of weighted coefficients, the residual first; windows (axes, blocks).

    plain (axes, folds, 1 + p, 1 + p): the same, slow coefficients and no weights; believed: each times the coherence of
    its band and no more; slow (axes, folds): how many these are. fold, flight (blocks,): the group that is held out
    together, and the flight. windows: time in units of WINDOW.
    """

    gram: Array
    plain: Array
    believed: Array
    slow: Array
    windows: Array
    axes: tuple[str, ...]
    fold: NDArray
    flight: NDArray

    @property
    def width(self) -> int:
        """The number of columns beside the residual."""
        return self.gram.shape[-1] - 1

    def by_fold(self) -> Array:
        """Products over all axes, (folds, 1 + p, 1 + p)."""
        total = self.gram.sum(axis=0)
        return np.array([total[self.fold == f].sum(axis=0) for f in np.unique(self.fold)])

    def shifted(self, theta: Array) -> Sums:
        """The same sums after the residual has become r - S theta."""
        gram, plain, believed = (_shifted(x, theta) for x in (self.gram, self.plain, self.believed))
        return replace(self, gram=gram, plain=plain, believed=believed)

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


def gathered(found: Sequence[Spectrum], weights: Weights, cut: Blocks) -> Sums:
    """The sums of all spectra under these weights."""
    axes, width = weights.axes, found[0].values.shape[1]
    folds = np.unique(cut.fold)
    gram = np.zeros((len(axes), len(cut.flight), width, width))
    plain, believed = (np.zeros((len(axes), len(folds), width, width)) for _ in range(2))
    slow, windows = np.zeros((len(axes), len(folds))), np.zeros((len(axes), len(cut.flight)))
    silent = {a for a, c in zip(axes, weights.coherence, strict=True) if not c.any()}
    for number, s in enumerate(found):
        a, block = axes.index(s.axis), cut.of(s)
        moves = np.flatnonzero(np.any(s.values != 0.0, axis=0))
        at = np.ix_(moves, moves)
        x = s.weighted(weights.of(number, s))[:, moves]
        seconds = np.diff(np.unique(s.time)).min(initial=np.inf)
        for b in np.unique(block):
            rows = block == b
            gram[a, b][at] += x[rows].T @ x[rows]
            lasted = len(np.unique(s.time[rows])) * (seconds if np.isfinite(seconds) else 1.0)
            windows[a, b] += lasted / WINDOW
        for f, fold in enumerate(folds):
            below = (cut.fold[block] == fold) & (s.band < weights.slow(s.axis))
            part = s.values[np.ix_(below, moves)]
            plain[a, f][at] += part.T @ part
            slow[a, f] += below.sum()
            if s.axis not in silent:
                trusted = part * np.sqrt(weights.coherence[a, s.band[below]])[:, None]
                believed[a, f][at] += trusted.T @ trusted
    return Sums(gram, plain, believed, slow, windows, axes, cut.fold, cut.flight)


def with_residual(sums: Sums, found: Sequence[Spectrum], weights: Weights, cut: Blocks) -> Sums:
    """The same sums where the residual alone is another one, under the same weights: one pass over the columns."""
    products = [x.copy() for x in (sums.gram, sums.plain, sums.believed)]
    for x in products:
        x[..., 0, :] = 0.0
    folds = np.unique(cut.fold)
    for number, s in enumerate(found):
        a, block, residual = sums.axes.index(s.axis), cut.of(s), s.values[:, 0]
        below = residual * (s.band < weights.slow(s.axis))
        each = (weights.of(number, s) * residual, below, below * weights.coherence[a, s.band])
        edges = [0, *(1 + np.flatnonzero(np.diff(block))), len(block)] if len(block) else []
        for first, stop in pairwise(edges):
            b = block[first]
            f = int(np.searchsorted(folds, cut.fold[b]))
            along = s.values[first:stop].T @ np.stack([x[first:stop] for x in each], axis=1)
            for x, place, row in zip(products, (b, f, f), along.T, strict=True):
                x[a, place, 0] += row
    for x in products:
        x[..., :, 0] = x[..., 0, :]
    return replace(sums, gram=products[0], plain=products[1], believed=products[2])
