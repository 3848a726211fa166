"""Whether an effect is the same throughout the flights: a name whose numbers change on the way is not the cause.

An effect that is not in the catalogue is often taken up in part by one that is: the mean pull of a wall by a steady
force. Its numbers, fitted to each stretch of the flights alone, then differ by more than the noise, and let free they
would explain much more. A true effect's do not (a test of constancy, Chow 1960, by the size of what it finds). Slow
errors that nothing explains would let any number drift: what absent effects gain so on the same axes is taken off.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.diagnosis.sums import Sums
from infotraj.rotations import Array

MOST = 0.2  # of what an effect explains: as much or more is gained by numbers of its own for every block
_SURE = 3.0  # standard deviations of that gain under noise alone
_SAME_AXES = 0.5  # share of their information that two columns have on the same axes
_FEWEST = 3


def inconstancy(sums: Sums, columns: Sequence[int], size: float, explained: float, absent: Sequence[int] = ()) -> float:
    """What numbers of their own for every block would gain, as a share of what the effect explains; 0 within noise.

    sums: of the fitted model's residual; columns: of the effect's numbers; size: how far the furthest of these is from
    absent (usual sizes): by as much they may differ in a block; explained: squared error that the effect takes away;
    absent: columns of effects that are not in the model.
    """
    own = np.asarray(columns, dtype=int)
    gain, numbers = _gain(sums, own, size)
    drift = _drift(sums, own, absent)
    beyond = gain - drift * numbers
    return beyond / max(explained, 1e-300) if beyond > _SURE * drift * np.sqrt(2 * numbers) else 0.0


def _drift(sums: Sums, own: Array, absent: Sequence[int]) -> float:
    """What a number for every block gains for absent effects on the same axes, the median; at least 1, as noise."""
    mine = _shares(sums, own)
    gains = []
    for c in absent:
        if np.minimum(mine, _shares(sums, [c])).sum() > _SAME_AXES:
            gain, numbers = _gain(sums, np.array([c]), 1.0)
            gains.append(gain / max(numbers, 1.0))
    return max(1.0, float(np.median(gains))) if len(gains) >= _FEWEST else 1.0


def _shares(sums: Sums, columns: Sequence[int]) -> Array:
    """Share of each axis in the information on some columns, (axes,)."""
    size = sums.gram[:, :, columns, columns].sum(axis=(1, 2))
    return size / max(size.sum(), 1e-300)


def _gain(sums: Sums, own: Array, size: float) -> tuple[float, float]:
    """Fall of the squared error by numbers of every block's own beyond one set for all, and how many numbers that is.

    A block's own number lies about the common one by `size`: a block that hardly shows the effect counts little.
    """
    gram = sums.gram[:, :, own[:, None], own].sum(axis=0)
    right = sums.right[:, :, own].sum(axis=0)
    prior = np.eye(len(own)) / max(size, 1e-6) ** 2
    inverse = np.linalg.inv(gram + prior)
    gain = np.einsum("bi,bij,bj->", right, inverse, right)
    every = np.linalg.inv(gram.sum(axis=0) + 1e-9 * prior)
    total = right.sum(axis=0)
    numbers = np.einsum("bij,bji->", inverse, gram) - np.trace(every @ gram.sum(axis=0))
    return float(gain - total @ every @ total), float(max(numbers, 0.0))
