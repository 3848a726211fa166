"""How much each frequency of each axis is believed: by what the richest model leaves there, and by what it explains.

The noise of an axis at a frequency is what no combination of effects and file numbers explains: noise of sensors and
what has no name alike (a discrepancy; Kennedy and O'Hagan 2001). Where inputs are noisy, or the body does what no model
here says, even the richest model explains little of what was measured: that frequency weighs by its coherence, the
share that is explained (Bendat and Piersol, "Random data", 2010, 6.1), so that it neither decides nor biases numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from infotraj.diagnosis.measure.lapped import Lapped, lapped
from infotraj.diagnosis.measure.residual import FlightSamples, measured_side
from infotraj.rotations import Array

EDGES = np.array([0.0, 0.5, 1.0, 1.5, 2.5, 3.5, 5.0, 7.0, 10.0, 14.0, 20.1])  # Hz
BANDS = len(EDGES) - 1
SLOW = 5.0  # Hz: what is slower moves a vehicle
SLOW_BANDS = int(np.searchsorted(EDGES, SLOW))
FREE = 30.0  # usual sizes: deviation of a number that is free, so wide that no size of an effect is held back
_ROUNDS = 4
_TAILS = 4.0  # degrees of freedom of Student's t for a second of an axis: seconds of spikes count less
_BESIDE = 0.01  # of the variance of the band beside it: noise that grows with the square of the frequency falls so
_NEARLY = 0.1  # of a residual, that may be left of it: noise of inputs leaves more
_LEAST = 0.2  # of an axis' coefficients in a band: that many are left over however many numbers are fitted


@dataclass(frozen=True)
class Spectrum:
    """Coefficients of one axis of one flight: (n, 1 + p), residual first; measured (n,) or None; band, time of each.

    noisy: the inputs that it is predicted from were measured.
    """

    axis: str
    flight: int
    values: Array
    measured: Array | None
    band: NDArray
    time: Array
    noisy: bool = False

    def weighted(self, weight: Array) -> Array:
        """Coefficients times the square root of their weight. weight: (n,)."""
        return self.values * np.sqrt(weight)[:, None]


@dataclass(frozen=True)
class Weights:
    """Weights of the coefficients, in units of the inverse of their variance.

    axes: names; noise (axes, bands): variance that the richest model leaves; coherence (axes, bands); second: for each
    spectrum (n,) by how much its second counts; beyond (axes, bands): how many times as much as was measured is to be
    explained; balance: axes of which the slowest band alone counts.
    """

    axes: tuple[str, ...]
    noise: Array
    coherence: Array
    second: tuple[Array, ...]
    beyond: Array
    balance: frozenset[str] = frozenset()

    def without(self, ignored: AbstractSet[str]) -> Weights:
        """The same where further axes have no weight."""
        out = np.array([a in ignored for a in self.axes])
        return replace(self, coherence=np.where(out[:, None], 0.0, self.coherence))

    def slow(self, axis: str) -> int:
        """How many bands say how large an error is."""
        return 1 if axis in self.balance else SLOW_BANDS

    def of(self, number: int, s: Spectrum) -> Array:
        """The weight (n,) of each coefficient of spectrum `number`."""
        return self.coherence[self.axes.index(s.axis)][s.band] * self.certain(number, s)

    def certain(self, number: int, s: Spectrum) -> Array:
        """The same were every frequency predictable, (n,)."""
        return (1.0 / self.noise[self.axes.index(s.axis)])[s.band] * self.second[number]


def transforms(samples: Sequence[FlightSamples]) -> list[list[Lapped]]:
    """The transform of every channel of every flight."""
    return [[lapped(s, c) for c in s.channels] for s in samples]


def binned(by: Sequence[Sequence[Lapped]], raw: Sequence[Sequence[Array]]) -> list[list[Array]]:
    """Residuals of all flights, one (m, 3) or (m, 3, c) a channel, as `spectra` takes them."""
    found = [[turn.binned(x) for turn, x in zip(*pair, strict=True)] for pair in zip(by, raw, strict=True)]
    return [[x if x.ndim == 3 else x[:, :, None] for x in flight] for flight in found]


def spectra(
    samples: Sequence[FlightSamples], by: Sequence[Sequence[Lapped]], joint: Sequence[Sequence[Array]]
) -> list[Spectrum]:
    """Residual and columns, one (bins, 3, 1 + p) a channel of a flight, as coefficients axis by axis."""
    out = []
    for number, (s, transform, flight) in enumerate(zip(samples, by, joint, strict=True)):
        recorded = s.prepared.recorded
        tilts = bool(recorded.tilt.values.shape[1])
        noisy = not recorded.rotor_commanded or (tilts and not recorded.tilt_commanded)
        for place, (c, turn, x) in enumerate(zip(s.channels, transform, flight, strict=True)):
            values = turn.turned(x)
            side = s.prepared.kept.get("measured coefficients", place, partial(_measured, s, c, turn))
            band = np.clip(np.searchsorted(EDGES, turn.frequency, side="right") - 1, 0, BANDS - 1)
            for i, axis in enumerate(c.axes):
                of_axis = None if side is None else side[:, i]
                of_values = np.ascontiguousarray(values[:, i])
                out.append(Spectrum(axis, number, of_values, of_axis, band, turn.time, noisy))
    return out


def _measured(samples: FlightSamples, channel, turn: Lapped) -> Array | None:
    side = measured_side(samples, channel)
    return None if side is None else turn(side[:, :, None])[:, :, 0]


def weights(
    found: Sequence[Spectrum],
    ignored: frozenset[str] = frozenset(),
    start: Weights | None = None,
    balance: frozenset[str] = frozenset(),
    beyond: Array | None = None,
) -> Weights:
    """The weights, from what a fit of all columns at once leaves, reweighted until they settle.

    ignored: axes of no weight; start: weights of nearly the same columns, which settle sooner; balance: axes of which
    the slowest band alone has weight; beyond: as in `Weights`, of the model as given; told of these where not given.
    """
    axes = tuple(dict.fromkeys(s.axis for s in found))
    # What the balance of one flight is off by in the mean is no noise of its seconds.
    found = [_centred(s) if s.axis in balance else s for s in found]
    width = found[0].values.shape[1]
    second = [np.ones(len(s.band)) for s in found] if start is None else list(start.second)
    noise = coherence = moves = np.ones((len(axes), BANDS))
    known = start.beyond if start is not None and beyond is None else beyond
    beyond = np.ones((len(axes), BANDS)) if known is None else known
    for k in range(_ROUNDS if start is None else 2):
        gram, count, side = _by_band(found, axes, second, width)
        if k == 0 and known is None:
            beyond = _beyond(gram, count, side, any(s.noisy for s in found))
        if k == 0 and start is not None:
            noise = start.noise
        elif k == 0:
            noise = _begun(gram[:, :, 0, 0], gram, count)
        if k == 0 and any(s.noisy for s in found):
            moves = np.array([_moves(*of_axis) for of_axis in zip(gram, count, side, strict=True)])
        inverse_noise = np.where(count > 0, moves / noise, 0.0)
        inverse_noise[[a in ignored for a in axes]] = 0.0
        inverse_noise[[a in balance for a in axes], 1:] = 0.0
        total = np.einsum("ab,abij->ij", inverse_noise, gram)
        covariance = _covariance(total[1:, 1:])
        theta = covariance @ total[0, 1:]
        along = np.concatenate([[1.0], -theta])
        left = gram @ along @ along
        spent = np.einsum("ij,abji->ab", covariance, gram[:, :, 1:, 1:]) * inverse_noise
        noise = _positive(_variance(left, count, spent), gram, count)
        told = beyond * side / np.maximum(count, 1)
        coherence = np.where(np.isfinite(told), np.clip(1.0 - noise / np.maximum(told, 1e-300), 0.0, 1.0), 1.0)
        # Torques that are large balance: that is as good as measured, at its slowest.
        coherence[[a in balance for a in axes]] = np.arange(BANDS) == 0
        second = [
            _seconds(s, s.values @ along, noise[axes.index(s.axis)], coherence[axes.index(s.axis)]) for s in found
        ]
    coherence = np.where(np.array([a in ignored for a in axes])[:, None], 0.0, coherence)
    return Weights(axes, noise, coherence, tuple(second), beyond, balance)


def _beyond(gram: Array, count: Array, side: Array, noisy: bool) -> Array:
    """How many times as much as was measured is to be explained, (axes, bands), at least 1; arguments as in `_moves`.

    Of a torque that is commanded for seconds and turns nothing little is measured: there it is most of what the model
    as given is wrong by. What measured inputs are wrong by is their noise, too, and is not to be explained.
    """
    seen = side / np.maximum(count, 1)
    residual = np.zeros_like(seen) if noisy else gram[:, :, 0, 0] / np.maximum(count, 1)
    return np.maximum(1.0, _NEARLY * residual / np.maximum(seen, 1e-300))


def _moves(gram: Array, count: Array, side: Array) -> Array:
    """The share of an axis that a fit of all columns to it alone explains, band by band, (bands,).

    gram (bands, 1 + p, 1 + p); count, side (bands,). The fit that measures the noise is weighed by it: where nothing
    moves, noise of inputs that are measured is predicted and not seen, and a vehicle that does not answer would explain
    it best; what moves would then be noise. Nearly all of a residual that is much larger counts as much.
    """
    told, residual = side / np.maximum(count, 1), gram[:, 0, 0] / np.maximum(count, 1)
    if not np.isfinite(told).all():
        return np.ones(BANDS)
    share, noise = np.where(EDGES[:-1] < SLOW, 1.0, 0.0), np.full(BANDS, told @ count / max(count.sum(), 1))
    for _ in range(_ROUNDS):
        weight = share / noise
        total = np.einsum("b,bij->ij", weight, gram)
        covariance = _covariance(total[1:, 1:])
        along = np.concatenate([[1.0], -covariance @ total[0, 1:]])
        spent = weight * np.einsum("ij,bji->b", covariance, gram[:, 1:, 1:])
        left = _variance(np.einsum("bij,i,j->b", gram, along, along), count, spent)
        noise = np.maximum(left, _BESIDE * told + 1e-300)
        share = np.clip(1.0 - left / np.maximum(np.maximum(told, _NEARLY * residual), 1e-300), 0.0, 1.0)
    return share


def _variance(squares: Array, count: Array, spent: Array) -> Array:
    """Mean of sums of squares over the coefficients that a fit has left free."""
    return squares / np.maximum(count - spent, _LEAST * count + 1e-9)


def _covariance(gram: Array) -> Array:
    """Covariance (p, p) of numbers that are free. Columns are brought to one length: they differ by many decades."""
    precision = gram + np.eye(len(gram)) / FREE**2
    scale = 1.0 / np.sqrt(np.diag(precision))
    return np.linalg.inv(precision * np.outer(scale, scale)) * np.outer(scale, scale)


def _centred(s: Spectrum) -> Spectrum:
    slowest = s.band == 0
    values = s.values.copy()
    if slowest.any():
        values[slowest] -= values[slowest].mean(axis=0)
    return replace(s, values=values)


def _by_band(found, axes, second, width):
    gram = np.zeros((len(axes), BANDS, width, width))
    count, side = np.zeros((len(axes), BANDS)), np.zeros((len(axes), BANDS))
    for s, own in zip(found, second, strict=True):
        a = axes.index(s.axis)
        order = np.argsort(s.band, kind="stable")
        ends = np.searchsorted(s.band[order], np.arange(BANDS + 1))
        moves = np.flatnonzero(np.any(s.values != 0.0, axis=0))
        at = np.ix_(moves, moves)
        x, weight = s.weighted(own)[np.ix_(order, moves)], own[order]
        square = None if s.measured is None else weight * s.measured[order] ** 2
        for b, rows in enumerate(map(slice, ends[:-1], ends[1:])):
            gram[a, b][at] += x[rows].T @ x[rows]
            count[a, b] += weight[rows].sum()
            side[a, b] += np.inf if square is None else square[rows].sum()
    return gram, count, side


def _begun(square: Array, gram: Array, count: Array) -> Array:
    """Where the weights begin: one noise for all slow bands of an axis, so that a large error is explained first."""
    own = square / np.maximum(count, 1)
    slow = EDGES[:-1] < SLOW
    together = square[:, slow].sum(axis=1) / np.maximum(count[:, slow].sum(axis=1), 1)
    return _positive(np.where(slow, np.maximum(own, together[:, None]), own), gram, count)


def _positive(variance: Array, gram: Array, count: Array) -> Array:
    """The variance, far below neither the residual's nor that of the bands beside it; 1 where there is nothing.

    A slow band has few coefficients: a fit of many numbers may leave nothing of them, whatever their noise.
    """
    least = np.maximum(1e-9 * gram[:, :, 0, 0] / np.maximum(count, 1), 1e-24)
    told = np.where(count > 0, np.maximum(variance, least), 0.0)
    beside = np.zeros_like(told)
    beside[:, 1:] = told[:, :-1]
    beside[:, :-1] = np.maximum(beside[:, :-1], told[:, 1:])
    return np.where(count > 0, np.maximum(told, _BESIDE * beside), 1.0)


def _seconds(s: Spectrum, left: Array, noise: Array, coherence: Array) -> Array:
    """By how much each second counts, (n,): Student's t for what the richest model leaves of it.

    As EM has it: Lange, Little and Taylor, "Robust statistical modeling using the t distribution" (1989).
    """
    _, place = np.unique(s.time, return_inverse=True)
    size = np.bincount(place, coherence[s.band])
    square = np.bincount(place, coherence[s.band] * left**2 / noise[s.band])
    weight = (_TAILS + size) / (_TAILS + square)
    return np.minimum(weight, 1.0)[place]
