"""What the best of all absent effects would gain by chance: the search repeated on surrogates of the final residual.

A surrogate turns the sign of whole blocks of the whitened residual at random: noise keeps its colour and its size, and
what depends on an effect the same way in all blocks is lost (Freedman and Lane 1983 permute residuals alike; the sign
flip is Winkler et al. 2014, for errors that are symmetric but not exchangeable). Only S'r changes: sums are enough.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.diagnosis.lonely import fitted, halves, lonely
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
    folds, half = np.unique(sums.fold), halves(sums.fold)
    flips = rng.choice([-1.0, 1.0], size=(count, len(sums.fold)))
    parts = [[(sums.fold == f) & (half == h) for h in (0, 1)] for f in folds]
    right_of = np.array([[flips[:, part] @ right[part] for part in fold] for fold in parts])  # (folds, 2, count, p)
    gram_of = np.array([[gram[part].sum(axis=0) for part in fold] for fold in parts])
    size = np.sqrt(np.maximum(np.einsum("fhii->i", gram_of), 1e-300))
    gram_of, right_of = gram_of / np.outer(size, size), right_of / size
    kept = list(found.of_members)
    base = _gain(gram_of, right_of, kept)
    best = np.full(count, -np.inf)
    for s in sets:
        columns = kept + [c for i in s for c in found.choices[i].columns]
        best = np.maximum(best, _gain(gram_of, right_of, columns) - base)
    return best


def _gain(gram_of: Array, right_of: Array, columns: Sequence[int]) -> Array:
    """Held-out gain of some columns in every surrogate; sums of the halves of every fold, (folds, 2, ...)."""
    total = np.zeros(right_of.shape[2])
    if not len(columns):
        return total
    c = np.asarray(columns)
    g, b = gram_of[:, :, c[:, None], c], right_of[..., c]
    folds, of_folds = g.sum(axis=1), b.sum(axis=1)
    gram, right = folds.sum(axis=0), of_folds.sum(axis=0)
    eye = RIDGE * np.eye(len(c))
    for f, few in enumerate(lonely(folds)):
        rest = gram - folds[f], right - of_folds[f]
        if not few.any():
            total += _fall(folds[f], of_folds[f], np.linalg.solve(rest[0] + eye, rest[1].T).T)
            continue
        for h in (0, 1):
            theta = fitted(*rest, g[f, 1 - h], b[f, 1 - h], few, np.diag(g[f, h]), RIDGE)
            total += _fall(g[f, h], b[f, h], theta)
    return total


def _fall(gram: Array, right: Array, theta: Array) -> Array:
    return 2 * np.sum(theta * right, axis=1) - np.einsum("si,ij,sj->s", theta, gram, theta)
