"""The held-out errors of every combination of the supported effects: what ticking and unticking them shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.diagnosis.report.steps import HeldOut, floors, held_out, supported_labels
from infotraj.progress import progress
from infotraj.rotations import Array

MOST = 4  # boxes: every further one would double what the page holds


@dataclass(frozen=True)
class Combinations:
    """groups: what each box adds, labels of effects, the one that matters most first; made[k]: the errors with the
    boxes that are the bits of k, so made[0] is the model as given and made[-1] the one with everything; low, high
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

    Beyond MOST effects the last box stands for all that matter less. seed: of the resamples, which are the same for all
    combinations.
    """
    groups = boxes(supported_labels(found))
    made, low, high = [], [], []
    for k in progress(range(2 ** len(groups)), "computing combination"):
        held = held_out(found, [x for bit, group in enumerate(groups) if k >> bit & 1 for x in group])
        around = held.interval(np.random.default_rng(seed))
        made.append(held)
        low.append(around[0])
        high.append(around[1])
    return Combinations(groups, tuple(made), np.array(low), np.array(high), found.after.floor, floors(found))


def boxes(labels: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """One box a label, the last one for all that are left."""
    single = [(x,) for x in labels]
    return tuple(single) if len(single) <= MOST else (*single[: MOST - 1], tuple(labels[MOST - 1 :]))
