"""Places: the quantities that a residual follows or grows with, worst first, chance controlled over the whole
search."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from infotraj.locating.quantities import Quantity
from infotraj.locating.regions import Region, blocks_of, measured, region
from infotraj.locating.samples import Samples
from infotraj.locating.search import Draws, Ranges, cells_of, describe, describe_cells
from infotraj.rotations import Array

DRAWS = 299
ALPHA = 0.01  # chance that anything at all is found where there is nothing, a kind of residual (force, torque)
# What a place must amount to, in squared error a row, as a share of the floor's square: less is real, perhaps, but
# nothing that anybody would look for.
LEAST_EXCESS = 0.25
ROUNDS = 3  # places an axis: each is taken out before the next is looked for
ALIKE = 0.9  # quantities that reach this share of the best one's gain are not told apart from it
PAIR_GAIN = 1.25  # a pair must describe this much more than the better of its two quantities
PRIMARY = ("speed", "height", "tilt of the body", "angle of the arms", "tilt rate of the arms", "turning rate",
"thrust",
           "battery voltage", "time")  # fmt: skip


@dataclass(frozen=True)
class Place:
    """Where one axis of the residual fails.

    quantity, other: what names the place, `other` for a pair; group: the quantity's word; p: chance that the search
    finds anything as good where there is nothing; explained: share of the squared error that follows the quantity;
    excess: squared error that goes with it, a row, over the floor's square; region: where the error sits; trend:
    (quantity, mean residual) at the knots; alike: quantities that do almost as well here. All of it is of the residual
    beside its mean (`mean`) and beside what follows the quantities that were found before it on this axis (`taken`).
    """

    axis: str
    unit: str
    quantity: Quantity
    other: Quantity | None
    p: float
    gain: float
    explained: float
    excess: float
    floor: float
    region: Region | None
    trend: tuple[Array, Array]
    alike: tuple[str, ...] = ()
    cell: tuple[tuple[float, float], tuple[float, float]] | None = None
    mean: float = 0.0
    taken: tuple[str, ...] = ()

    @property
    def group(self) -> str:
        """The word under which the place counts."""
        return self.quantity.group


@dataclass
class Search:
    """What was searched, for figures: gain in units of the null's spread, axis by quantity, and the null's largest."""

    axes: tuple[str, ...]
    names: tuple[str, ...]
    score: Array
    threshold: float
    p: Array
    explained: Array


@dataclass(frozen=True)
class Found:
    """The places of one kind of residual (worst first) and the search behind them."""

    samples: Samples
    places: list[Place]
    search: Search
    memory: float
    pairs: list[Place] = field(default_factory=list)


def matters(bias: float, floor: float) -> bool:
    """Whether an error that is the same everywhere is one that anybody would look for, by the measure of a place."""
    return bias**2 > LEAST_EXCESS * floor**2


def find_places(
    samples: Samples, rng: np.random.Generator, *, draws: int = DRAWS, least_excess: float = LEAST_EXCESS
) -> Found:
    """Searches every quantity for every axis, then what is left, up to three places an axis; then pairs."""
    cut = [(q, r) for q in samples.quantities if (r := Ranges.of(q.values)) is not None]
    residual = samples.residual - samples.residual.mean(axis=0)
    memory = _memory(samples, residual, cut)
    block = _block_rows(samples, memory)
    drawn = Draws.of(samples.flight, block, draws, rng)
    blocks = blocks_of(samples.flight, samples.t, max(1.0, 3.0 * memory))
    places: list[Place] = []
    search = None
    left = residual.copy()
    open_axes = set(range(len(samples.axes)))
    for _ in range(ROUNDS):
        scored = _score(samples, cut, left, drawn)
        if search is None:
            search = Search(
                samples.axes, tuple(q.name for q, _ in cut), scored.z[0], scored.threshold(), scored.p,
                scored.explained,
            )  # fmt: skip
        found_any = False
        for a in sorted(open_axes):
            taken = {p.quantity.name for p in places if p.axis == samples.axes[a]}
            place = _best(samples, cut, scored, left, a, taken, least_excess, blocks, rng)
            if place is None:
                open_axes.discard(a)
                continue
            before = tuple(p.quantity.name for p in places if p.axis == samples.axes[a])
            place = replace(place, mean=float(samples.residual[:, a].mean()), taken=before)
            places.append(place)
            ranges = next(r for q, r in cut if q.name == place.quantity.name)
            left[:, a] -= ranges.mean(place.trend[1])
            found_any = True
        if not found_any:
            break
    assert search is not None  # of the first round
    places.sort(key=lambda p: -p.gain)
    pairs = _pairs(samples, residual, drawn, least_excess, blocks, rng, places) if places else []
    return Found(samples, places, search, memory, pairs)


@dataclass(frozen=True)
class _Scored:
    """z (1 + draws, a, q): standardised gain, row 0 the data; highest (draws,): the null's largest; gain (a, q)."""

    z: Array
    highest: Array
    p: Array
    gain: Array
    explained: Array
    heights: list[Array]

    def threshold(self) -> float:
        return float(np.quantile(self.highest, 1.0 - ALPHA, method="higher"))


def _score(samples: Samples, cut: list[tuple[Quantity, Ranges]], residual: Array, drawn: Draws) -> _Scored:
    described = [describe(r, residual, drawn) for _, r in cut]
    gain = np.stack([d.gain for d in described], axis=2)
    meant = np.array([[q.axis in (None, axis) for q, _ in cut] for axis in samples.axes])
    null = gain[1:]
    z = (gain - null.mean(axis=0)) / np.maximum(null.std(axis=0), 1e-9)
    z = np.where(meant, z, -np.inf)
    highest = z[1:].max(axis=(1, 2))
    p = (1.0 + (highest[:, None, None] >= z[0]).sum(axis=0)) / (len(highest) + 1.0)
    return _Scored(
        z, highest, p, np.where(meant, gain[0], -np.inf),
        np.stack([d.explained[0] for d in described], axis=1), [d.heights[0] for d in described],
    )  # fmt: skip


