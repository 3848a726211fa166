"""Which quantity explains a residual, and would chance have found one as good?

For each quantity the residual is described by a mean that is piecewise linear in the quantity and a spread of its own
in each of its ranges; the gain is that description's log-likelihood over a single mean and spread. The same is done
for a mean and spread in each cell of two quantities. The null is the whole search again on residuals whose blocks
have been moved about inside their flight, and whose means a flight have been dealt anew among the flights, which
keeps their colour and their distribution and breaks the tie to every quantity;
the largest standardised gain over everything searched is compared with those of the null (Westfall and Young 1993;
blocks of random length as in Politis and Romano 1994, for equal blocks would fall into step with a periodic flight).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from infotraj.rotations import Array

KNOTS = (0.02, 0.26, 0.5, 0.74, 0.98)  # quantiles of a quantity
# With fewer flights their means have too few orders to be dealt; they stay, and only what happens inside flights
# counts.
FEWEST_DEALT = 6
CELLS = 3  # ranges of each of two quantities
_SMALLEST = 1e-12  # variances below this share of the total count as this


@dataclass(frozen=True)
class Ranges:
    """A quantity cut into ranges: `knots` (m + 1,), the range of each row (n,) and the place in it, 0 to 1, (n,)."""

    knots: Array
    bin: Array
    place: Array

    @classmethod
    def of(cls, values: Array) -> Ranges | None:
        """The ranges of a quantity's values (n,); None where it hardly takes two values."""
        knots = np.unique(np.quantile(values, KNOTS))
        if len(knots) < 3 or np.min(np.diff(knots)) <= 1e-9 * max(1.0, np.abs(knots).max()):
            return None
        bins = np.clip(np.searchsorted(knots, values, side="right") - 1, 0, len(knots) - 2)
        # Beyond the outer knots the mean stays at its last value: a line through the tails would follow outliers.
        place = np.clip((values - knots[bins]) / np.diff(knots)[bins], 0.0, 1.0)
        return cls(knots, bins.astype(np.int64), place)

    def mean(self, heights: Array) -> Array:
        """The piecewise linear mean with the values `heights` (m + 1,) at the knots, at each row (n,)."""
        return heights[self.bin] * (1.0 - self.place) + heights[self.bin + 1] * self.place


@dataclass(frozen=True)
class Described:
    """A residual described by one quantity: log-likelihood gain (nats), mean at the knots, share of squares
    explained."""

    gain: Array
    heights: Array
    explained: Array


@dataclass(frozen=True)
class Draws:
    """b draws of residuals (n, a): order (b, n) of rows, and the flight (b, flights) whose mean each flight gets.

    flight (n,): the flight of each row, rows of one flight together. The first draw is the data themselves.
    """

    order: NDArray[np.int_]
    dealt: NDArray[np.int_]
    flight: NDArray[np.int_]

    @classmethod
    def of(cls, flights: NDArray[np.int_], block: float, count: int, rng: np.random.Generator) -> Draws:
        """The data, then `count` draws in which blocks of about `block` rows have been moved about."""
        n, known = len(flights), int(flights.max()) + 1
        order = np.concatenate([np.arange(n)[None], shuffled(flights, block, count, rng)])
        few = len(np.unique(flights)) < FEWEST_DEALT
        dealt = [np.arange(known) if few else _dealt(flights, known, rng) for _ in range(count)]
        return cls(order, np.stack([np.arange(known), *dealt]), flights.astype(np.int64))

    @classmethod
    def data(cls, flights: NDArray[np.int_]) -> Draws:
        """The data alone."""
        known = int(flights.max()) + 1
        return cls(np.arange(len(flights))[None], np.arange(known)[None], flights.astype(np.int64))

    def parts(self, residual: Array) -> tuple[Array, Array]:
        """Residuals less the mean of their flight (n, a), and these means (flights, a)."""
        known = self.dealt.shape[1]
        count = np.maximum(np.bincount(self.flight, minlength=known), 1)[:, None]
        means = np.stack([np.bincount(self.flight, r, minlength=known) for r in residual.T], axis=1) / count
        return residual - means[self.flight], means


def _dealt(flights: NDArray[np.int_], known: int, rng: np.random.Generator) -> NDArray[np.int_]:
    """Flights with rows, in random order; those without keep their place."""
    there = np.unique(flights)
    out = np.arange(known)
    out[there] = rng.permutation(there)
    return out


