"""The part of a quantity's range in which the error sits: threshold, ratio to the rest, and its interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from infotraj.rotations import Array

RESAMPLES = 400
LEAST_SHARE, MOST_SHARE = 0.05, 0.60  # of the rows that a place may hold
LEVEL = 0.95


@dataclass(frozen=True)
class Region:
    """Rows where a quantity is `side` ("above", "below", "beyond": either way) of `threshold`.

    samples, squares: shares of the rows and of the squared error in it; ratio: RMS inside over RMS outside, with its
    95 % interval (low, high); inside, outside: those RMS, in the residual's unit.
    """

    side: str
    threshold: float
    samples: float
    squares: float
    ratio: float
    low: float
    high: float
    inside: float
    outside: float
    rows: NDArray[np.bool_]

    def holds(self, values: Array) -> NDArray[np.bool_]:
        """Which values (n,) of the quantity lie in it, also on other flights."""
        if self.side == "below":
            return values < self.threshold
        return (np.abs(values) if self.side == "beyond" else values) > self.threshold


def region(values: Array, residual: Array, blocks: NDArray, signed: bool, rng: np.random.Generator) -> Region | None:
    """The side of one threshold where the squared error lies most above its share of the rows; None where nowhere.

    values, residual (n,); blocks (n,): the block of each row, resampled together for the interval.
    """
    square = residual**2
    if square.sum() <= 0:
        return None
    sides = [("above", values), ("below", -values)]
    if signed:
        sides.append(("beyond", np.abs(values)))
    best, where = 0.0, None
    for side, oriented in sides:
        order = np.argsort(-oriented, kind="stable")
        held = np.cumsum(square[order]) / square.sum()
        share = np.arange(1, len(order) + 1) / len(order)
        # ties belong together: a cut may lie only between two different values
        open_to_cut = np.append(np.diff(oriented[order]) < 0, False)
        good = open_to_cut & (share >= LEAST_SHARE) & (share <= MOST_SHARE)
        if good.any():
            k = int(np.argmax(np.where(good, held - share, -1.0)))
            if held[k] - share[k] > best + 1e-12:
                best, where = held[k] - share[k], (side, oriented, 0.5 * (oriented[order[k]] + oriented[order[k + 1]]))
    if where is None:
        return None
    side, oriented, cut = where
    rows = oriented > cut
    return measured(rows, residual, blocks, rng, side, -cut if side == "below" else cut)


def measured(
    rows: NDArray, residual: Array, blocks: NDArray, rng: np.random.Generator, side: str, threshold: float
) -> Region | None:
    """A region given by its rows (n,), measured; None where one side of it is empty."""
    if rows.all() or not rows.any():
        return None
    square = residual**2
    inside, outside = float(np.sqrt(square[rows].mean())), float(np.sqrt(square[~rows].mean()))
    sums = np.stack([np.bincount(blocks, w) for w in (rows * 1.0, ~rows * 1.0, square * rows, square * ~rows)], axis=1)
    picks = rng.integers(len(sums), size=(RESAMPLES, len(sums)))
    drawn = sums[picks].sum(axis=1)
    good = (drawn[:, :2] > 0).all(axis=1) & (drawn[:, 3] > 0)
    ratios = np.sqrt((drawn[good, 2] / drawn[good, 0]) / (drawn[good, 3] / drawn[good, 1]))
    tail = 50.0 * (1.0 - LEVEL)
    low, high = np.percentile(ratios, [tail, 100.0 - tail]) if len(ratios) > 20 else (np.nan, np.nan)
    return Region(
        side,
        float(threshold),
        float(rows.mean()),
        float(square[rows].sum() / square.sum()),
        inside / outside if outside > 0 else float("inf"),
        float(low),
        float(high),
        inside,
        outside,
        rows,
    )


def blocks_of(flight: NDArray, t: Array, seconds: float) -> NDArray:
    """The block of each row, (n,): pieces of about `seconds` of each flight, numbered through."""
    number = np.floor((t - t.min()) / seconds).astype(int)
    return np.unique(flight.astype(np.int64) * (number.max() + 1) + number, return_inverse=True)[1]
