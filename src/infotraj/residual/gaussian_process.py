"""Gaussian process regression: independent outputs, squared exponential kernel with a lengthscale for each input.

Source: C. E. Rasmussen and C. K. I. Williams, "Gaussian Processes for Machine Learning" (2006), Alg. 2.1. It models g
of f = h + g (eq. 3); its mean is mu of eq. 19, its variance sigma of eq. 13.
"""

from __future__ import annotations

import io
import os
import struct
import zipfile
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cho_solve, solve_triangular
from scipy.spatial.distance import cdist

from infotraj.errors import InputError, problem
from infotraj.residual.affine_prior import AffinePrior
from infotraj.rotations import Array
from infotraj.writing import whole

# what numpy and zipfile raise on a damaged archive
_UNREADABLE = (
    OSError,
    EOFError,
    ValueError,
    AttributeError,
    TypeError,
    KeyError,
    RuntimeError,
    struct.error,
    zlib.error,
    zipfile.BadZipFile,
)
_STORED = ("X", "Y", "lengthscales", "signal_variance", "noise_variance", "prior_mean")
_AFFINE = ("affine_origin", "affine_covariance")  # beside them where there is an affine prior


class MeanArrays(NamedTuple):
    """What `residual.compiled.mean_and_jacobian` takes between the query and its outputs, in its order."""

    points: Array
    alpha: Array
    inverse_lengthscales_squared: Array
    signal_variance: Array
    constant: Array
    slopes: Array


