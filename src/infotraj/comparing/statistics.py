"""What equation errors come to: RMSE, bias, share of the variance explained, and the floor, an axis each.

Two models on the same flights are compared as ArviZ compares models: by the difference of their errors and its standard
error, over blocks longer than the residual's own memory, with a flag where there are too few blocks to trust it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.rotations import Array

BLOCK = 2.0  # s
FEW_BLOCKS = 20
WORSE = 1.5


@dataclass(frozen=True)
class Statistics:
    """Per axis (6,), in the unit of the equation error, NaN where the axis cannot be answered.

    rmse; bias: mean of measured minus predicted; explained: 1 - squared error over the variance of the measured side;
    floor: what sensor noise alone leaves; spread: standard deviation of the measured side; rows: how many count.
    """

    rmse: Array
    bias: Array
    explained: Array
    floor: Array
    spread: Array
    rows: Array

    @property
    def worse_than_none(self) -> list[str]:
        """Axes whose prediction, its bias forgiven, is further off than a constant: 1.5 times the variance and more."""
        varies = np.square(self.rmse) - np.square(self.bias)
        return [axis for k, axis in enumerate(AXES) if self.rows[k] and varies[k] > WORSE * self.spread[k] ** 2]


def statistics(errors: Sequence[EquationError]) -> Statistics:
    """Over all rows of all flights together."""
    rows = np.array([e.scored.sum(axis=0) for e in errors], dtype=float)
    total = rows.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        residual = [np.where(e.scored, e.residual, 0.0) for e in errors]
        squares = np.sum([np.sum(r**2, axis=0) for r in residual], axis=0)
        bias = np.sum([r.sum(axis=0) for r in residual], axis=0) / total
        measured = [np.where(e.scored, e.measured, 0.0) for e in errors]
        mean = np.sum([m.sum(axis=0) for m in measured], axis=0) / total
        about = np.sum(
            [np.sum(np.where(e.scored, e.measured - mean, 0.0) ** 2, axis=0) for e in errors],
            axis=0,
        )
        floors = np.array([np.nan_to_num(e.floor) for e in errors])
        floor = np.sqrt(np.sum(rows * floors**2, axis=0) / total)
        floor = np.where(np.any([np.isfinite(e.floor) for e in errors], axis=0), floor, np.nan)
        return Statistics(
            np.sqrt(squares / total), bias, 1.0 - squares / about, floor, np.sqrt(about / total), total.astype(int)
        )


@dataclass(frozen=True)
class Difference:
    """Error of one model less that of another, as share of the other's mean square: mean, its standard error,
    blocks."""

    mean: Array
    standard_error: Array
    blocks: int

    @property
    def few(self) -> bool:
        """True where there are too few blocks to trust the standard error."""
        return self.blocks < FEW_BLOCKS


def difference(model: Sequence[EquationError], other: Sequence[EquationError]) -> Difference:
    """Mean square of `model` less that of `other`, over that of `other`, an axis each (6,), on the rows of both.

    NaN on axes that one of them cannot answer. Both are in one scale (`equation_error`).
    """
    means, weights = [], []
    for a, b in zip(model, other, strict=True):
        both = a.scored & b.scored
        block = np.floor((a.t - a.t[0]) / BLOCK).astype(int)
        for k in np.unique(block):
            rows = block == k
            count = both[rows].sum(axis=0)
            if count.max() == 0:
                continue
            squares = [np.where(both[rows], e.residual[rows] ** 2, 0.0).sum(axis=0) for e in (a, b)]
            means.append(squares)
            weights.append(count)
    if not means:  # no row that both predict
        return Difference(np.full(6, np.nan), np.full(6, np.nan), 0)
    sums, counts = np.array(means), np.array(weights, dtype=float)
    with np.errstate(invalid="ignore", divide="ignore"):
        reference = sums[:, 1].sum(axis=0) / counts.sum(axis=0)
        apart = (sums[:, 0] - sums[:, 1]) / counts.mean(axis=0) / reference
        n = len(apart)
        error = apart.std(axis=0, ddof=1) / np.sqrt(n) if n > 1 else np.full(6, np.nan)
        return Difference(apart.mean(axis=0), error, n)


def worst_flight(errors: Sequence[EquationError]) -> int:
    """The flight whose error is largest in units of the floor, over all axes."""
    ratios = []
    for error in errors:
        one = statistics([error])
        with np.errstate(invalid="ignore", divide="ignore"):
            squares = np.square(one.rmse / one.floor)
        ratios.append(float(np.mean(squares[np.isfinite(squares)])) if np.isfinite(squares).any() else 0.0)
    return int(np.argmax(ratios))
