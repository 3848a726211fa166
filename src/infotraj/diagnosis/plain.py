"""Squared errors as they are, not whitened: means over 50 ms, axis by axis. They say how large an error is.

Whitening says what can be known: under noise that wanders, a constant error weighs next to nothing in it, however large
it is. What matters to a vehicle is the larger of the two rises.
"""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass

import numpy as np

from infotraj.diagnosis.features import bins
from infotraj.diagnosis.residual import FlightSamples
from infotraj.rotations import Array


@dataclass(frozen=True)
class Plain:
    """Mean squares of residual and columns over 50 ms bins: gram (axes, p, p), right (axes, p), square (axes,)."""

    gram: Array
    right: Array
    square: Array

    def shifted(self, theta: Array) -> Plain:
        """The same after the residual has become r - S theta."""
        return Plain(self.gram, self.right - self.gram @ theta, self.error(theta))

    def error(self, theta: Array) -> Array:
        """Mean squared error (axes,) after the residual has become r - S theta."""
        return self.square - 2 * self.right @ theta + np.einsum("aij,i,j->a", self.gram, theta, theta)


def binned(samples: Sequence[FlightSamples], joint: Sequence[list[Array]]) -> list[list[Array]]:
    """Columns (m, 3, c) a channel of a flight as means (levels) or changes (differences) over bins, (n, 3, c)."""
    out = []
    for s, flight in zip(samples, joint, strict=True):
        made = []
        for channel, x in zip(s.channels, flight, strict=True):
            found = bins(s, channel)
            starts = np.concatenate([[0], np.flatnonzero(np.diff(found.of_sample)) + 1])
            total = np.add.reduceat(x, starts, axis=0)
            made.append(total if channel.difference else total / found.size[:, None, None])
        out.append(made)
    return out


def mean_products(
    samples: Sequence[FlightSamples],
    axes: Sequence[str],
    left: Sequence[list[Array]],
    right: Sequence[list[Array]],
    ignored: AbstractSet[str] = frozenset(),
) -> Array:
    """Mean of left' right over all bins, (axes, p, q), of columns from `binned`; 0 on axes that are ignored."""
    out = np.zeros((len(axes), left[0][0].shape[2], right[0][0].shape[2]))
    count = np.zeros(len(axes))
    for number, s in enumerate(samples):
        for place, channel in enumerate(s.channels):
            for i, axis in enumerate(channel.axes):
                if axis in ignored:
                    continue
                a = axes.index(axis)
                out[a] += left[number][place][:, i].T @ right[number][place][:, i]
                count[a] += len(left[number][place])
    return out / np.maximum(count, 1)[:, None, None]


def mean_squares(
    samples: Sequence[FlightSamples],
    axes: Sequence[str],
    residual: Sequence[list[Array]],
    ignored: AbstractSet[str] = frozenset(),
) -> Array:
    """Mean squared residual (axes,) over bins; residual: one (m, 3) a channel of a flight."""
    parts = binned(samples, [[x[:, :, None] for x in flight] for flight in residual])
    return mean_products(samples, axes, parts, parts, ignored)[:, 0, 0]


def plain(
    samples: Sequence[FlightSamples],
    axes: Sequence[str],
    own: list[list[Array]],
    others: list[list[Array]],
    known: Array,
    ignored: AbstractSet[str] = frozenset(),
) -> Plain:
    """Mean squares of own columns (the residual first) and of others, from `binned`; known: products of the others."""
    within = mean_products(samples, axes, own, own, ignored)
    across = mean_products(samples, axes, own, others, ignored)
    top = np.concatenate([within, across], axis=2)
    bottom = np.concatenate([across.transpose(0, 2, 1), known], axis=2)
    every = np.concatenate([top, bottom], axis=1)
    return Plain(every[:, 1:, 1:], every[:, 0, 1:], every[:, 0, 0])
