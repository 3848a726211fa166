"""A small tree over all quantities: the few corners of state and input space that hold the error.

Regression tree (Breiman et al. 1984) on the squared error in units of the floor, grown to at most four leaves and
pruned by the error on blocks of time that it was not grown on, so that it does not follow noise that neighbours share.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from sklearn.tree import DecisionTreeRegressor

from infotraj.locating.regions import blocks_of
from infotraj.locating.samples import Samples
from infotraj.rotations import Array

MOST_LEAVES = 4
LEAST_SHARE = 0.05
FOLDS = 5
CLIPPED = 99.5  # percentile: one spike must not make a leaf
LEAST_GAIN = 0.05  # share of the held-out squared error that a further leaf must take away


@dataclass(frozen=True)
class Leaf:
    """One corner: conditions (quantity, unit, "above" or "below", threshold), shares of rows and of squared error, and
    the RMS in units of the floor."""

    conditions: tuple[tuple[str, str, str, float], ...]
    samples: float
    squares: float
    over_floor: float


def leaves(samples: Samples, axis: str) -> list[Leaf]:
    """The leaves for one axis, worst first; a single one without conditions where nothing can be told apart."""
    a = samples.axes.index(axis)
    residual = samples.residual[:, a] - samples.residual[:, a].mean()
    square = (residual / samples.floor[a]) ** 2
    clipped = np.minimum(square, np.percentile(square, CLIPPED))
    used = [q for q in samples.quantities if q.axis in (None, axis)]
    inputs = np.column_stack([np.abs(q.values) if q.signed else q.values for q in used])
    blocks = blocks_of(samples.flight, samples.t, 2.0)
    count = _leaf_count(inputs, clipped, blocks)
    if count < 2:
        return [Leaf((), 1.0, 1.0, float(np.sqrt(square.mean())))]
    tree = _grown(count).fit(inputs, clipped).tree_
    names = [(f"|{q.name}|" if q.signed else q.name, q.unit) for q in used]
    where = _grown(count).fit(inputs, clipped).apply(inputs)
    found = []
    for node, conditions in _paths(tree, names):
        rows = where == node
        found.append(
            Leaf(
                tuple(conditions),
                float(rows.mean()),
                float(square[rows].sum() / square.sum()),
                float(np.sqrt(square[rows].mean())),
            )
        )
    return sorted(found, key=lambda leaf: -leaf.over_floor)


def _grown(count: int) -> DecisionTreeRegressor:
    return DecisionTreeRegressor(max_leaf_nodes=count, min_samples_leaf=LEAST_SHARE, random_state=0)


def _leaf_count(inputs: Array, target: Array, blocks: Array) -> int:
    if blocks.max() + 1 < 2 * FOLDS:
        return 1
    fold = blocks % FOLDS
    held = np.full(MOST_LEAVES + 1, np.nan)
    held[1] = sum(np.sum((target[fold == f] - target[fold != f].mean()) ** 2) for f in range(FOLDS))
    chosen = 1
    for count in range(2, MOST_LEAVES + 1):
        held[count] = sum(
            np.sum(
                (target[fold == f] - _grown(count).fit(inputs[fold != f], target[fold != f]).predict(inputs[fold == f]))
                ** 2
            )
            for f in range(FOLDS)
        )
        if held[count] < (1.0 - LEAST_GAIN) * held[chosen]:
            chosen = count
    return chosen


def _paths(tree, names) -> list[tuple[int, list[tuple[str, str, str, float]]]]:
    found = []
    waiting: list[tuple[int, list[tuple[str, str, str, float]]]] = [(0, [])]
    while waiting:
        node, conditions = waiting.pop()
        if tree.children_left[node] < 0:
            found.append((node, _simplified(conditions)))
            continue
        name, unit = names[tree.feature[node]]
        cut = float(tree.threshold[node])
        waiting.append((tree.children_left[node], [*conditions, (name, unit, "below", cut)]))
        waiting.append((tree.children_right[node], [*conditions, (name, unit, "above", cut)]))
    return found


def _simplified(conditions):
    """Of two bounds on the same side of one quantity the tighter one."""
    kept: dict[tuple[str, str], tuple[str, float]] = {}
    for name, unit, side, cut in conditions:
        known = kept.get((name, side))
        tighter = cut if known is None else (max if side == "above" else min)(known[1], cut)
        kept[(name, side)] = (unit, tighter)
    return [(name, unit, side, cut) for (name, side), (unit, cut) in kept.items()]
