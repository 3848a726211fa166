"""The best set of effects in one linearisation, beside a file that is as wrong as the flights say."""

from __future__ import annotations

from collections.abc import Set as AbstractSet

import numpy as np

from infotraj.diagnosis.select.around import Linear
from infotraj.diagnosis.select.prior import Scales
from infotraj.diagnosis.select.scaling import scaled
from infotraj.diagnosis.select.score import Solution

MOST = 6  # effects: physics of which six named ones are not enough is not of this catalogue
_NARROW = 4  # sets that are kept while the scale of the file is looked for


def searched(
    now: Linear,
    start: tuple[int, ...] | None = None,
    scales: Scales | None = None,
    barred: AbstractSet[str] = frozenset(),
) -> tuple[tuple[int, ...], Scales, Solution]:
    """The best set of choices, the scales of the file that go with it, and its numbers.

    How far the file is off and what is missing are found together: a number is missing physics where it is out of line
    with the rest of the file. start, scales: of an earlier search, which is then only added to, taken from and
    exchanged.
    """
    every = [i for i, c in enumerate(now.choices) if np.isfinite(c.price) and c.label not in barred]
    anew = start is None
    near = [s for s in now.scales if scales is None or 0.1 < s.common / scales.common < 10.0]
    most = MOST if anew else 2
    tried = [(now.scorer(s).search(most, every, start or (), 1, _NARROW), s) for s in near]
    first, common = max(tried, key=lambda pair: pair[0].score)
    scales = scaled(now, first.chosen, common.common)
    solution = now.scorer(scales).search(most, every, *(((), 2) if anew else (first.chosen, 1)))
    return solution.chosen, scales, solution
