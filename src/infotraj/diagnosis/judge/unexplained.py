"""Whether structured error is left that no effect of the model explains, where it is, and what it goes with.

What is left of the fitted model, file numbers corrected, is averaged over 50 ms and predicted on held-out
flights from named quantities, from what the vehicle and its rotors did in the last 1.2 s, and from random features of
the motion (a Gaussian process by its features). Turbulence and sensor noise cannot be predicted so, whatever their
colour; an effect that nobody listed can. It matters as an effect does: by the rise of the weighted error that it makes,
or of the error itself. Bands weigh by what the model explains, so that what it does not may weigh next to nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from infotraj.comparing.floor import white_noise
from infotraj.diagnosis.gates.refusal import axis_group
from infotraj.diagnosis.judge.features import BIN, bins, named, pasts, smooth
from infotraj.diagnosis.linear.observation import Observation
from infotraj.diagnosis.linear.sums import WINDOW
from infotraj.diagnosis.noise.spectra import BANDS, Spectrum, binned, spectra
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.predicting import TELLS
from infotraj.models.recorded import Samples
from infotraj.rotations import Array

_RIDGES = np.append(10.0 ** np.arange(-1.0, 5.5, 0.5), np.inf)
_SHIFTS = 12
_TERMS = 3
_LEAST_SHARE = 0.05
_LEAST_OF_GROUP = 0.02  # of the square, that a group of features predicts at least: the chances of several add up
_LOUD = 10.0


@dataclass(frozen=True)
class Structure:
    """What is left on one axis.

    share: of the error (50 ms means) that held-out flights predict, chance: the most that a shifted residual gives;
    rise: of the weighted squared error, in units of the floor; goes_with: quantities it correlates with most; hint: a
    sparse formula that holds up on held-out flights, its share, or None.
    """

    axis: str
    share: float
    chance: float
    rise: float
    goes_with: tuple[tuple[str, float], ...]
    hint: str | None
    hint_share: float

    @property
    def predicted(self) -> bool:
        """Whether the motion predicts a part of it: what does not may be left because it is large and slow."""
        return self.share > 0.0


@dataclass(frozen=True)
class Unexplained:
    """found: whether structured error that matters is left; axes: where it is, largest first."""

    found: bool
    axes: tuple[Structure, ...]


NOTHING_LEFT = Unexplained(False, ())


def unexplained(whole: Fit, matters: float, rng: np.random.Generator) -> Unexplained:
    """Looks for structure in what the fitted model `whole` leaves. matters: least rise of the error that counts."""
    o = whole.linear.observation
    model = o.model(whole.linear.members(whole.chosen, whole.solution.theta, shift=0.0, straight=True))
    left = [s.residual(model) for s in o.samples]
    predictions = [model.predict(s.prepared) for s in o.samples]
    names = dict.fromkeys(c.name for s in o.samples for c in s.channels)
    predicted = [[np.zeros_like(x) for x in flight] for flight in left]
    loud: dict[str, Structure] = {}
    held: dict[str, tuple[float, float, tuple, str | None, float]] = {}
    plain: dict[str, float] = {}
    for name in names:
        table = _table(o, left, predictions, name, rng)
        ridge = _Stages(table.features, table.fold)
        for i in range(3):
            axis, outcome, fitted = _axis(table, ridge, i)
            ratio = _loudness(table.target[:, i] - fitted, table, i, o.vehicle.gravity)
            if ratio is not None:
                loud[axis] = Structure(axis, 0.0, 0.0, ratio**2, (), None, 0.0)
            held[axis] = outcome
            plain[axis] = _plain_rise(table.target[:, i], fitted, outcome[0])
            for (flight, place, gathered), part in zip(table.where, np.split(fitted, table.cuts), strict=True):
                channel = o.samples[flight].channels[place]
                per_sample = part / gathered.size if channel.difference else part
                predicted[flight][place][:, i] = per_sample[gathered.of_sample]
    rises = _rises(whole, left, predicted)
    every = {
        axis: Structure(axis, share, chance, rises[axis], goes, hint, hint_share)
        for axis, (share, chance, goes, hint, hint_share) in held.items()
    }
    real = {
        axis: s
        for axis, s in every.items()
        if s.share > max(s.chance, _least(axis)) and max(s.rise, plain[axis]) > matters
    }
    found = [s for axis, s in {**loud, **real}.items() if axis not in o.ignored]
    return Unexplained(bool(found), tuple(sorted(found, key=lambda s: -s.rise)))


def more_stays(left: Unexplained, falls: Mapping[str, float], rises: Mapping[str, float]) -> str:
    """That more of what goes with the motion is left than something takes off, where it takes most; empty if not.

    falls, rises: what it takes off each axis on which it acts (`Evidence.falls`, `Evidence.by_axis`). Over a plane:
    what turns with the vehicle, or acts beside its axes, is in both of them.
    """
    planes: dict[tuple[str, bool], list[str]] = {}
    for a in falls:
        planes.setdefault((a[:-1], a[-1] == "z"), []).append(a)
    if not planes:
        return ""
    most = max(planes, key=lambda p: sum(falls[a] for a in planes[p]))
    stays = {s.axis: s.rise for s in left.axes if (s.axis[:-1], s.axis[-1] == "z") == most}
    if not stays or sum(stays.values()) <= sum(rises[a] for a in planes[most]):
        return ""
    axis = max(stays, key=stays.__getitem__)
    on = axis_group(axis) or axis
    return f"on {on} more is left that goes with the motion than it takes off: it may be part of that"


def _least(axis: str) -> float:
    """Share of the square that is predicted at least. What one sensor has against another is no force and no torque:
    it is spoken of where a sixth of it would go."""
    return _LEAST_SHARE if axis_group(axis) is not None else -float(np.expm1(-2.0 * TELLS))


def _plain_rise(y: Array, fitted: Array, share: float) -> float:
    """By how much the square of what is left y (N,) would rise without what is predicted of it, a share of its square.

    0 where what is predicted is less than the fast noise: an axis may be nothing but noise, and weigh nothing.
    """
    noise = float(white_noise(BIN * np.arange(float(len(y))), y[:, None])[0])
    return share / (1.0 - share) if float(fitted.std()) > noise else 0.0


def _loudness(y: Array, table: _Table, i: int, gravity: float) -> float | None:
    """How far what cannot be predicted lies above its own fast noise, where it is far, slow and large; else None.

    Large: 3 % of gravity, or a fifth of the measured change of rate. Hidden motion that no recorded quantity predicts
    (a load that tumbles) is structure too; ordinary turbulence stays below.
    """
    name = table.axes[i]
    if name[0] not in "fvt" or name.startswith("turn"):
        return None
    floor = float(white_noise(BIN * np.arange(float(len(y))), y[:, None])[0])
    size = float(np.sqrt(np.mean(y**2)))
    least = 0.03 * gravity * (BIN if name[0] == "v" else 1.0)
    if name[0] == "t":
        least = 0.2 * float(np.sqrt(np.mean(table.measured[:, i] ** 2)))
    return size / floor if size > _LOUD * floor and size > least else None


@dataclass(frozen=True)
class _Table:
    """Targets and what was measured (N, 3), features in groups (N, d), named ones first, folds (N,)."""

    axes: tuple[str, ...]
    target: Array
    measured: Array
    features: tuple[Array, ...]
    names: tuple[str, ...]
    fold: Array
    where: list
    cuts: Array


def _table(o: Observation, left, predictions, name: str, rng: np.random.Generator) -> _Table:
    targets, sides, tables, before, folds, where = [], [], [], [], [], []
    axes: tuple[str, ...] = ()
    for number, s in enumerate(o.samples):
        for place, channel in enumerate(s.channels):
            if channel.name != name:
                continue
            axes = channel.axes
            gathered = bins(s, channel)
            total = np.stack([np.bincount(gathered.of_sample, left[number][place][:, i]) for i in range(3)], axis=1)
            targets.append(total if channel.difference else total / gathered.size[:, None])
            rate = s.prepared.recorded.rate
            sides.append(
                np.zeros_like(targets[-1]) if name != "rate" or rate is None else _binned_change(rate, gathered.time)
            )
            tables.append(named(s, predictions[number], gathered.time))
            before.append(pasts(s, predictions[number], gathered.time))
            folds.append(o.blocks.fold[o.blocks.at(number, gathered.time)])
            where.append((number, place, gathered))
    names = [n for n in tables[0] if all(n in t for t in tables)]
    plain = np.concatenate([np.stack([t[n] for n in names], axis=1) for t in tables])
    # Of width 0 where a flight has no attitude to look back with, or the vehicle no rotors.
    past = [np.concatenate([x[:, : min(x.shape[1] for x in of)] for x in of]) for of in zip(*before, strict=True)]
    z = (plain - plain.mean(axis=0)) / np.maximum(plain.std(axis=0), 1e-9)
    moves = plain.std(axis=0) > 1e-6 * np.maximum(np.abs(plain).max(axis=0), 1e-12)
    kept = tuple(n for n, m in zip(names, moves, strict=True) if m)
    parts = [np.column_stack([z[:, moves], np.ones(len(z))]), *map(_standard, past), *smooth(z[:, moves], kept, rng)]
    cuts = np.cumsum([len(t) for t in targets])[:-1]
    return _Table(
        axes,
        np.concatenate(targets),
        np.concatenate(sides),
        tuple(parts),
        kept,
        np.concatenate(folds),
        where,
        cuts,
    )


def _binned_change(rate: Samples, time: Array) -> Array:
    """Measured change of the rate over the bins at `time`."""
    half = 0.5 * BIN
    return rate.at(time + half) - rate.at(time - half)


def _standard(x: Array) -> Array:
    return (x - x.mean(axis=0)) / np.maximum(x.std(axis=0), 1e-9) if x.shape[1] else x


def _axis(table: _Table, ridge: _Stages, i: int) -> tuple[str, tuple, Array]:
    y = table.target[:, i]
    size = max(float(y.std()), 1e-300)
    share, fitted = ridge.held_out(y / size)
    null = 0.0
    if share > _LEAST_SHARE:
        for k in range(1, _SHIFTS + 1):
            shifted = y.copy()
            for f in np.unique(table.fold):
                rows = np.flatnonzero(table.fold == f)
                shifted[rows] = np.roll(y[rows], round(len(rows) * k / (_SHIFTS + 1)))
            null = max(null, ridge.held_out(shifted / size)[0])
    columns = table.features[0][:, : len(table.names)]
    spread = columns.std(axis=0) * max(float(y.std()), 1e-300)
    correlation = (columns * (y - y.mean())[:, None]).mean(axis=0) / np.maximum(spread, 1e-300)
    order = np.argsort(-np.abs(correlation))[:3]
    goes = tuple((table.names[k], float(correlation[k])) for k in order)
    hint, hint_share = None, 0.0
    if share > max(_LEAST_SHARE, null):
        hint, hint_share = _formula(columns, table.names, y / size, table.fold, table.axes[i])
    return table.axes[i], (share, null, goes, hint, hint_share), fitted * size


class _Stages:
    """Ridge regression of any target (N,) on groups of features, each on what the groups before it leave.

    Fitted on all folds but one and tested on that one. Each group has a ridge of its own, or no part
    where it predicts less than a fiftieth: what a few features say is not lost among hundreds of others. The group that
    says most alone comes first.
    """

    def __init__(self, groups: Sequence[Array], fold: NDArray) -> None:
        self.groups = [[_turned(x, fold == f) for f in np.unique(fold)] for x in groups if x.shape[1]]

    def held_out(self, y: Array) -> tuple[float, Array]:
        """Share of y's square that is predicted, and the prediction (N,)."""
        alone = [float(np.sum((y - self._stage(g, y)) ** 2)) for g in self.groups]
        fitted = np.zeros(len(y))
        for k in np.argsort(alone):
            more = self._stage(self.groups[k], y - fitted)
            if np.sum((y - fitted) ** 2) - np.sum((y - fitted - more) ** 2) > _LEAST_OF_GROUP * np.sum(y**2):
                fitted += more
        return float(1.0 - np.sum((y - fitted) ** 2) / np.sum(y**2)), fitted

    def _stage(self, group: Sequence[tuple[NDArray, Array, Array, Array]], y: Array) -> Array:
        total = np.zeros((len(_RIDGES), len(y)))
        for out, train, test, values in group:
            theta = (train.T @ y[~out])[:, None] / (values[:, None] + _RIDGES)
            total[:, out] = (test @ theta).T
        return total[int(np.argmin(np.sum((y - total) ** 2, axis=1)))]


