"""Posterior variance under a prior that knows physics: a sum of known columns of unknown weight, and a small process.

    g_o(x) = sum_k s_ok(x) theta_k + r_o(u),   theta_k ~ N(0, 1),   r_o a Gaussian process of small variance

The columns s_k are scaled so that a weight of one is usual. With the columns of effects the outputs share their
weights: a weak actuator and a steady disturbance are told apart by any flight in which their columns differ, about any
axis. Only the places of the data enter, as in eq. 13. Source: C. E. Rasmussen and C. K. I. Williams, "Gaussian
Processes for Machine Learning" (2006), sec. 2.7.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial.distance import cdist

from infotraj.rotations import Array


@dataclass(frozen=True)
class Rows:
    """n places: columns (n, m, k), the change of the m outputs (rad/s^2) by a usual size; inputs (n, d)."""

    columns: Array
    inputs: Array

    def __getitem__(self, rows: NDArray[np.intp]) -> Rows:
        return Rows(self.columns[rows], self.inputs[rows])

    def __add__(self, other: Rows) -> Rows:
        return Rows(np.concatenate([self.columns, other.columns]), np.concatenate([self.inputs, other.inputs]))


@dataclass(frozen=True)
class LinearPrior:
    """rest: standard deviation of the small process, rad/s^2; lengthscale: its, of the inputs; noise: rad/s^2."""

    rest: float = 0.3
    lengthscale: float = 1.0
    noise: float = 0.1

    def variance(self, data: Rows, region: Rows) -> Array:
        """Variance (r, m) of the noise-free outputs over the region after data at the given places."""
        _, m, _ = data.columns.shape
        known = _stacked(data.columns)
        asked = _stacked(region.columns)
        cross = known @ asked.T + self._rest(data.inputs, region.inputs, m)
        explained = np.einsum("ab,ab->b", cross, cho_solve(self._factor(data), cross))
        return np.maximum(np.sum(asked**2, axis=1) + self.rest**2 - explained, 0.0).reshape(m, -1).T

    def weights(self, data: Rows) -> Array:
        """Covariance (k, k) of the weights after data at the given places, in usual sizes."""
        known = _stacked(data.columns)
        return np.eye(known.shape[1]) - known.T @ cho_solve(self._factor(data), known)

    def _factor(self, data: Rows):
        known = _stacked(data.columns)
        K = known @ known.T + self._rest(data.inputs, data.inputs, data.columns.shape[1])
        return cho_factor(K + self.noise**2 * np.eye(len(K)), lower=True)

    def _rest(self, A: Array, B: Array, m: int) -> Array:
        one = self.rest**2 * np.exp(-0.5 * cdist(A, B, "sqeuclidean") / self.lengthscale**2)
        return np.kron(np.eye(m), one)


def in_the_wrench(inputs: Array, steady: float, slope: float, outputs: int = 3) -> Rows:
    """Rows of a prior that is affine in the inputs (n, d), each output with weights of its own.

    steady, rad/s^2, and slope, rad/s^2 by unit of an input: usual sizes. An actuator that is too weak, a shifted centre
    of mass and a steady disturbance are of this form. Weights are in the order of the outputs, steady first.
    """
    affine = np.column_stack([np.full(len(inputs), steady), slope * inputs])
    columns = np.zeros((len(inputs), outputs, outputs * affine.shape[1]))
    for o in range(outputs):
        columns[:, o, o * affine.shape[1] : (o + 1) * affine.shape[1]] = affine
    return Rows(columns, inputs)


def _stacked(columns: Array) -> Array:
    """(m n, k), output by output."""
    return np.concatenate(list(columns.transpose(1, 0, 2)))
