"""Searches sets of effects by their held-out error, from sums alone: all singles and pairs, then a beam.

Every set is fitted, with the numbers of the effects that are in the model already, on all folds but one and tested on
that one. A set whose fit asks for numbers outside their bounds is no candidate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from infotraj.diagnosis.sensitivities import Sensitivities
from infotraj.diagnosis.sums import RIDGE, Sums
from infotraj.rotations import Array

BEAM = 12
_SLACK = 0.05  # usual sizes by which a number may lie outside its bounds, beside three standard errors


@dataclass(frozen=True)
class Scored:
    """A set of choices (indices), what it gains in held-out squared error, and the numbers (columns, values)."""

    chosen: tuple[int, ...]
    gain: float
    columns: tuple[int, ...]
    theta: Array


class SubsetSearch:
    """Scores sets of choices in addition to the model's members."""

    def __init__(self, sums: Sums, found: Sensitivities) -> None:
        self.found = found
        self.gram, self.right, self.square = sums.total()
        self.fold = sums.fold
        p = self.gram.shape[-1]
        folds = np.unique(self.fold)
        pad = ((0, 0), (0, 1), (0, 1))
        self._gram_of = np.pad(np.array([self.gram[self.fold == f].sum(axis=0) for f in folds]), pad)
        self._right_of = np.pad(np.array([self.right[self.fold == f].sum(axis=0) for f in folds]), ((0, 0), (0, 1)))
        diagonal = np.diag(self._gram_of.sum(axis=0)).copy()
        self._size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        self._gram_of /= self._size[:, None] * self._size
        self._right_of /= self._size
        self._low = np.full(p + 1, -np.inf)
        self._high = np.full(p + 1, np.inf)
        m = list(found.of_members)
        self._low[m], self._high[m] = _distances(found.now, found.scale, found.low, found.high)
        for c in found.choices:
            self._low[list(c.columns)], self._high[list(c.columns)] = _distances(c.now, c.scale, c.low, c.high)

    def score(self, sets: Sequence[tuple[int, ...]], members: Sequence[int] | None = None) -> list[Scored]:
        """Scores sets of choices; `members`: the columns of the model that are fitted along (all by default)."""
        kept = tuple(self.found.of_members if members is None else members)
        columns = [kept + tuple(c for i in s for c in self.found.choices[i].columns) for s in sets]
        if not columns:
            return []
        width = max(map(len, columns), default=0)
        if width == 0:
            return [Scored(tuple(s), 0.0, (), np.zeros(0)) for s in sets]
        none = len(self._size) - 1
        index = np.full((len(sets), width), none)
        for k, c in enumerate(columns):
            index[k, : len(c)] = c
        gain, theta, error = self._solve(index, none)
        outside = (theta < self._low[index] - np.maximum(_SLACK, 3 * error)) | (
            theta > self._high[index] + np.maximum(_SLACK, 3 * error)
        )
        gain = np.where(outside.any(axis=1), -np.inf, gain)
        return [
            Scored(tuple(s), float(g), c, t[: len(c)]) for s, g, c, t in zip(sets, gain, columns, theta, strict=True)
        ]

    def _solve(self, index: Array, none: int) -> tuple[Array, Array, Array]:
        empty = index == none
        eye = np.eye(index.shape[1])
        rows, cols = index[:, :, None], index[:, None, :]
        all_gram, all_right = self._gram_of.sum(axis=0), self._right_of.sum(axis=0)
        filler = empty[:, :, None] * eye + RIDGE * eye
        gain = np.zeros(len(index))
        for g, b in zip(self._gram_of, self._right_of, strict=True):
            theta = np.linalg.solve((all_gram - g)[rows, cols] + filler, (all_right - b)[index][..., None])[..., 0]
            gain += 2 * np.sum(theta * b[index], axis=1) - np.einsum("ni,nij,nj->n", theta, g[rows, cols], theta)
        inverse = np.linalg.inv(all_gram[rows, cols] + filler)
        theta = np.einsum("nij,nj->ni", inverse, all_right[index])
        error = np.sqrt(np.maximum(np.einsum("nii->ni", inverse), 0.0))
        return gain, theta / self._size[index], error / self._size[index]

    def allowed(self, chosen: Sequence[int]) -> bool:
        """Whether no candidate stands twice in a set."""
        labels = [self.found.choices[i].candidate.label for i in chosen]
        return len(set(labels)) == len(labels)

    def search(self, most: int, exhaustive: int = 2) -> list[Scored]:
        """The best set of each size from 0 to `most`; sizes up to `exhaustive` try every set."""
        n = len(self.found.choices)
        best = [self.score([()])[0]]
        beam: list[Scored] = []
        for size in range(1, most + 1):
            if size <= exhaustive:
                sets = [s for s in combinations(range(n), size) if self.allowed(s)]
            else:
                sets = sorted(
                    {tuple(sorted((*b.chosen, i))) for b in beam for i in range(n) if self.allowed((*b.chosen, i))}
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
