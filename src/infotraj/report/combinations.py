"""The held-out errors of every combination of what is named and the file: what ticking and unticking them shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.diagnosis.report.steps import HeldOut, floors, given_groups, held_out
from infotraj.progress import progress
from infotraj.rotations import Array

MOST = 4  # boxes: every further one would double what the page holds


@dataclass(frozen=True)
class Combinations:
    """groups: what each box adds, labels of effects, what matters most first and the file last; made[k]: errors with
    the boxes that are the bits of k, so made[0] is the model as given and made[-1] the one with everything; low, high
    (combinations, 6): 95 % of the RMSE; floor (6,), floors (flights, 6): what noise leaves with everything in the
    model, the one floor of all combinations and the one that `diagnose` prints."""

    groups: tuple[tuple[str, ...], ...]
    made: tuple[HeldOut, ...]
    low: Array
    high: Array
    floor: Array
    floors: Array

    @property
    def rmse(self) -> Array:
        """(combinations, 6)."""
        return np.array([m.rmse for m in self.made])


def combinations(found: Diagnosis, seed: int = 0) -> Combinations:
    """Each combination computed as it is, by the model itself, not as a sum of what single effects change.

    Beyond MOST boxes one stands for all that matter less. seed: of the resamples, which are the same for all
    combinations.
    """
    groups = boxes(given_groups(found), bool(found.beside))
    made, low, high = [], [], []
    for k in progress(range(2 ** len(groups)), "computing combination"):
        held = held_out(found, [x for bit, group in enumerate(groups) if k >> bit & 1 for x in group])
        around = held.interval(np.random.default_rng(seed))
        made.append(held)
        low.append(around[0])
        high.append(around[1])
    return Combinations(groups, tuple(made), np.array(low), np.array(high), found.after.floor, floors(found))


def boxes(groups: Sequence[tuple[str, ...]], corrected: bool = False) -> tuple[tuple[str, ...], ...]:
    """One box a group; where they are too many, one for all that matter less, before that of the file: corrected, the
    last group is that."""
    if len(groups) <= MOST:
        return tuple(groups)
    last = len(groups) - corrected
    few = MOST - 1 - corrected
    return (*groups[:few], tuple(x for group in groups[few:last] for x in group), *groups[last:])
