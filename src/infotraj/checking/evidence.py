"""How much better one reading of a log explains it than another: sums by block that add up over logs.

Two readings are compared on the identities that the log allows (see `readings`). What is kept is enough to say how
large the rest is as declared and otherwise, in the sensor's unit; how much better the other one is on each half of the
seconds; and how sure that is. Logs that share a mapping share its errors: their sums are added before anything is
decided, so that ten logs of one vehicle get one answer.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from infotraj.checking.likelihood import sure_of_difference
from infotraj.checking.readings import Joint, Table
from infotraj.rotations import Array

HALVES = 2


@dataclass(frozen=True)
class Rest:
    """Sums of squares (HALVES, 3) over `count` (HALVES,) samples of one channel in its declared unit: what is left as
    `declared`, what is left by the `other` reading, and the `motion`, what would be left if the channel were its mean.
    `floor` (3,): a variance below which nothing is told apart. `unit`: of the other reading."""

    declared: Array
    other: Array
    motion: Array
    count: Array
    floor: Array
    unit: float

    def __add__(self, more: Rest) -> Rest:
        n, m = self.count.sum(), more.count.sum()
        return Rest(
            self.declared + more.declared,
            self.other + more.other,
            self.motion + more.motion,
            self.count + more.count,
            (n * self.floor + m * more.floor) / (n + m),
            self.unit,
        )

    def rms(self, squares: Array) -> float:
        """Root mean square of the vector (all three axes together)."""
        return float(np.sqrt(max(squares.sum(), 0.0) / self.count.sum()))

    def gain(self, half: int | None = None) -> float:
        """Logarithm of the ratio of the variances that the two readings leave, summed over the axes."""
        rows = slice(None) if half is None else slice(half, half + 1)
        n = max(self.count[rows].sum(), 1)
        declared = self.declared[rows].sum(axis=0) / n + self.floor
        other = self.other[rows].sum(axis=0) / n + self.floor
        return float(np.log(declared / other).sum())


@dataclass(frozen=True)
class Evidence:
    """For one reading against another: the rests by identity, and the J test's sums (3, blocks)."""

    rests: dict[str, Rest]
    sums: Array
    tried: int

    def __add__(self, more: Evidence) -> Evidence:
        shared = {n: self.rests[n] + more.rests[n] for n in self.rests.keys() & more.rests.keys()}
        rests = {**self.rests, **more.rests, **shared}
        return Evidence(rests, np.concatenate([self.sums, more.sums], axis=1), max(self.tried, more.tried))

    def gain(self, names: Collection[str] | None = None) -> float:
        """How much better the other reading is: the logarithm of the variances' ratio over all identities (or those of
        `names`), on the half of the seconds on which it is less."""
        counted = [r for n, r in self.rests.items() if names is None or n in names]
        return min(sum(r.gain(half) for r in counted) for half in range(HALVES))

    @property
    def sure(self) -> float:
        """How sure it is that the data follow the other reading (J test, corrected for the readings tried)."""
        products, squares, rest = self.sums
        return sure_of_difference(products, squares, rest, self.tried)


def together(parts: Sequence[Evidence]) -> Evidence:
    """The evidence of several logs as one."""
    return reduce(lambda a, b: a + b, parts)


def evidence(
    table: Table, declared: Joint, declared_at: int, other: Joint, other_at: int, tried: int | None = None
) -> Evidence:
    """Evidence of one log for `other` (with its pose's number in the table) against `declared`."""
    rests = {}
    labels = np.unique(np.concatenate([i.moments.labels for i in table.identities.values()]))
    sums = np.zeros((3, len(labels)))
    for name, identity in table.identities.items():
        m = identity.moments
        vector = getattr(other, name)
        channel, another = identity.series(other_at, vector)
        before, as_declared = identity.series(declared_at, getattr(declared, name))
        half = m.labels[m.block] % HALVES
        rests[name] = Rest(
            _by_half((before - as_declared) ** 2, half),
            _by_half((channel - another) ** 2, half),
            _by_half((channel - channel.mean(axis=0)) ** 2, half),
            np.bincount(half, minlength=HALVES).astype(float),
            m.floor,
            vector.unit,
        )
        noise = ((channel - another) ** 2).mean(axis=0) + m.floor
        d = (another - as_declared) / noise
        where = np.searchsorted(labels, m.labels)[m.block]
        np.add.at(sums[0], where, ((channel - as_declared) * d).sum(axis=1))
        np.add.at(sums[1], where, ((another - as_declared) * d).sum(axis=1))
        np.add.at(sums[2], where, ((channel - another) * d).sum(axis=1))
    return Evidence(rests, sums, readings_tried(table) if tried is None else tried)


def readings_tried(table: Table) -> int:
    """How many readings the best one was chosen from."""
    return len(table.poses) + sum(i.values[0].size for i in table.identities.values())


def _by_half(squares: Array, half: Array) -> Array:
    return np.stack([squares[half == k].sum(axis=0) for k in range(HALVES)])