@dataclass(frozen=True, eq=False)
class GaussianProcess:
    """Posterior of m independent Gaussian processes over d inputs given n points; n = 0 is the prior.

    X (n, d) inputs; Y (n, m) outputs; lengthscales (m, d) in units of X; signal_variance, noise_variance (m,) in
    squared units of Y; prior_mean (m,) in units of Y; affine: a prior on affine functions that are added to the squared
    exponential's, None for none. L (m, n, n) is the lower Cholesky factor of K + noise I, and
    alpha (m, n) the weights (K + noise I)^-1 (y - prior_mean); both are computed here. ValueError where shapes or
    signs do not fit, InputError where the covariance is singular.
    """

    X: Array
    Y: Array
    lengthscales: Array
    signal_variance: Array
    noise_variance: Array
    prior_mean: Array
    affine: AffinePrior | None = None
    L: Array = field(default=None, repr=False)  # type: ignore[arg-type]  # __post_init__ fills it
    alpha: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        for name in _STORED:
            object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name), dtype=float))
        self._check()
        if self.L is None:
            object.__setattr__(self, "L", _cholesky(self._covariance(self.X) + self._noise(self.n)))
        alpha = np.empty((self.m, self.n))
        for o in range(self.m if self.n else 0):
            alpha[o] = cho_solve((self.L[o], True), self.Y[:, o] - self.prior_mean[o], check_finite=False)
        object.__setattr__(self, "alpha", alpha)

    def _check(self) -> None:
        shapes = {name: getattr(self, name).shape for name in _STORED}
        m, d = self.lengthscales.shape if self.lengthscales.ndim == 2 else (-1, -1)
        n = self.X.shape[0] if self.X.ndim == 2 else -1
        expected = dict(zip(_STORED, [(n, d), (n, m), (m, d), (m,), (m,), (m,)], strict=True))
        if shapes != expected:
            raise ValueError(
                problem(
                    f"Gaussian process of shapes {shapes}",
                    "X (n, d), Y (n, m), lengthscales (m, d), the rest (m,)",
                    "Reshape.",
                )
            )
        if not all(np.isfinite(getattr(self, name)).all() for name in _STORED):
            raise ValueError(
                problem("Gaussian process with NaN or infinite numbers", "finite numbers", "Drop those rows.")
            )
        if self.affine is not None and self.affine.covariance.shape != (m, d + 1, d + 1):
            found = f"an affine prior of {self.affine.covariance.shape}"
            raise ValueError(problem(found, f"{(m, d + 1, d + 1)}", "Compute it for these inputs and outputs."))
        if (self.lengthscales <= 0).any() or (self.signal_variance <= 0).any() or (self.noise_variance < 0).any():
            raise ValueError(
                problem(
                    f"lengthscales {self.lengthscales.tolist()}, signal variance {self.signal_variance.tolist()}, "
                    f"noise variance {self.noise_variance.tolist()}",
                    "positive numbers (the noise may be 0)",
                    "Fit the hyperparameters again.",
                )
            )

    @classmethod
    def empty(
        cls,
        lengthscales: ArrayLike,
        signal_variance: ArrayLike,
        noise_variance: ArrayLike,
        prior_mean: ArrayLike | None = None,
    ) -> GaussianProcess:
        """The prior: no data, mean `prior_mean` (0 unless told), shapes as in the class."""
        lengthscales = np.atleast_2d(np.asarray(lengthscales, dtype=float))
        m, d = lengthscales.shape
        mean = np.zeros(m) if prior_mean is None else np.asarray(prior_mean, dtype=float)
        return cls(
            np.empty((0, d)),
            np.empty((0, m)),
            lengthscales,
            np.asarray(signal_variance),
            np.asarray(noise_variance),
            mean,
        )

    @property
    def n(self) -> int:
        """Number of points."""
        return self.X.shape[0]

    @property
    def d(self) -> int:
        """Number of inputs."""
        return self.X.shape[1]

    @property
    def m(self) -> int:
        """Number of outputs."""
        return self.Y.shape[1]

    @property
    def mean_arrays(self) -> MeanArrays:
        """The arrays for compiled code; points is (d, n), because its inner loops run over the points."""
        return MeanArrays(
            np.ascontiguousarray(self.X.T),
            self.alpha,
            1.0 / self.lengthscales**2,
            self.signal_variance,
            *self.affine_mean,
        )

    @property
    def affine_mean(self) -> tuple[Array, Array]:
        """Constant (m,) and slopes (m, d) of the part of the posterior mean that is affine in the input."""
        if self.affine is None:
            return self.prior_mean, np.zeros((self.m, self.d))
        weights = self.affine.weights(self.X, self.alpha)
        slopes = np.ascontiguousarray(weights[:, 1:])
        return self.prior_mean + weights[:, 0] - slopes @ self.affine.origin, slopes

    def _covariance(self, A: Array, B: Array | None = None) -> Array:
        """Prior covariance k(A, B), (m, a, b)."""
        known = self._remainder(A, A if B is None else B)
        return known if self.affine is None else known + self.affine.cross(A, A if B is None else B)

    def _remainder(self, A: Array, B: Array) -> Array:
        """The squared exponential's part of it."""
        return np.stack(
            [
                s * np.exp(-0.5 * cdist(A / scale, B / scale, "sqeuclidean"))
                for s, scale in zip(self.signal_variance, self.lengthscales, strict=True)
            ]
        )

    def prior_variance(self, U: Array) -> Array:
        """Prior variance at U (k, d), (k, m)."""
        signal = np.broadcast_to(self.signal_variance, (len(U), self.m))
        return signal if self.affine is None else signal + self.affine.variance(U).T

    def _noise(self, n: int) -> Array:
        return self.noise_variance[:, None, None] * np.eye(n)

    def _whitened(self, U: Array) -> Array:
        """L^-1 k(X, U), (m, n, k)."""
        return whiten(self.L, self._covariance(self.X, U))

    def mean(self, U: ArrayLike) -> Array:
        """Posterior mean at U (k, d), (k, m)."""
        U = self._queries(U)
        return self.prior_mean + np.einsum("okn,on->ko", self._covariance(U, self.X), self.alpha)

    def variance(self, U: ArrayLike) -> Array:
        """Posterior variance of the noise-free function at U (k, d), (k, m); add noise_variance for a measurement."""
        V = self._whitened(self._queries(U))
        return np.maximum(self.prior_variance(self._queries(U)) - np.einsum("onk,onk->ko", V, V), 0.0)

    def covariance(self, U: ArrayLike) -> Array:
        """Posterior covariance of the noise-free function among the points U (k, d), (m, k, k)."""
        U = self._queries(U)
        V = self._whitened(U)
        return self._covariance(U) - V.transpose(0, 2, 1) @ V

    def condition(self, X_add: ArrayLike, Y_add: ArrayLike) -> GaussianProcess:
        """The posterior after adding X_add (q, d), Y_add (q, m), hyperparameters fixed.

        The factor grows by a block (Golub and Van Loan, Matrix Computations, sec. 4.2): n^2 q + n q^2 + q^3 / 3
        operations an output instead of (n + q)^3 / 3.
        """
        X_add, Y_add = self._queries(X_add), np.asarray(Y_add, dtype=float)
        n, q = self.n, len(X_add)
        if Y_add.shape != (q, self.m):
            raise ValueError(problem(f"outputs of shape {Y_add.shape}", f"{(q, self.m)}", "Give a row an input."))
        below = self._whitened(X_add).transpose(0, 2, 1)
        L = np.zeros((self.m, n + q, n + q))
        L[:, :n, :n] = self.L
        L[:, n:, :n] = below
        L[:, n:, n:] = _cholesky(self._covariance(X_add) + self._noise(q) - below @ below.transpose(0, 2, 1))
        return GaussianProcess(
            np.concatenate([self.X, X_add]),
            np.concatenate([self.Y, Y_add]),
            self.lengthscales,
            self.signal_variance,
            self.noise_variance,
            self.prior_mean,
            self.affine,
            L,
        )

    def _queries(self, U: ArrayLike) -> Array:
        U = np.asarray(U, dtype=float)
        if U.ndim != 2 or U.shape[1] != self.d:
            raise ValueError(problem(f"inputs of shape {U.shape}", f"(k, {self.d})", "Give one row a point."))
        return U

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write data and hyperparameters as .npz; the file appears whole or not at all."""
        stored: dict[str, Any] = {name: getattr(self, name) for name in _STORED} | self._affine_arrays()
        with whole(Path(path)) as part, part.open("wb") as stream:
            np.savez(stream, **stored)

    def _affine_arrays(self) -> dict[str, Array]:
        if self.affine is None:
            return {}
        return dict(zip(_AFFINE, (self.affine.origin, self.affine.covariance), strict=True))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> GaussianProcess:
        """Read what `save` wrote. InputError where the file is missing, broken or holds something else."""
        expected, remedy = f"a .npz model with the arrays {', '.join(_STORED)}", "Fit and save the model again."
        try:
            # from memory: numpy leaves the file open where it is not a zip
            with np.load(io.BytesIO(Path(path).read_bytes()), allow_pickle=False) as stored:
                if missing := [name for name in _STORED if name not in stored]:
                    raise InputError(problem(f"{path}: no {', '.join(missing)}", expected, remedy))
                arrays = {name: stored[name] for name in _STORED}
                affine = [stored[name] for name in _AFFINE if name in stored]
        except _UNREADABLE as error:
            raise InputError(
                problem(f"{path}: cannot be read ({type(error).__name__}: {error})", expected, remedy)
            ) from None
        try:
            return cls(**arrays, affine=AffinePrior(*affine) if affine else None)
        except (ValueError, TypeError) as error:
            raise InputError(problem(f"{path}: {error}", expected, remedy)) from None


def whiten(L: Array, K: Array) -> Array:
    """L^-1 K for stacks of lower triangular L (m, n, n) and K (m, n, k)."""
    if K.size == 0:
        return np.zeros_like(K)
    return np.stack([solve_triangular(a, b, lower=True, check_finite=False) for a, b in zip(L, K, strict=True)])


def _cholesky(K: Array) -> Array:
    try:
        return np.asarray(np.linalg.cholesky(K), dtype=float)
    except np.linalg.LinAlgError:
        raise InputError(
            problem(
                f"a covariance of {K.shape[-1]} points that is singular",
                "a positive definite one",
                "Raise the noise variance or drop points that repeat.",
            )
        ) from None
