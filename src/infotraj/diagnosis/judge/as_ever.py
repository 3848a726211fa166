"""Where the error of flights is no larger than what healthy flights of the vehicle leave: its size is no sign there."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

import numpy as np

from infotraj.diagnosis.measure.residual import Channel, FlightSamples
from infotraj.models import Model
from infotraj.rotations import Array

_OVER = (0.1, 1.0)  # s over which an error is averaged: noise of sensors is gone; what is constant, or slow, shows


def largest(model: Model, flights: Iterable[FlightSamples], balance: Collection[str] = ()) -> dict[str, Array]:
    """The largest RMS that a model leaves on any of these flights, of means over 0.1 s and over 1 s, (2,).

    By axis of the residual, that of steps between rows a second. balance: axes of which only what is slow counts.
    """
    most: dict[str, Array] = {}
    for s in flights:
        for channel, left in zip(s.channels, s.residual(model), strict=True):
            rate = left / channel.step if channel.difference else left
            rms = np.array([_rms(rate, channel, s.times(channel), width) for width in _OVER])
            for i, axis in enumerate(channel.axes):
                own = rms[:, i] if axis not in balance else rms[1:, i].repeat(2)
                most[axis] = np.maximum(most.get(axis, 0.0), own)
    return most


def as_ever(now: Mapping[str, Array], healthy: Mapping[str, Array]) -> frozenset[str]:
    """Axes on which the flights that are asked about leave no more than some healthy flight, fast or slow."""
    return frozenset(a for a, rms in now.items() if a in healthy and bool(np.all(rms <= healthy[a])))


def _rms(x: Array, channel: Channel, t: Array, width: float) -> Array:
    """RMS (3,) of the means of x (m, 3) over stretches of `width` (s) that no gap breaks."""
    place = np.floor((t - t[0]) / width).astype(int)
    number = np.cumsum(np.concatenate([[0], (np.diff(place) != 0) | (np.diff(channel.run) != 0)]))
    count = np.bincount(number)
    means = np.stack([np.bincount(number, x[:, i]) for i in range(x.shape[1])], axis=1) / count[:, None]
    return np.sqrt(np.average(means**2, axis=0, weights=count))
