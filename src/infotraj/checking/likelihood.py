"""How well each reading of a vector channel explains it: one pass over the samples, then sums only.

A channel (three columns) is compared with predictions of it. Every reading of the channel, a signed permutation of the
axes and a unit, is then an entry of the same cross moments: no reading costs another pass. Moments are kept by block
(1 s) so that a difference between two readings comes with its spread over blocks, which holds under autocorrelation.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray
from scipy import special

from infotraj.rotations import Array

# Samples of smoothed channels half a second apart count as independent; it is a cautious figure for a multirotor.
INDEPENDENT_EVERY = 0.5


def rotations_of_axes() -> list[Array]:
    """The 24 rotations that map axes to axes, and the inversion -I, as (3, 3); the identity first."""
    found = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            m = np.zeros((3, 3))
            m[range(3), order] = signs
            if np.linalg.det(m) > 0:
                found.append(m)
    found.sort(key=lambda m: -np.trace(m))
    return [*found, -np.eye(3)]


AXES = rotations_of_axes()


@dataclass(frozen=True)
class Moments:
    """Sums by block over samples: `own` (B, L, 3) squares of the channel at L time shifts, `cross` (B, L, 3, C, 3) its
    products with C predictions, `square` (B, C, 3) squares of the predictions, `count` (B,) samples, `labels` (B,) the
    blocks, `floor` (3,) the least noise variance, `own_sum` (B, L, 3) and `sum` (B, C, 3) plain sums. A constant
    residual of at most `allowance` on each axis (a bias, a mounting angle) is no evidence for or against any reading.
    The samples themselves (`channel` (L, n, 3), `predictions` (C, n, 3), `block` (n,), `centres` (n,) s) stay at hand
    for single pairs of readings."""

    own: Array
    cross: Array
    square: Array
    count: NDArray[np.intp]
    floor: Array
    labels: Array
    own_sum: Array
    sum: Array
    allowance: float
    channel: Array
    predictions: Array
    block: NDArray[np.intp]
    centres: Array

    @property
    def independent(self) -> float:
        """Effective number of independent samples: one each INDEPENDENT_EVERY s of the 1 s blocks."""
        return len(self.count) / INDEPENDENT_EVERY

    def scores(self, axes: list[Array], units: Array) -> tuple[Array, Array]:
        """Profile log likelihood of every (prediction, axes, unit), (C, G, U), and the time shift of each, (C, G, U).

        Gaussian noise with a variance of its own for each axis, at least the floor; the best time shift is taken.
        """
        own, cross, square = self.own.sum(axis=0), self.cross.sum(axis=0), self.square.sum(axis=0)
        own_mean, mean_ = self.own_sum.sum(axis=0) / self.count.sum(), self.sum.sum(axis=0) / self.count.sum()
        values = np.empty((square.shape[0], len(axes), len(units)))
        shift = np.empty(values.shape, dtype=int)
        for g, turn in enumerate(axes):
            order = np.argmax(np.abs(turn), axis=1)
            sign = turn[range(3), order]
            product_ = np.stack([sign[i] * cross[:, i, :, order[i]] for i in range(3)], axis=-1)
            for u, unit in enumerate(units):
                total = own[:, None] - 2 * unit * product_ + unit**2 * square[None][:, :, order]
                offset = own_mean[:, None] - unit * sign * mean_[None][:, :, order]
                free = np.clip(offset, -self.allowance, self.allowance)
                total = total / self.count.sum() - 2 * free * offset + free**2
                mean = np.maximum(total, 0.0) + self.floor
                each = -0.5 * self.independent * np.log(mean).sum(axis=-1)
                shift[:, g, u] = np.argmax(each, axis=0)
                values[:, g, u] = np.max(each, axis=0)
        return values, shift

    def residual(self, c: int, axes: Array, unit: float) -> Array:
        """Sums of squared residuals (B, L, 3) of channel = unit x axes x prediction c + an allowed constant."""
        order = np.argmax(np.abs(axes), axis=1)
        sign = axes[range(3), order]
        cross = self.cross[:, :, range(3), c, order]
        offset = self.own_sum - unit * sign * self.sum[:, None, c, order]
        free = np.clip(offset.sum(axis=0) / self.count.sum(), -self.allowance, self.allowance)
        squares = self.own - 2 * unit * sign * cross + (unit**2) * self.square[:, None, c, order]
        return squares - 2 * free * offset + self.count[:, None, None] * free**2


def moments(
    channel: Array, predictions: Array, centres: Array, block: Array, allowance: float, floor_share: float = 0.02
) -> Moments | None:
    """Moments of a channel (L, n, 3) and its predictions (C, n, 3) at `centres` (n,) in blocks `block` (n,); None
    under 5 blocks.

    The floor keeps noise-free data from giving unbounded evidence: residuals below `floor_share` of the channel's root
    mean square are as good as zero.
    """
    good = np.isfinite(channel).all(axis=(0, 2)) & np.isfinite(predictions).all(axis=(0, 2))
    channel, predictions, block, centres = channel[:, good], predictions[:, good], block[good], centres[good]
    labels, index, count = np.unique(block, return_inverse=True, return_counts=True)
    if len(labels) < 5:
        return None
    shifts, n, _ = channel.shape
    candidates = predictions.shape[0]
    left = np.moveaxis(channel, 1, 0).reshape(n, shifts * 3)
    right = np.moveaxis(predictions, 1, 0).reshape(n, candidates * 3)
    own = np.empty((len(labels), shifts, 3))
    cross = np.empty((len(labels), shifts, 3, candidates, 3))
    square = np.empty((len(labels), candidates, 3))
    own_sum = np.empty((len(labels), shifts, 3))
    total = np.empty((len(labels), candidates, 3))
    for b in range(len(labels)):
        rows = index == b
        own[b] = (left[rows] ** 2).sum(axis=0).reshape(shifts, 3)
        cross[b] = (left[rows].T @ right[rows]).reshape(shifts, 3, candidates, 3)
        square[b] = (right[rows] ** 2).sum(axis=0).reshape(candidates, 3)
        own_sum[b] = left[rows].sum(axis=0).reshape(shifts, 3)
        total[b] = right[rows].sum(axis=0).reshape(candidates, 3)
    level = own[:, shifts // 2].sum() / (3 * count.sum())
    floor = np.full(3, floor_share**2 * level + 1e-300)
    return Moments(
        own, cross, square, count, floor, labels, own_sum, total, allowance, channel, predictions, index, centres
    )


def sure_of_difference(products: Array, squares: Array, rest: Array, tried: int) -> float:
    """How sure it is that the data follow another reading and not the declared one.

    With r the residual of the declared reading and d the difference of the two predictions, r = b d + e has b = 0 where
    the declared reading holds and b = 1 where the other does (the J test of Davidson and MacKinnon, Econometrica 1981).
    `products` are the sums of r.d by block (B,), `squares` those of d.d and `rest` those of (r - d).d, all whitened.
    The standard error of b is the sandwich over blocks; b below one half means that the declared reading is the nearer
    one. One-sided p value of b = 0, times the number of readings tried (Bonferroni).
    """
    if len(products) < 3 or squares.sum() <= 0:
        return 0.0
    b = products.sum() / squares.sum()
    if b <= 0.5:
        return 0.0
    error = np.sqrt((rest**2).sum() * len(rest) / (len(rest) - 1)) / squares.sum()
    if error == 0:
        return 1.0
    return float(1 - min(1.0, special.stdtr(len(rest) - 1, -b / error) * tried))