def _turned(x: Array, out: NDArray) -> tuple[NDArray, Array, Array, Array]:
    """Rows that are left out, the others and those along the principal axes of the others, and the axes' squares."""
    values, vectors = np.linalg.eigh(x[~out].T @ x[~out])
    return out, x[~out] @ vectors, x[out] @ vectors, np.maximum(values, 0.0)


def _formula(x: Array, names: Sequence[str], y: Array, fold: Array, axis: str) -> tuple[str | None, float]:
    """Up to three named terms by forward selection on the held-out error (orthogonal matching pursuit)."""
    chosen: list[int] = []
    best = 0.0
    for _ in range(_TERMS):
        scores = [(_plain_share(x[:, [*chosen, k]], y, fold), k) for k in range(x.shape[1]) if k not in chosen]
        share, k = max(scores)
        if share < best + 0.03:
            break
        chosen.append(k)
        best = share
    if not chosen:
        return None, 0.0
    return f"{axis} goes with " + " + ".join(names[k] for k in chosen), best


def _plain_share(x: Array, y: Array, fold: Array) -> float:
    x = np.column_stack([np.ones(len(x)), x])
    error = 0.0
    for f in np.unique(fold):
        out = fold == f
        theta = np.linalg.lstsq(x[~out], y[~out], rcond=1e-10)[0]
        error += float(np.sum((y[out] - x[out] @ theta) ** 2))
    return 1.0 - error / float(np.sum(y**2))


