"""The whitened residual of all flights under one noise model: what fits and sums are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from infotraj.diagnosis.residual import FlightSamples
from infotraj.diagnosis.whitening import Whitener, estimate
from infotraj.rotations import Array

Noise = dict[str, tuple[Whitener, Whitener, Whitener]]
BLOCK = 2.0  # s
MOST_BLOCKS = 96


def noise_model(samples: Sequence[FlightSamples], residuals: Sequence[list[Array]]) -> Noise:
    """A whitener for each axis of each channel key, from residuals (one list a flight, one (m, 3) a channel)."""
    gathered: dict[str, list[tuple[Array, NDArray, bool]]] = {}
    for s, flight in zip(samples, residuals, strict=True):
        for channel, values in zip(s.channels, flight, strict=True):
            gathered.setdefault(channel.key, []).append((values, channel.run, channel.difference))
    return {
        key: tuple(estimate([v[:, i] for v, _, _ in parts], [r for _, r, _ in parts], parts[0][2]) for i in range(3))
        for key, parts in gathered.items()
    }


def whiten(samples: FlightSamples, noise: Noise, values: Sequence[Array]) -> list[Array]:
    """Whitened columns: `values` one (m, 3, c) a channel, the same shapes out."""
    out = []
    for channel, x in zip(samples.channels, values, strict=True):
        white = np.empty(x.shape)
        for i, whitener in enumerate(noise[channel.key]):
            whitener.into(x[:, i], channel.run, white[:, i])
        out.append(white)
    return out


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
