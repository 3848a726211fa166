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

MOST = 0.25  # of what an effect explains: as much or more is gained by numbers of its own for every block
_SURE = 3.0  # standard deviations of that gain under noise alone
_RIDGE = 1e-3
_SAME_AXES = 0.5  # share of their information that two columns have on the same axes
_FEWEST = 3


def inconstancy(sums: Sums, columns: Sequence[int], explained: float, absent: Sequence[int] = ()) -> float:
    """What numbers of their own for every block would gain, as a share of what the effect explains; 0 within noise.

    sums: of the fitted model's residual; columns: of the effect's numbers; explained: squared error it takes away;
    absent: columns of effects that are not in the model.
    """
    own = np.asarray(columns, dtype=int)
    numbers = len(own) * (sums.fold.size - 1)
    drift = _drift(sums, own, absent)
    beyond = _gain(sums, own) - drift * numbers
    return beyond / max(explained, 1e-300) if beyond > _SURE * drift * np.sqrt(2 * numbers) else 0.0


def _drift(sums: Sums, own: Array, absent: Sequence[int]) -> float:
    """What one number for every block gains for absent effects on the same axes, the median; at least 1, as noise."""
    mine = _shares(sums, own)
    gains = [_gain(sums, np.array([c])) for c in absent if np.minimum(mine, _shares(sums, [c])).sum() > _SAME_AXES]
    return max(1.0, float(np.median(gains)) / (sums.fold.size - 1)) if len(gains) >= _FEWEST else 1.0


def _shares(sums: Sums, columns: Sequence[int]) -> Array:
    """Share of each axis in the information on some columns, (axes,)."""
    size = sums.gram[:, :, columns, columns].sum(axis=(1, 2))
    return size / max(size.sum(), 1e-300)


def _gain(sums: Sums, own: Array) -> float:
    """Fall of the squared error by numbers of every block's own, beyond one set for all."""
    gram = sums.gram[:, :, own[:, None], own].sum(axis=0)
    right = sums.right[:, :, own].sum(axis=0)
    return float(sum(map(_fall, gram, right))) - _fall(gram.sum(axis=0), right.sum(axis=0))


def _fall(gram: Array, right: Array) -> float:
    size = np.trace(gram) / len(right)
    return float(right @ np.linalg.solve(gram + (_RIDGE * size + 1e-12) * np.eye(len(right)), right))
