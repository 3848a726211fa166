"""Sums over blocks of flights that carry everything a linear fit needs: S'S, S'r, r'r and the time covered.

From here on no flight is read again. Fitting any subset of columns on any blocks and testing it on any others is one
small solve (the normal equations of weighted least squares; the residual and the columns are whitened by one filter).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from infotraj.diagnosis.lonely import fitted, halves, lonely
from infotraj.diagnosis.plain import Plain
from infotraj.diagnosis.residual import FlightSamples
from infotraj.diagnosis.whitened import Blocks, Noise
from infotraj.rotations import Array

WINDOW = 0.05  # s: unit of time of a rise; what matters to a vehicle's motion lasts longer
RIDGE = 1e-9  # of each column's own sum of squares: keeps collinear columns solvable, changes nothing else


@dataclass(frozen=True)
class Sums:
    """gram (axes, blocks, p, p), right (axes, blocks, p), square and windows (axes, blocks); axes: their names.

    windows: time in units of WINDOW. A squared error divided by it is in units of the floor of a mean over that long,
    whatever the rate at which the sensors were sampled. plain: the same sums over all flights, not whitened.
    """

    gram: Array
    right: Array
    square: Array
    windows: Array
    axes: tuple[str, ...]
    fold: Array
    flight: Array
    plain: Plain | None = None

    def total(self) -> tuple[Array, Array, Array]:
        """Sums over the axes: (blocks, p, p), (blocks, p), (blocks,)."""
        return self.gram.sum(axis=0), self.right.sum(axis=0), self.square.sum(axis=0)

    def shifted(self, theta: Array) -> Sums:
        """The same sums after the residual has become r - S theta."""
        along = np.einsum("abij,j->abi", self.gram, theta)
        square = self.square - 2 * self.right @ theta + along @ theta
        plain = None if self.plain is None else self.plain.shifted(theta)
        return replace(self, right=self.right - along, square=square, plain=plain)

    def restricted(self, columns: Sequence[int]) -> Sums:
        """The sums of some columns."""
        c = np.asarray(columns, dtype=int)
        return Sums(
            self.gram[:, :, c[:, None], c],
            self.right[:, :, c],
            self.square,
            self.windows,
            self.axes,
            self.fold,
            self.flight,
        )


def block_sums(samples: Sequence[FlightSamples], noise: Noise, blocks: Blocks, joint: Sequence[list[Array]]) -> Sums:
    """Sums of whitened residual and columns, one (m, 3, 1 + p) a channel of a flight, the residual first."""
    every = _products(samples, blocks, joint, joint)
    return _split(samples, noise, blocks, every)


def extended_sums(
    samples: Sequence[FlightSamples],
    noise: Noise,
    blocks: Blocks,
    own: Sequence[list[Array]],
    others: Sequence[list[Array]],
    known: Array,
) -> Sums:
    """The same for columns of which most are known: `own` (m, 3, 1 + q), the residual first, then `others` (m, 3, p).

    known (axes, blocks, p, p): products of the others, from `products`. Only what is new is multiplied.
    """
    within = _products(samples, blocks, own, own)
    across = _products(samples, blocks, own, others)
    top = np.concatenate([within, across], axis=3)
    bottom = np.concatenate([across.transpose(0, 1, 3, 2), known], axis=3)
    return _split(samples, noise, blocks, np.concatenate([top, bottom], axis=2))


def products(samples: Sequence[FlightSamples], blocks: Blocks, columns: Sequence[list[Array]]) -> Array:
    """S'S of every axis and block, (axes, blocks, p, p), of whitened columns (m, 3, p) a channel of a flight."""
    return _products(samples, blocks, columns, columns)


def _axes(samples: Sequence[FlightSamples]) -> list[str]:
    names: list[str] = []
    for s in samples:
        names += [a for c in s.channels for a in c.axes if a not in names]
    return names


def _products(samples, blocks: Blocks, left: Sequence[list[Array]], right: Sequence[list[Array]]) -> Array:
    names = _axes(samples)
    out = np.zeros((len(names), blocks.count, left[0][0].shape[2], right[0][0].shape[2]))
    for number, s in enumerate(samples):
        for place, channel in enumerate(s.channels):
            block = blocks.of_sample[number][place]
            edges = np.concatenate([[0], np.flatnonzero(np.diff(block)) + 1, [len(block)]])
            for i, axis in enumerate(channel.axes):
                a = names.index(axis)
                x, of_x = _moving(left[number][place][:, i])
                y, of_y = (x, of_x) if right is left else _moving(right[number][place][:, i])
                # Most effects leave most axes alone: their columns of zeros are not multiplied.
                for start, stop in pairwise(edges):
                    out[a, block[start], of_x[:, None], of_y] += x[start:stop].T @ y[start:stop]
    return out


def _moving(x: Array) -> tuple[Array, Array]:
    """The columns of x that are not all zero, contiguous, and their numbers."""
    used = np.flatnonzero(np.any(x != 0.0, axis=0))
    return np.ascontiguousarray(x[:, used]), used


def _split(samples, noise: Noise, blocks: Blocks, every: Array) -> Sums:
    names = _axes(samples)
    windows = np.zeros((len(names), blocks.count))
    for number, s in enumerate(samples):
        for place, channel in enumerate(s.channels):
            for i, axis in enumerate(channel.axes):
                used = noise[channel.key][i].used(channel.run)
                count = np.bincount(blocks.of_sample[number][place], used, minlength=blocks.count)
                windows[names.index(axis)] += count * channel.step / WINDOW
    return Sums(
        every[:, :, 1:, 1:],
        every[:, :, 0, 1:],
        every[:, :, 0, 0],
        windows,
        tuple(names),
        blocks.fold,
        blocks.flight,
    )


def solve(gram: Array, right: Array) -> Array:
    """Least-squares parameters for (..., p, p) and (..., p), ridged by 1e-9 of each column's own size."""
    diagonal = np.einsum("...ii->...i", gram)
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    scaled = gram / (size[..., :, None] * size[..., None, :])
    eye = np.eye(gram.shape[-1])
    return np.linalg.solve(scaled + RIDGE * eye, (right / size)[..., None])[..., 0] / size


def held_out(sums: Sums, columns: Sequence[int] | None = None) -> tuple[Array, Array]:
    """Held-out squared error per axis and block (axes, blocks), and the numbers each block is tested with (blocks, p).

    They are fitted on the other folds; see `lonely` for what shows in one fold only.
    """
    part = sums if columns is None else sums.restricted(columns)
    gram, right, _ = part.total()
    theta = np.zeros(right.shape)
    if right.shape[1] == 0:
        return part.square.copy(), theta
    folds, half = np.unique(part.fold), halves(part.fold)
    alone = lonely(np.array([gram[part.fold == f].sum(axis=0) for f in folds]))
    for f, few in zip(folds, alone, strict=True):
        out = part.fold == f
        rest = gram[~out].sum(axis=0), right[~out].sum(axis=0)
        if not few.any():
            theta[out] = solve(*rest)
            continue
        for h in (0, 1):
            other = out & (half != h)
            tested = np.diag(gram[out & (half == h)].sum(axis=0))
            more = gram[other].sum(axis=0), right[other].sum(axis=0)
            theta[out & (half == h)] = fitted(*rest, *more, few, tested, RIDGE)
    along = np.einsum("abij,bj->abi", part.gram, theta)
    return part.square + np.einsum("abi,bi->ab", along - 2 * part.right, theta), theta
