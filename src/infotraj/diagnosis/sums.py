"""Sums over blocks of flights that carry everything a linear fit needs: S'S, S'r, r'r and the time covered.

From here on no flight is read again. Fitting any subset of columns on any blocks and testing it on any others is one
small solve (the normal equations of weighted least squares; the residual and the columns are whitened by one filter).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from infotraj.diagnosis.residual import FlightSamples
from infotraj.diagnosis.whitened import Blocks, Noise
from infotraj.rotations import Array

WINDOW = 0.05  # s: unit of time of a rise; what matters to a vehicle's motion lasts longer
RIDGE = 1e-9  # of each column's own sum of squares: keeps collinear columns solvable, changes nothing else


@dataclass(frozen=True)
class Sums:
    """gram (axes, blocks, p, p), right (axes, blocks, p), square and windows (axes, blocks); axes: their names.

    windows: time in units of WINDOW. A squared error divided by it is in units of the floor of a mean over that long,
    whatever the rate at which the sensors were sampled.
    """

    gram: Array
    right: Array
    square: Array
    windows: Array
    axes: tuple[str, ...]
    fold: Array
    flight: Array

    def total(self) -> tuple[Array, Array, Array]:
        """Sums over the axes: (blocks, p, p), (blocks, p), (blocks,)."""
        return self.gram.sum(axis=0), self.right.sum(axis=0), self.square.sum(axis=0)

    def shifted(self, theta: Array) -> Sums:
        """The same sums after the residual has become r - S theta."""
        along = np.einsum("abij,j->abi", self.gram, theta)
        square = self.square - 2 * self.right @ theta + along @ theta
        return Sums(self.gram, self.right - along, square, self.windows, self.axes, self.fold, self.flight)

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
    names: list[str] = []
    for s in samples:
        names += [a for c in s.channels for a in c.axes if a not in names]
    p = joint[0][0].shape[2] - 1
    gram = np.zeros((len(names), blocks.count, p, p))
    right = np.zeros((len(names), blocks.count, p))
    square, windows = np.zeros((len(names), blocks.count)), np.zeros((len(names), blocks.count))
    for number, s in enumerate(samples):
        for place, (channel, x) in enumerate(zip(s.channels, joint[number], strict=True)):
            block = blocks.of_sample[number][place]
            edges = np.concatenate([[0], np.flatnonzero(np.diff(block)) + 1, [len(block)]])
            for i, axis in enumerate(channel.axes):
                a = names.index(axis)
                used = noise[channel.key][i].used(channel.run)
                for start, stop in pairwise(edges):
                    part = x[start:stop, i]
                    outer = part.T @ part
                    b = block[start]
                    square[a, b] += outer[0, 0]
                    right[a, b] += outer[1:, 0]
                    gram[a, b] += outer[1:, 1:]
                    windows[a, b] += used[start:stop].sum() * channel.step / WINDOW
    return Sums(gram, right, square, windows, tuple(names), blocks.fold, blocks.flight)


def solve(gram: Array, right: Array) -> Array:
    """Least-squares parameters for (..., p, p) and (..., p), ridged by 1e-9 of each column's own size."""
    diagonal = np.einsum("...ii->...i", gram)
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    scaled = gram / (size[..., :, None] * size[..., None, :])
    eye = np.eye(gram.shape[-1])
    return np.linalg.solve(scaled + RIDGE * eye, (right / size)[..., None])[..., 0] / size


def held_out(sums: Sums, columns: Sequence[int] | None = None) -> tuple[Array, Array]:
    """Held-out squared error per axis and block (axes, blocks), and the parameters of each fold (folds, p)."""
    part = sums if columns is None else sums.restricted(columns)
    gram, right, _ = part.total()
    folds = np.unique(part.fold)
    error, found = part.square.copy(), []
    if part.gram.shape[-1] == 0:
        return error, np.zeros((len(folds), 0))
    for f in folds:
        out = part.fold == f
        theta = solve(gram[~out].sum(axis=0), right[~out].sum(axis=0))
        found.append(theta)
        error[:, out] += -2 * part.right[:, out] @ theta + np.einsum("abij,i,j->ab", part.gram[:, out], theta, theta)
    return error, np.array(found)
