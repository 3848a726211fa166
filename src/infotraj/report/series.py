"""Time series for the page: few enough points to draw, no peak lost, as text that JavaScript reads at once."""

from __future__ import annotations

import base64

import numpy as np

from infotraj.rotations import Array


def reduced(t: Array, values: Array, most: int) -> tuple[Array, Array]:
    """At most `most` points of each column of values (n, c) at t (n,), in the order of time.

    Time is cut into equal buckets; of each, every column keeps its lowest and its highest value, in the order in which
    they came, at a quarter and three quarters of the bucket, so that no value lies outside what is drawn. NaN where a
    bucket of a column holds no number. What is short enough stays as it is.
    """
    if len(t) <= most:
        return t, values
    count = max(1, most // 2)
    width = (t[-1] - t[0]) / count
    slot = np.minimum(((t - t[0]) / width).astype(int), count - 1)
    first = np.searchsorted(slot, np.arange(count))
    place = np.arange(len(t)) - first[slot]
    out = np.full((2 * count, values.shape[1]), np.nan)
    table = np.full((count, int(place.max()) + 1), np.nan)
    for c in range(values.shape[1]):
        table[:] = np.nan
        table[slot, place] = values[:, c]
        some = np.isfinite(table).any(axis=1)
        held = table[some]
        low, high = np.nanargmin(held, axis=1), np.nanargmax(held, axis=1)
        rows = np.arange(len(held))
        pair = np.stack([held[rows, np.minimum(low, high)], held[rows, np.maximum(low, high)]], axis=1)
        out.reshape(count, 2, -1)[some, :, c] = pair
    begin = t[0] + width * np.arange(count)
    return np.stack([begin + 0.25 * width, begin + 0.75 * width], axis=1).ravel(), out


def packed(values: Array) -> str:
    """Numbers as little-endian single precision, base64."""
    return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode()


def unpacked(text: str) -> Array:
    """What `packed` wrote."""
    return np.frombuffer(base64.b64decode(text), dtype="<f4").astype(float)
