"""How strong the evidence for an effect is: paired differences of the held-out error, block by block."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from infotraj.diagnosis.noise import PRIOR
from infotraj.rotations import Array

RESAMPLES = 1000


@dataclass(frozen=True)
class Evidence:
    """Evidence for one effect beside the other supported ones.

    heldout_change: relative change of the whitened held-out squared error by the effect, with its 95 % interval;
    flights_better: folds in which the error falls, of all; selected: share of resamples that keep it; rise: see
    `search.rises`; axis: the most affected one; gain: fall of the held-out squared error; by_axis: the rise on each.
    """

    heldout_change: float
    ci95: tuple[float, float]
    flights_better: tuple[int, int]
    selected: float
    rise: float
    axis: str
    gain: float
    by_axis: dict[str, float] = field(default_factory=dict)


def evidence(
    without: Array,
    with_it: Array,
    windows: Array,
    axes: tuple[str, ...],
    fold: Array,
    flight: Array,
    least: float,
    rng: np.random.Generator,
    rivals: list[Array] | None = None,
    plain: Array | None = None,
) -> Evidence:
    """Compares the held-out error (axes, blocks) without and with an effect.

    windows (axes, blocks): see `sums.Sums`; least: gain that chance gives; rivals: errors (axes, blocks) of models with
    another effect in its place, which a resample prefers where they are lower; plain (axes,): rise of the plain error.
    """
    lost, kept = without.sum(axis=0), with_it.sum(axis=0)
    draws = resampled(flight, rng)
    a, b = draws @ lost, draws @ kept
    change = (b - a) / np.maximum(a, 1e-300)
    chosen = a - b > least
    for rival in rivals or []:
        chosen &= draws @ rival.sum(axis=0) > b
    better = sum(bool(kept[fold == f].sum() < lost[fold == f].sum()) for f in np.unique(fold))
    rise = (without - with_it).sum(axis=1) / np.maximum(windows.sum(axis=1), 1)
    if plain is not None:
        rise = np.maximum(rise, plain)
    return Evidence(
        float((kept.sum() - lost.sum()) / max(lost.sum(), 1e-300)),
        (float(np.quantile(change, 0.025)), float(np.quantile(change, 0.975))),
        (better, len(np.unique(fold))),
        float(np.mean(chosen)),
        float(rise.max()),
        axes[int(np.argmax(rise))],
        float(lost.sum() - kept.sum()),
        dict(zip(axes, map(float, rise), strict=True)),
    )


def resampled(flight: Array, rng: np.random.Generator, count: int = RESAMPLES) -> Array:
    """How often each block stands in each of `count` resamples, (count, blocks); blocks are drawn within flights."""
    draws = np.zeros((count, len(flight)))
    for f in np.unique(flight):
        blocks = np.flatnonzero(flight == f)
        draws[:, blocks] = rng.multinomial(len(blocks), np.full(len(blocks), 1 / len(blocks)), size=count)
    return draws


def standard_errors(gram: Array, right: Array) -> Array:
    """Standard errors (p,) of a fit from sums over blocks, (blocks, p, p) and (blocks, p) of its residual.

    Sandwich over blocks with the small-sample factor m / (m - p) (Liang and Zeger 1986; MacKinnon and White 1985, HC1),
    never below what white noise of unit variance gives. Numbers that these flights say nothing about keep the deviation
    of their prior.
    """
    blocks, p = right.shape
    if p == 0:
        return np.zeros(0)
    total = gram.sum(axis=0) + np.eye(p) / PRIOR**2
    size = np.sqrt(np.maximum(np.diag(total), 1e-300))
    inverse = np.linalg.pinv(total / np.outer(size, size), rcond=1e-12, hermitian=True) / np.outer(size, size)
    factor = blocks / max(blocks - p, 1)
    meat = np.einsum("bi,bj->ij", right, right) * factor
    sandwich = np.diag(inverse @ meat @ inverse)
    return np.sqrt(np.maximum(np.maximum(sandwich, np.diag(inverse)), 0.0))
