"""Held-out numbers of effects that show in one flight only: ground effect, say, where one flight alone came low.

Leaving that flight out leaves nothing to fit such a number by: tested on it, it would be arbitrary, and the effect
would look harmful. So a number of which nearly all information lies in one fold is fitted on half of that fold as well
(alternate blocks), and tested on the half that it has not seen. Everything else is still fitted without the fold.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from infotraj.rotations import Array

LEAST = 0.1  # of a column's sum of squares: with less outside of a fold, nothing outside says much of its number
_NOTHING = 0.01  # of what it has where it is tested: with less to fit it by, a number is not fitted at all


def lonely(gram_of: Array) -> NDArray:
    """Whether a column shows in one fold only, (folds, p); gram_of: S'S of every fold (folds, p, p)."""
    own = np.einsum("fii->fi", gram_of)
    every = own.sum(axis=0)
    return every - own < LEAST * every


def halves(fold: NDArray) -> NDArray:
    """0 or 1 for every block: blocks of a fold alternate."""
    half = np.zeros(len(fold), dtype=int)
    for f in np.unique(fold):
        mine = np.flatnonzero(fold == f)
        half[mine] = np.arange(len(mine)) % 2
    return half


def fitted(
    gram: Array, right: Array, half_gram: Array, half_right: Array, alone: NDArray, tested: Array, ridge: float
) -> Array:
    """Numbers (..., p): those not `alone` by the other folds, (p, p) and (..., p), the others by half of the fold too.

    Least squares over both, in which the half sees the first only through what the other folds make of them.
    tested (p,): sums of squares of the columns in the half that is tested; what shows nowhere else gets 0.
    """
    told = np.diag(gram + half_gram) >= _NOTHING * tested
    few, many = np.flatnonzero(alone & told), np.flatnonzero(~alone)
    along, start = np.zeros((len(many), len(few))), np.zeros((*right.shape[:-1], len(many)))
    if len(many):
        within = _ridged(gram[np.ix_(many, many)], ridge)
        along = np.linalg.solve(within, gram[np.ix_(many, few)])
        start = np.linalg.solve(within, right[..., many, None])[..., 0]
    both, of_both = gram + half_gram, right + half_right
    turn = np.zeros((len(alone), len(few)))
    turn[many], turn[few] = -along, np.eye(len(few))
    left = of_both - start @ both[many]
    theta = np.zeros(right.shape)
    theta[..., few] = np.linalg.solve(_ridged(turn.T @ both @ turn, ridge), (left @ turn)[..., None])[..., 0]
    theta[..., many] = start - theta[..., few] @ along.T
    return theta


def _ridged(gram: Array, ridge: float) -> Array:
    size = np.diag(gram)
    # A column that is zero (its axis says nothing) gets the number 0, not a division by it.
    return gram + ridge * np.diag(np.where(size > 0, size, 1.0))
