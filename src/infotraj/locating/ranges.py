"""A residual against a quantity, range by range, for those who draw it."""

from __future__ import annotations

import numpy as np

from infotraj.locating.regions import Region
from infotraj.rotations import Array

BINS = 12


def by_range(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Middle of x, mean of y and RMS of y in each of up to 12 ranges of x (n,) that hold equally many rows."""
    edges = np.unique(np.quantile(x, np.linspace(0, 1, BINS + 1)))
    slot = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(edges) - 2)
    number = np.maximum(np.bincount(slot, minlength=len(edges) - 1), 1)
    middle = np.bincount(slot, x, minlength=len(number)) / number
    mean = np.bincount(slot, y, minlength=len(number)) / number
    return middle, mean, np.sqrt(np.bincount(slot, y**2, minlength=len(number)) / number)


def place_spans(region: Region, low: float, high: float) -> list[tuple[float, float]]:
    """The parts of low .. high in which a place lies."""
    cut = region.threshold
    spans = {"above": [(cut, high)], "below": [(low, cut)], "beyond": [(low, -cut), (cut, high)]}.get(region.side, [])
    return [s for s in spans if s[1] > s[0]]
