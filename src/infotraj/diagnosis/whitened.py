"""The whitened residual of all flights under one noise model: what fits and sums are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from infotraj.diagnosis.residual import FlightSamples
from infotraj.diagnosis.whitening import Whitener, estimate
from infotraj.rotations import Array

Noise = dict[str, tuple[Whitener, Whitener, Whitener]]
BLOCK = 2.0  # s
SLOW = 2.0  # s: neighbours further apart are taken as independent, blocks too
MOST_BLOCKS = 96
_SURE = 0.9  # weight of a sample above which what is left of it is taken for noise


def noise_model(samples: Sequence[FlightSamples], residuals: Sequence[list[Array]]) -> Noise:
    """A whitener for each axis of each channel key, from residuals (one list a flight, one (m, 3) a channel).

    What changes more slowly than within SLOW is no noise here: it is an error that has a name or is unexplained. Taken
    for noise that wanders, it would make itself invisible.
    """
    gathered: dict[str, list[tuple[Array, NDArray, bool]]] = {}
    for s, flight in zip(samples, residuals, strict=True):
        for number, (channel, values) in enumerate(zip(s.channels, flight, strict=True)):
            # A mean taken off differences of noise would wander when the whitening adds them up.
            slow = 0.0 if channel.difference else moving_mean(values, channel.run, round(SLOW / channel.step))
            sure, run = _sure(s, number)
            gathered.setdefault(channel.key, []).append(((values - slow)[sure], run, channel.difference))
    return {
        key: estimate([v for v, _, _ in parts], [r for _, r, _ in parts], parts[0][2])
        for key, parts in gathered.items()
    }


def _sure(samples: FlightSamples, number: int) -> tuple[NDArray, NDArray]:
    """Samples of a channel whose prediction is certain, half of them at least, and the runs (n,) that they make."""
    run = samples.channels[number].run
    if samples.weights is None:
        return np.arange(len(run)), run
    weights = samples.weights[number].min(axis=1)
    sure = np.flatnonzero(weights >= min(_SURE, float(np.median(weights))))
    breaks = (np.diff(sure) > 1) | (np.diff(run[sure]) != 0)
    return sure, np.concatenate([[0], np.cumsum(breaks)])


def moving_mean(values: Array, run: NDArray, window: int) -> Array:
    """Means (m, 3) over `window` samples about each, within each run."""
    out = np.empty_like(values)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(run)) + 1, [len(run)]])
    for a, b in pairwise(starts):
        out[a:b] = uniform_filter1d(values[a:b], min(max(window, 1), b - a), axis=0, mode="nearest")
    return out


def whiten(samples: FlightSamples, noise: Noise, values: Sequence[Array]) -> list[Array]:
    """Whitened and weighted columns: `values` one (m, 3, c) a channel, the same shapes out."""
    out = []
    for number, (channel, x) in enumerate(zip(samples.channels, values, strict=True)):
        white = np.empty(x.shape)
        for i, whitener in enumerate(noise[channel.key]):
            whitener.into(x[:, i], channel.run, white[:, i])
        if samples.weights is not None:
            white *= samples.weights[number][:, :, None]
        out.append(white)
    return out


def stacked(samples: Sequence[FlightSamples], noise: Noise, columns: Sequence[Sequence[Array]]) -> Array:
    """Whitened columns (m, 3, c) of all flights and channels, axis by axis, one below the other: (3 m in all, c)."""
    parts = []
    for s, of_flight in zip(samples, columns, strict=True):
        for w in whiten(s, noise, of_flight):
            parts += [w[:, i] for i in range(3)]
    return np.concatenate(parts)


@dataclass(frozen=True)
class Blocks:
    """How samples fall into blocks: for each flight and channel (m,) block numbers; fold (blocks,): held-out group."""

    of_sample: list[list[NDArray]]
    flight: NDArray
    fold: NDArray

    @property
    def count(self) -> int:
        """The number of blocks."""
        return len(self.flight)


def blocks(samples: Sequence[FlightSamples]) -> Blocks:
    """Blocks of about 2 s, longer where there would be more than 96 (the search's memory is then constant).

    Folds are flights; of one flight alone, up to five contiguous parts of it.
    """
    spans = [s.flight.t[-1] - s.flight.t[0] for s in samples]
    length = max(BLOCK, sum(spans) / max(MOST_BLOCKS - len(samples), 8))
    of_sample, owner, offset = [], [], 0
    for number, (s, span) in enumerate(zip(samples, spans, strict=True)):
        count = max(1, round(span / length))
        edge = s.flight.t[0] + span / count * np.arange(1, count)
        of_sample.append([offset + np.searchsorted(edge, s.times(c), side="right") for c in s.channels])
        owner += [number] * count
        offset += count
    flight = np.array(owner)
    fold = flight.copy()
    if len(samples) == 1:
        parts = min(5, len(flight))
        fold = (np.arange(len(flight)) * parts) // max(len(flight), 1)
    return Blocks(of_sample, flight, fold)
