"""Whether an effect is the same throughout the flights: a name whose numbers change on the way is not the cause.

An effect that is not in the catalogue is often taken up in part by one that is: the mean pull of a wall by a steady
force. Its numbers, fitted to each stretch of the flights alone, then differ by more than the noise, and let free they
would explain much more. A true effect's do not (a test of constancy, Chow 1960, by the size of what it finds).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.diagnosis.sums import Sums

MOST = 0.25  # of what an effect explains: as much or more is gained by numbers of its own for every block
_SURE = 3.0  # standard deviations of that gain under noise alone
_RIDGE = 1e-3


def inconstancy(sums: Sums, columns: Sequence[int], explained: float) -> float:
    """What numbers of their own for every block would gain, as a share of what the effect explains; 0 within noise.

    sums: of the fitted model's residual; columns: of the effect's numbers; explained: squared error it takes away.
    """
    own = np.asarray(columns, dtype=int)
    gram = sums.gram[:, :, own[:, None], own].sum(axis=0)
    right = sums.right[:, :, own].sum(axis=0)
    gain = float(sum(map(_gain, gram, right))) - _gain(gram.sum(axis=0), right.sum(axis=0))
    numbers = len(own) * (len(gram) - 1)
    beyond = gain - numbers
    return beyond / max(explained, 1e-300) if beyond > _SURE * np.sqrt(2 * numbers) else 0.0


def _gain(gram, right) -> float:
    size = np.trace(gram) / len(right)
    return float(right @ np.linalg.solve(gram + (_RIDGE * size + 1e-12) * np.eye(len(right)), right))