def _best(
    samples: Samples, cut: list[tuple[Quantity, Ranges]], scored: _Scored, residual: Array, a: int, taken: set[str],
    least_excess: float, blocks: NDArray, rng: np.random.Generator,
) -> Place | None:  # fmt: skip
    significant = (scored.p[a] <= ALPHA) & np.array([q.name not in taken for q, _ in cut])
    if not significant.any():
        return None
    k = int(np.argmax(np.where(significant, scored.gain[a], -np.inf)))
    quantity, ranges = cut[k]
    floor = samples.floor[a]
    square = float(np.mean(residual[:, a] ** 2))
    at = region(quantity.values, residual[:, a], blocks, quantity.signed, rng)
    follows = scored.explained[a, k] * square / floor**2 if floor > 0 else np.inf
    gathers = 0.0
    if at is not None and at.low > 1.0:
        gathers = at.samples * (at.inside**2 - at.outside**2) / floor**2 if floor > 0 else np.inf
    excess = max(follows, gathers)
    if excess < least_excess:
        return None
    alike = [
        cut[j][0].name
        for j in np.argsort(-scored.gain[a])
        if j != k and scored.gain[a, j] >= ALIKE * scored.gain[a, k] and cut[j][0].group != quantity.group
    ]
    return Place(
        samples.axes[a], samples.unit, quantity, None, float(scored.p[a, k]), float(scored.gain[a, k]),
        float(scored.explained[a, k]), float(excess), float(floor), at, (ranges.knots, scored.heights[k][a]),
        tuple(alike[:3]),
    )  # fmt: skip


def _pairs(
    samples: Samples, residual: Array, drawn: Draws, least_excess: float, blocks: NDArray, rng: np.random.Generator,
    places: list[Place],
) -> list[Place]:  # fmt: skip
    """Cells of two quantities that describe an axis better than either does alone, one pair an axis."""
    chosen = [q for q in samples.quantities if q.name in PRIMARY and Ranges.of(q.values) is not None]
    both = [(i, j) for i in range(len(chosen)) for j in range(i)]
    if not both:
        return []
    cells = [cells_of(chosen[i].values, chosen[j].values) for i, j in both]
    gain = np.stack([describe_cells(c, n, residual, drawn) for c, n in cells], axis=2)
    z = (gain - gain[1:].mean(axis=0)) / np.maximum(gain[1:].std(axis=0), 1e-9)
    highest = z[1:].max(axis=(1, 2))
    p = (1.0 + (highest[:, None, None] >= z[0]).sum(axis=0)) / (len(highest) + 1.0)
    found = []
    for a, axis in enumerate(samples.axes):
        best_single = max((pl.gain for pl in places if pl.axis == axis), default=0.0)
        k = int(np.argmax(gain[0, a]))
        if p[a, k] > ALPHA or gain[0, a, k] < PAIR_GAIN * best_single:
            continue
        cell, count = cells[k]
        squares = np.bincount(cell, residual[:, a] ** 2, minlength=count)
        number = np.bincount(cell, minlength=count)
        rms = np.sqrt(squares / np.maximum(number, 1)) * (number >= 0.03 * len(cell))
        worst = int(np.argmax(rms))
        rows = cell == worst
        at = measured(rows, residual[:, a], blocks, rng, "cell", float(worst))
        floor = samples.floor[a]
        if at is None or not at.low > 1.0 or at.samples * (at.inside**2 - at.outside**2) < least_excess * floor**2:
            continue
        i, j = both[k]
        first, second = ((float(q.values[rows].min()), float(q.values[rows].max())) for q in (chosen[i], chosen[j]))
        found.append(
            Place(
                axis, samples.unit, chosen[i], chosen[j], float(p[a, k]), float(gain[0, a, k]),
                float(1.0 - at.outside**2 / max(at.inside, 1e-300) ** 2),
                float(at.samples * (at.inside**2 - at.outside**2) / floor**2), float(floor), at,
                (np.zeros(0), np.zeros(0)), (), (first, second), float(samples.residual[:, a].mean()),
            )
        )  # fmt: skip
    return found


def _memory(samples: Samples, residual: Array, cut: list[tuple[Quantity, Ranges]]) -> float:
    """How long (s) the residual remembers itself once every quantity's own mean is taken out: the longest axis."""
    left = residual.copy()
    identity = Draws.data(samples.flight)
    for quantity, ranges in cut:
        heights = describe(ranges, left, identity).heights[0]
        for a, axis in enumerate(samples.axes):
            if quantity.axis in (None, axis):
                left[:, a] -= ranges.mean(heights[a])
    longest = 0.0
    for a in range(left.shape[1]):
        total, lag = 0.5, 1
        variance = float(np.mean(left[:, a] ** 2))
        while lag < len(left) // 8 and variance > 0:
            same = samples.flight[lag:] == samples.flight[:-lag]
            if not same.any():
                break
            r = float(np.mean((left[lag:, a] * left[:-lag, a])[same])) / variance
            if r < 0.05:
                break
            total += r
            lag += 1
        longest = max(longest, 2.0 * total * samples.spacing)
    return longest


def _block_rows(samples: Samples, memory: float) -> float:
    """Mean length, in rows, of the blocks that are moved about: longer than the memory, short enough to have many."""
    counts = np.bincount(samples.flight)
    shortest = counts[counts > 0].min()
    wanted = max(1.0, 8.0 * memory) / samples.spacing
    return float(max(4.0, min(wanted, shortest / 12.0)))
