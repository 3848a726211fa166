"""Posterior variance over a region after adding points, for many candidate sets of points (eq. 13 and 18).

The variance does not need the added outputs. With V = L^-1 K(X, Z) and S = K(A, A) + noise I - W^T W, W = L^-1 K(X, A),
the Schur complement of the added points A, it is diag K(Z, Z) - |V|^2 - |C^-1 R|^2 with R = K(A, Z) - W^T V and
S = C C^T. V belongs to the prior alone and is shared by all candidates.

Source: C. Chevalier, D. Ginsbourger, X. Emery, "Corrected kriging update formulae for batch-sequential data
assimilation" (2014); hyperparameters stay fixed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_triangular

from infotraj.errors import InputError, problem
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.rotations import Array

_PANEL = 256  # columns of the region at a time: 100 x 256 doubles are 0.2 MB, three of them stay in the L2 cache


class RegionVariance:
    """Variance of `gp` over `region` (r, d), ready to be asked for many sets of added points.

    It holds V, m n r doubles, in panels.
    """

    def __init__(self, gp: GaussianProcess, region: ArrayLike) -> None:
        region = np.asarray(region, dtype=float)
        if region.ndim != 2 or region.shape[1] != gp.d or len(region) == 0:
            raise ValueError(problem(f"a region of shape {region.shape}", f"(r, {gp.d}), r > 0", "Sample it again."))
        self.gp = gp
        self.before = gp.variance(region)
        # differences matter, not the origin: about it the squares below lose no digits
        self._centre = region.mean(axis=0)
        starts = range(0, len(region), _PANEL)
        panels = [region[start : start + _PANEL] for start in starts]
        self._columns = [slice(start, start + len(panel)) for start, panel in zip(starts, panels, strict=True)]
        self._X = [_rows(gp.X - self._centre, scale) for scale in gp.lengthscales]
        self._Z = [[_columns(panel - self._centre, scale) for panel in panels] for scale in gp.lengthscales]
        affine = gp.affine
        # covariance of the affine functions' weights with their values over a panel: what features are multiplied by
        self._A = [
            [] if affine is None else [affine.covariance[o] @ affine.features(panel).T for panel in panels]
            for o in range(gp.m)
        ]
        before = None if affine is None else affine.features(gp.X)
        self._V = [
            [
                solve_triangular(gp.L[o], self._kernel(self._X[o], before, o, p), lower=True)
                if gp.n
                else np.zeros((0, len(panel)))
                for p, panel in enumerate(panels)
            ]
            for o in range(gp.m)
        ]
        self._scratch: dict[tuple[int, int], tuple[Array, Array]] = {}

    def after(self, added: ArrayLike) -> Array:
        """Variance of the noise-free function over the region after adding points (q, d), (r, m)."""
        added = self._checked(added)
        variance = self.before.copy()
        features = None if self.gp.affine is None else self.gp.affine.features(added)
        for o in range(self.gp.m if len(added) else 0):
            rows, W, C = self._added(added, o)
            for p, columns in enumerate(self._columns):
                R = self._cross(rows, features, W, o, p)
                T = solve_triangular(C, R, lower=True, check_finite=False)
                variance[columns, o] -= np.einsum("qr,qr->r", T, T)
        return np.maximum(variance, 0.0)

    def sum_after(self, added: ArrayLike) -> Array:
        """Sum over the region of the variance after adding points (q, d), (m,).

        |C^-1 R|^2 is taken as the trace of S^-1 R R^T: a symmetric product instead of a triangular solve, which runs
        at half its speed.
        """
        added = self._checked(added)
        total = self.before.sum(axis=0)
        features = None if self.gp.affine is None else self.gp.affine.features(added)
        for o in range(self.gp.m if len(added) else 0):
            rows, W, C = self._added(added, o)
            gram = np.zeros((len(added), len(added)))
            for p in range(len(self._columns)):
                R = self._cross(rows, features, W, o, p)
                gram += R @ R.T
            half = solve_triangular(C, gram, lower=True, check_finite=False)
            total[o] -= np.trace(solve_triangular(C, half.T, lower=True, check_finite=False))
        return np.maximum(total, 0.0)

    def _added(self, added: Array, o: int) -> tuple[Array, Array, Array]:
        """Left kernel factor (q, d + 2), W (n, q) and C (q, q) of the added points for output o."""
        gp = self.gp
        centred = added - self._centre
        rows = _rows(centred, gp.lengthscales[o])
        columns = _columns(centred, gp.lengthscales[o])
        S = gp.signal_variance[o] * np.exp(np.minimum(rows @ columns, 0.0))
        S[np.diag_indices_from(S)] = gp.signal_variance[o] + gp.noise_variance[o]
        W = np.zeros((0, len(added)))
        if gp.n:
            W = gp.signal_variance[o] * np.exp(self._X[o] @ columns)
        if gp.affine is not None:
            weighted = gp.affine.covariance[o] @ gp.affine.features(added).T
            S += gp.affine.features(added) @ weighted
            W = W + gp.affine.features(gp.X) @ weighted
        if gp.n:
            W = solve_triangular(gp.L[o], W, lower=True, check_finite=False)
            S -= W.T @ W
        try:
            return rows, W, np.linalg.cholesky(S)
        except np.linalg.LinAlgError:
            raise InputError(
                problem(
                    f"added points whose covariance is singular at noise variance {gp.noise_variance[o]:g}",
                    "points that the noise keeps apart",
                    "Raise the noise variance or thin the points.",
                )
            ) from None

    def _kernel(self, rows: Array, features: Array | None, o: int, panel: int) -> Array:
        """Prior covariance of points with one panel, (points, columns)."""
        K = self.gp.signal_variance[o] * np.exp(rows @ self._Z[o][panel])
        return K if features is None else K + features @ self._A[o][panel]

    def _cross(self, rows: Array, features: Array | None, W: Array, o: int, panel: int) -> Array:
        """R of one panel, (q, columns), in memory that the next call overwrites."""
        Z = self._Z[o][panel]
        shape = (len(rows), Z.shape[1])
        if shape not in self._scratch:
            self._scratch[shape] = (np.empty(shape), np.empty(shape))
        K, explained = self._scratch[shape]
        np.matmul(rows, Z, out=K)
        np.exp(K, out=K)
        K *= self.gp.signal_variance[o]
        if features is not None:
            K += np.matmul(features, self._A[o][panel], out=explained)
        if len(W):
            np.matmul(W.T, self._V[o][panel], out=explained)
            K -= explained
        return K

    def _checked(self, added: ArrayLike) -> Array:
        added = np.asarray(added, dtype=float)
        if added.ndim != 2 or added.shape[1] != self.gp.d:
            raise ValueError(problem(f"added points of shape {added.shape}", f"(q, {self.gp.d})", "Reshape."))
        return added


def _rows(A: Array, lengthscales: Array) -> Array:
    """(a, d + 2) such that _rows(A) @ _columns(B) is -1/2 |A - B|^2 in lengthscales: a kernel by one product."""
    A = A / lengthscales
    return np.column_stack([A, -0.5 * np.einsum("ad,ad->a", A, A), np.ones(len(A))])


def _columns(B: Array, lengthscales: Array) -> Array:
    """(d + 2, b), the counterpart of `_rows`."""
    B = B / lengthscales
    return np.ascontiguousarray(np.column_stack([B, np.ones(len(B)), -0.5 * np.einsum("bd,bd->b", B, B)]).T)