def describe(ranges: Ranges, residual: Array, draws: Draws) -> Described:
    """Describes residuals (n, a) in every draw: gain (b, a), heights (b, a, m + 1), explained (b, a)."""
    bins = len(ranges.knots) - 1
    left, means = draws.parts(residual)
    sums = _range_sums(left, means, draws.order, draws.dealt, draws.flight, ranges.bin, ranges.place, bins)
    count = np.bincount(ranges.bin, minlength=bins).astype(float)
    u = np.bincount(ranges.bin, weights=ranges.place, minlength=bins)
    uu = np.bincount(ranges.bin, weights=ranges.place**2, minlength=bins)
    gram = np.zeros((bins + 1, bins + 1))
    block = np.array([[count - 2 * u + uu, u - uu], [u - uu, uu]])
    for j in range(bins):
        gram[j : j + 2, j : j + 2] += block[:, :, j]
    total, weighted, square = np.moveaxis(sums, -1, 0)
    right = np.zeros((*total.shape[:2], bins + 1))
    right[..., :-1] += total - weighted
    right[..., 1:] += weighted
    heights = right @ np.linalg.inv(gram + 1e-9 * np.trace(gram) * np.eye(bins + 1))
    low, high = heights[..., :-1], heights[..., 1:]
    remaining = (
        square
        - 2.0 * (low * (total - weighted) + high * weighted)
        + low**2 * block[0, 0]
        + 2.0 * low * high * block[0, 1]
        + high**2 * block[1, 1]
    )
    return Described(*_likelihood(total, square, remaining, count, heights))


def describe_cells(cell: Array, cells: int, residual: Array, draws: Draws) -> Array:
    """Gain (b, a) of a mean and a spread in each cell; `cell` (n,) numbers the cell of each row."""
    left, means = draws.parts(residual)
    sums = _range_sums(left, means, draws.order, draws.dealt, draws.flight, cell, np.zeros(len(cell)), cells)
    count = np.bincount(cell, minlength=cells).astype(float)
    total, _, square = np.moveaxis(sums, -1, 0)
    remaining = square - total**2 / np.maximum(count, 1.0)
    return _likelihood(total, square, remaining, count, total)[0]


def cells_of(first: Array, second: Array) -> tuple[Array, int]:
    """Cells of two quantities' thirds: (n,) and their number."""
    parts = []
    for values in (first, second):
        edges = np.quantile(values, np.arange(1, CELLS) / CELLS)
        parts.append(np.searchsorted(edges, values))
    return (parts[0] * CELLS + parts[1]).astype(np.int64), CELLS * CELLS


def shuffled(flights: NDArray[np.int_], block: float, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Orders (count, n) of rows: blocks of random length, `block` rows in the mean, moved about inside each flight.

    flights (n,): the flight of each row, rows of one flight together. Row i of the shuffled residual is row order[i].
    """
    edges = np.flatnonzero(np.diff(flights)) + 1
    starts, stops = np.concatenate([[0], edges]), np.concatenate([edges, [len(flights)]])
    out = np.empty((count, len(flights)), dtype=np.int64)
    for b in range(count):
        for start, stop in zip(starts, stops, strict=True):
            n = stop - start
            # at least half the mean length, so that the residual's own colour stays inside the blocks
            lengths = 0.5 * block + rng.exponential(0.5 * block, size=int(2 * n / block) + 8)
            cuts = np.unique(np.minimum(np.cumsum(np.maximum(lengths, 1.0)).astype(int), n))
            pieces = [p for p in np.split(np.arange(n), cuts) if len(p)]
            rolled = np.concatenate([pieces[k] for k in rng.permutation(len(pieces))])
            out[b, start:stop] = start + (rolled + rng.integers(n)) % n
    return out


def _likelihood(total, square, left, count, heights):
    n = count.sum()
    spread = square.sum(axis=-1) - total.sum(axis=-1) ** 2 / n
    least = _SMALLEST * np.maximum(spread, 1e-300) / n
    variance = np.maximum(left / np.maximum(count, 1.0), least[..., None])
    gain = 0.5 * n * np.log(np.maximum(spread / n, 1e-300)) - 0.5 * np.sum(count * np.log(variance), axis=-1)
    explained = 1.0 - left.sum(axis=-1) / np.maximum(spread, 1e-300)
    return gain, heights, explained


@njit(cache=True)
def _range_sums(residual, means, order, dealt, flight, bins, place, count):
    draws, n = order.shape
    axes = residual.shape[1]
    out = np.zeros((draws, axes, count, 3))
    for b in range(draws):
        for i in range(n):
            j, u, row, mean = bins[i], place[i], order[b, i], dealt[b, flight[i]]
            for a in range(axes):
                r = residual[row, a] + means[mean, a]
                out[b, a, j, 0] += r
                out[b, a, j, 1] += u * r
                out[b, a, j, 2] += r * r
    return out