def _rises(whole: Fit, left: list[list[Array]], predicted: list[list[Array]]) -> dict[str, float]:
    """What the predicted structure makes of the error: its rise per 50 ms under the noise without it."""
    o, weights = whole.linear.observation, whole.linear.weights
    rest = [[a - b for a, b in zip(x, y, strict=True)] for x, y in zip(left, predicted, strict=True)]
    joint = [[np.stack([a, b], axis=2) for a, b in zip(x, y, strict=True)] for x, y in zip(left, rest, strict=True)]
    found: dict[str, list[tuple[Spectrum, Array]]] = {}
    for s in spectra(o.samples, o.transforms, binned(o.transforms, joint)):
        found.setdefault(s.axis, []).append((s, weights.coherence[weights.axes.index(s.axis)][s.band]))
    out = {}
    for axis, parts in found.items():
        band = np.concatenate([s.band for s, _ in parts])
        believed = np.concatenate([c for _, c in parts])
        square = np.concatenate([s.values**2 for s, _ in parts])
        count = np.maximum(np.bincount(band, minlength=BANDS), 1)
        noise = np.maximum(np.bincount(band, square[:, 1], minlength=BANDS) / count, 1e-300)
        rise = float(np.sum(believed * (square[:, 0] - square[:, 1]) / noise[band]))
        windows = sum(np.ptp(s.time) if len(s.time) else 0.0 for s, _ in parts) / WINDOW
        out[axis] = rise / max(windows, 1.0)
    return out
