"""A Gaussian prior on functions that are affine in the input: what is known of the residual before any flight.

    a_o(u) = w_o . [1, u - origin],   w_o ~ N(0, covariance_o)

Added to a squared exponential it is the explicit basis of C. E. Rasmussen and C. K. I. Williams, "Gaussian Processes
for Machine Learning" (2006), sec. 2.7: the weights are integrated out, so that points teach them and the remainder at
once. Effects that act on the wrench are of this form (`models.wrench_columns`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj.errors import problem
from infotraj.rotations import Array


@dataclass(frozen=True, eq=False)
class AffinePrior:
    """origin (d,) in units of the inputs; covariance (m, d + 1, d + 1) of the weights, constant first.

    Weights are in units of the output, and of the output by unit of each input. ValueError where the shapes do not fit
    or a covariance is not one.
    """

    origin: Array
    covariance: Array

    def __post_init__(self) -> None:
        origin, covariance = np.asarray(self.origin, dtype=float), np.asarray(self.covariance, dtype=float)
        size = origin.size + 1
        if origin.ndim != 1 or covariance.ndim != 3 or covariance.shape[1:] != (size, size):
            found = f"an affine prior of shapes {origin.shape} and {covariance.shape}"
            raise ValueError(problem(found, "(d,) and (m, d + 1, d + 1)", "Reshape."))
        least = np.linalg.eigvalsh(covariance).min() if np.isfinite(covariance).all() else -np.inf
        if not np.allclose(covariance, covariance.transpose(0, 2, 1)) or least < -1e-9 * np.abs(covariance).max():
            raise ValueError(
                problem("an affine prior whose covariance is none", "symmetric and not negative", "Compute it anew.")
            )
        object.__setattr__(self, "origin", origin)
        object.__setattr__(self, "covariance", covariance)

    def features(self, U: Array) -> Array:
        """[1, u - origin] of each input, (k, d + 1)."""
        return np.column_stack([np.ones(len(U)), U - self.origin])

    def cross(self, A: Array, B: Array) -> Array:
        """Covariance of the affine functions between A (a, d) and B (b, d), (m, a, b)."""
        return self.features(A) @ self.covariance @ self.features(B).T

    def variance(self, U: Array) -> Array:
        """Their variance at U (k, d), (m, k)."""
        features = self.features(U)
        return np.einsum("ki,oij,kj->ok", features, self.covariance, features)

    def weights(self, X: Array, alpha: Array) -> Array:
        """Mean weights (m, d + 1) that kernel weights alpha (m, n) at points X (n, d) amount to."""
        return np.einsum("oij,nj,on->oi", self.covariance, self.features(X), alpha)

    def sample(self, rng: np.random.Generator, count: int) -> Array:
        """Weights of `count` draws, (count, m, d + 1)."""
        values, vectors = np.linalg.eigh(self.covariance)
        normal = rng.standard_normal((count, *values.shape))
        return np.einsum("oij,koj->koi", vectors, np.sqrt(np.maximum(values, 0.0)) * normal)
