"""What the best of all absent effects would gain by chance: the search repeated on surrogates of the final residual.

A surrogate turns the sign of whole blocks of the whitened residual at random: noise keeps its colour and its size, and
what depends on an effect the same way in all blocks is lost (Freedman and Lane 1983 permute residuals alike; the sign
flip is Winkler et al. 2014, for errors that are symmetric but not exchangeable). Only S'r changes: sums are enough.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.diagnosis.sensitivities import Sensitivities
from infotraj.diagnosis.sums import RIDGE, Sums
from infotraj.rotations import Array


def null_gains(
    sums: Sums, found: Sensitivities, sets: Sequence[tuple[int, ...]], rng: np.random.Generator, count: int = 200
) -> Array:
    """Largest held-out gain over `sets` of choices in each of `count` surrogates, (count,).

    The residual in `sums` is that of the fitted model; its members' numbers are fitted along.
    """
    gram, right, _ = sums.total()
    folds = np.unique(sums.fold)
    flips = rng.choice([-1.0, 1.0], size=(count, len(sums.fold)))
    by_fold = np.array([flips[:, sums.fold == f] @ right[sums.fold == f] for f in folds])  # (folds, count, p)
    gram_of = np.array([gram[sums.fold == f].sum(axis=0) for f in folds])
    kept = list(found.of_members)
    base = _gain(gram_of, by_fold, kept)
    best = np.full(count, -np.inf)
    for s in sets:
        columns = kept + [c for i in s for c in found.choices[i].columns]
        best = np.maximum(best, _gain(gram_of, by_fold, columns) - base)
    return best


def _gain(gram_of: Array, right_of: Array, columns: Sequence[int]) -> Array:
    """Held-out gain of some columns in every surrogate."""
    if not len(columns):
        return np.zeros(right_of.shape[1])
    c = np.asarray(columns)
    g, b = gram_of[:, c[:, None], c], right_of[:, :, c]
    size = np.sqrt(np.maximum(np.einsum("fii->i", g), 1e-300))
    g, b = g / np.outer(size, size), b / size
    total = np.zeros(b.shape[1])
    eye = RIDGE * np.eye(len(c))
    for f in range(len(g)):
        theta = np.linalg.solve(g.sum(axis=0) - g[f] + eye, (b.sum(axis=0) - b[f]).T).T
        total += 2 * np.einsum("si,si->s", theta, b[f]) - np.einsum("si,ij,sj->s", theta, g[f], theta)
    return total
