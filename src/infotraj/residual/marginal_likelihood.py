"""The logarithm of the marginal likelihood beside a known prior covariance, with its gradient.

y ~ N(0, A + K + noise I), K a squared exponential with a lengthscale for each input, or one for all, and A given: that
of the affine functions. Source: C. E. Rasmussen and C. K. I. Williams, "Gaussian Processes for Machine Learning"
(2006), eq. 5.8 and 5.9.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_solve

from infotraj.rotations import Array


class MarginalLikelihood:
    """For inputs X (n, d), an output y (n,) of mean 0, and the known covariance A (n, n), in one set of units."""

    def __init__(self, X: Array, y: Array, A: Array, ard: bool) -> None:
        squares = (X[:, None, :] - X[None, :, :]) ** 2
        self._squares = squares.transpose(2, 0, 1) if ard else squares.sum(axis=2)[None]
        self._y, self._A = y, A

    def __call__(self, theta: Array) -> tuple[float, Array]:
        """Value and gradient at the log-parameters: signal variance, lengthscales, noise variance.

        Minus infinity, and a gradient of 0, where the covariance is singular.
        """
        signal, lengthscales, noise = np.exp(theta[0]), np.exp(theta[1:-1]), np.exp(theta[-1])
        weighted = self._squares / lengthscales[:, None, None] ** 2
        K = signal * np.exp(-0.5 * weighted.sum(axis=0))
        n = len(self._y)
        try:
            L = np.linalg.cholesky(self._A + K + noise * np.eye(n))
        except np.linalg.LinAlgError:
            return -np.inf, np.zeros_like(theta)
        alpha = cho_solve((L, True), self._y, check_finite=False)
        value = -0.5 * self._y @ alpha - np.log(np.diag(L)).sum() - 0.5 * n * np.log(2.0 * np.pi)
        M = np.outer(alpha, alpha) - cho_solve((L, True), np.eye(n), check_finite=False)
        pulled = M * K
        slopes = np.einsum("ab,iab->i", pulled, weighted)
        return float(value), 0.5 * np.array([pulled.sum(), *slopes, noise * np.trace(M)])
