"""Samples of a channel as coefficients in time and frequency, the same for a residual and for every sensitivity.

A modulated lapped transform (Malvar, "Signal processing with lapped transforms", 1992): cosines under windows of 2 s
that overlap by half. It is orthonormal, so white noise stays white, and what happened in one second stays in that
second. The window is the power-complementary one of Vorbis: noise that grows with the square of the frequency, as that
of a velocity that was differenced from positions does, does not leak into the slow coefficients. Nothing above 20 Hz is
kept: what a body does is slower, and filters inside sensors take away what is faster.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from infotraj.diagnosis.measure.residual import Channel, FlightSamples
from infotraj.rotations import Array

BIN = 0.025  # s: means of levels; slopes of the means of what was differenced
HOP = 1.0  # s between windows, half the length of each
BRIDGED = 0.3  # s: a shorter gap is crossed by a straight line, on both sides alike
_FEWEST = 16  # bins that a stretch needs


@dataclass(frozen=True)
class Stretch:
    """Samples `first` to `stop` of a channel, which lie in `count` bins of `width` (s).

    starts: first sample of each group, which lies in one bin of one unbroken run; time: its mean, s; bin: where its
    value belongs; kept: groups that have a value (of differences: those that follow another of their run).
    """

    first: int
    stop: int
    width: float
    count: int
    starts: NDArray
    time: Array
    bin: NDArray
    kept: NDArray

    @cached_property
    def beside(self) -> tuple[NDArray, NDArray, Array]:
        """For each bin the groups before and after it of those that have a value, and how far it is on the way."""
        filled = self.bin[self.kept]
        after = np.clip(np.searchsorted(filled, np.arange(self.count)), 1, len(filled) - 1)
        a, b = filled[after - 1], filled[after]
        return after - 1, after, (np.arange(self.count) - a) / (b - a)


@dataclass(frozen=True)
class Lapped:
    """The transform of one channel of a flight: its stretches, and frequency (Hz) and time (s) of each coefficient."""

    channel: Channel
    stretches: tuple[Stretch, ...]
    frequency: Array
    time: Array

    def __call__(self, values: Array) -> Array:
        """Coefficients (n, 3, c) of samples (m, 3, c); differences become slopes, in their unit per second."""
        return self.turned(self.binned(values))

    def binned(self, values: Array) -> Array:
        """Samples (m, 3, ...) over the bins of all stretches, (bins, 3, ...): fewer by what a bin holds."""
        parts = [_binned(s, self.channel.difference, values[s.first : s.stop]) for s in self.stretches]
        return np.concatenate(parts) if parts else np.zeros((0, *values.shape[1:]))

    def turned(self, binned: Array) -> Array:
        """Coefficients (n, 3, c) of what `binned` made, (bins, 3, c)."""
        rows = np.ascontiguousarray(binned).reshape(len(binned), int(np.prod(binned.shape[1:])))
        out = np.empty((len(self.frequency), rows.shape[1]))
        place = first = 0
        for s in self.stretches:
            hop, count = _frames(s.count, s.width)
            # Windows (count, 2 hop, columns) of the stretch, each half of the one before.
            seen = sliding_window_view(rows[first : first + (count + 1) * hop], 2 * hop, axis=0)[::hop]
            turned = np.matmul(_cosines(hop), np.swapaxes(seen, 1, 2))
            out[place : place + count * hop] = turned.reshape(count * hop, -1)
            place, first = place + count * hop, first + s.count
        return out.reshape(len(out), *binned.shape[1:])


def lapped(samples: FlightSamples, channel: Channel) -> Lapped:
    """The transform of a channel of a flight."""
    t = samples.times(channel)
    width = max(BIN, channel.step)
    begins = np.concatenate([[0], np.flatnonzero(np.diff(channel.run)) + 1])
    apart = t[begins[1:]] - t[begins[1:] - 1] > BRIDGED
    edges = np.concatenate([[0], begins[1:][apart], [len(t)]])
    stretches, frequency, time = [], [], []
    for first, stop in pairwise(edges):
        s = _stretch(int(first), int(stop), t[first:stop], channel.run[first:stop], width, channel.difference)
        if s is None:
            continue
        hop, count = _frames(s.count, width)
        stretches.append(s)
        frequency.append(np.tile((np.arange(hop) + 0.5) / (2 * hop * width), count))
        time.append(np.repeat(t[first] + (np.arange(count) + 1) * hop * width, hop))
    empty = [np.zeros(0)]
    return Lapped(channel, tuple(stretches), np.concatenate(frequency or empty), np.concatenate(time or empty))


def _stretch(first: int, stop: int, t: Array, run: NDArray, width: float, difference: bool) -> Stretch | None:
    place = np.floor((t - t[0]) / width + 1e-6).astype(int)
    new = np.concatenate([[True], (np.diff(place) != 0) | (np.diff(run) != 0)])
    starts = np.flatnonzero(new)
    size = np.diff(np.append(starts, len(t)))
    time = np.add.reduceat(t, starts) / size
    at, of_run = place[starts], run[starts]
    kept = np.ones(len(starts), dtype=bool)
    if difference:
        kept = np.concatenate([[False], (np.diff(of_run) == 0) & (np.diff(at) == 1)])
    # Where two runs meet in one bin the later one has it.
    kept &= np.append(np.diff(at) != 0, True)
    if kept.sum() < _FEWEST:
        return None
    at = at - at[kept][0]
    return Stretch(first, stop, width, int(at[kept][-1]) + 1, starts, time, at, np.flatnonzero(kept))


def _frames(bins: int, width: float) -> tuple[int, int]:
    """Bins from one window to the next, and the number of windows, in a stretch of so many bins."""
    hop = min(max(2, round(HOP / width)), bins // 2)
    return hop, bins // hop - 1


def _binned(s: Stretch, difference: bool, values: Array) -> Array:
    """Values over bins (n, 3, ...): means of levels; of differences the slopes from mean to mean of their running sums.

    So noise of single samples is averaged before it is differenced. Empty bins lie on a straight line.
    """
    beside = (-1, *(1,) * (values.ndim - 1))
    wide = np.ascontiguousarray(values).reshape(len(values), int(np.prod(values.shape[1:])))
    level = _means(wide, s.starts, difference).reshape(len(s.starts), *values.shape[1:])
    if difference:
        value = (level[s.kept] - level[s.kept - 1]) / (s.time[s.kept] - s.time[s.kept - 1]).reshape(beside)
    else:
        value = level[s.kept]
    if len(s.kept) == s.count:
        return value
    before, after, share = s.beside
    share = share.reshape(beside)
    return value[before] * (1 - share) + value[after] * share


@njit(cache=True)
def _means(values, starts, summed):
    """Means (g, c) of values (m, c) over groups that begin at `starts` (g,); summed: of their running sums."""
    count, columns = len(starts), values.shape[1]
    out, total = np.zeros((count, columns)), np.zeros(columns)
    for k in range(count):
        stop = starts[k + 1] if k + 1 < count else len(values)
        for i in range(starts[k], stop):
            for j in range(columns):
                if summed:
                    total[j] += values[i, j]
                    out[k, j] += total[j]
                else:
                    out[k, j] += values[i, j]
        for j in range(columns):
            out[k, j] /= stop - starts[k]
    return out


@lru_cache(maxsize=64)
def _cosines(hop: int) -> Array:
    n, k = np.arange(2 * hop), np.arange(hop)[:, None]
    window = np.sin(np.pi / 2 * np.sin(np.pi * (n + 0.5) / (2 * hop)) ** 2)
    return np.sqrt(2 / hop) * window * np.cos(np.pi / hop * (n + 0.5 + hop / 2) * (k + 0.5))
