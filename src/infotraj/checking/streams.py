"""Channels as streams: the samples that exist, averaged and interpolated without crossing gaps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from infotraj.flight import Flight
from infotraj.rotations import Array, Mask, continuous, normalize


@dataclass(frozen=True)
class Stream:
    """Samples `x` (n, k) at times `t` (n,) s, all finite; `gap` (s) is the longest step that counts as sampled."""

    t: Array
    x: Array
    gap: float

    @property
    def step(self) -> float:
        """Median time between samples (s)."""
        return float(np.median(np.diff(self.t)))

    def at(self, when: ArrayLike) -> Array:
        """Linear interpolation at the times `when`, (m, k); NaN outside the samples and inside gaps."""
        when = np.asarray(when, dtype=float)
        out = np.stack([np.interp(when, self.t, self.x[:, i]) for i in range(self.x.shape[1])], axis=-1)
        out[self._missing(when, when)] = np.nan
        return out

    def mean(self, centre: ArrayLike, width: float) -> Array:
        """Average over centre - width/2 .. centre + width/2, (m, k), by the integral of the linear interpolation.

        NaN where the window leaves the samples or touches a gap.
        """
        centre = np.asarray(centre, dtype=float)
        integral = self._integral
        a, b = centre - width / 2, centre + width / 2
        out = (_integral_at(self, integral, b) - _integral_at(self, integral, a)) / width
        out[self._missing(a, b)] = np.nan
        return out

    @property
    def _integral(self) -> Array:
        steps = (self.x[1:] + self.x[:-1]) / 2 * np.diff(self.t)[:, None]
        return np.vstack([np.zeros(self.x.shape[1]), np.cumsum(steps, axis=0)])

    def _missing(self, a: Array, b: Array) -> Array:
        outside = (a < self.t[0]) | (b > self.t[-1])
        gaps = np.concatenate([[0], np.cumsum(np.diff(self.t) > self.gap)])
        first = np.clip(np.searchsorted(self.t, a, side="right") - 1, 0, len(self.t) - 1)
        last = np.clip(np.searchsorted(self.t, b, side="left"), 0, len(self.t) - 1)
        return outside | (gaps[first] != gaps[last])


def _integral_at(stream: Stream, integral: Array, when: Array) -> Array:
    # exact for the linear interpolant: full steps before `when`, then the trapezoid of the step it falls in
    k = np.clip(np.searchsorted(stream.t, when, side="right") - 1, 0, len(stream.t) - 2)
    part = when - stream.t[k]
    slope = (stream.x[k + 1] - stream.x[k]) / (stream.t[k + 1] - stream.t[k])[:, None]
    return integral[k] + part[:, None] * stream.x[k] + 0.5 * (part**2)[:, None] * slope


def stream(flight: Flight, columns: tuple[str, ...], min_samples: int = 20) -> Stream | None:
    """The samples where all of `columns` are finite, or None where there are fewer than `min_samples`.

    A step longer than five median steps (and 50 ms) is a gap: nothing is interpolated across it.
    """
    if not flight.has(*columns):
        return None
    x = flight.get(*columns)
    keep = np.isfinite(x).all(axis=1)
    if keep.sum() < min_samples:
        return None
    t = flight.t[keep]
    return Stream(t, x[keep], gap=max(5 * float(np.median(np.diff(t))), 0.05))


def attitude_stream(q: Stream) -> Stream:
    """A stream of quaternions, normalised and with signs that do not jump, ready for interpolation."""
    norm = np.linalg.norm(q.x, axis=1)
    keep = norm > 1e-6
    return Stream(q.t[keep], continuous(normalize(q.x[keep])), q.gap)


def runs(mask: Mask) -> list[tuple[int, int]]:
    """The runs of True in `mask` as (first, past the last) row numbers."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], np.asarray(mask, dtype=int), [0]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
