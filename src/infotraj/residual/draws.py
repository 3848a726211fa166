"""Draws g' of the Gaussian process posterior for simulations (eq. 12): one function a flight, or fresh numbers a call.

The paper's g' can be read in two ways. `PosteriorDraws` are consistent functions: the same input always gives the same
value, neighbours agree. `MarginalDraws` draw every value anew from its own marginal: white noise along a flight.

Source of the first: J. T. Wilson et al., "Efficiently sampling functions from Gaussian process posteriors" (ICML 2020):
a prior draw from random Fourier features (Rahimi and Recht, NIPS 2007) plus the exact kernel's update (Matheron).
Each draw has its own frequencies, so that moments over many draws are exact whatever the number of features; a single
draw is a sum of few waves and deviates from a Gaussian process. Inside a region that is known beforehand a Nystrom
basis of the posterior is more accurate at the same cost; not built, because a rollout may leave the region.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_solve

from infotraj.errors import problem
from infotraj.residual.compiled import draw_value, marginal_value, prior_draw_value
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.rotations import Array


class DrawArrays(NamedTuple):
    """What `residual.compiled.draw_value` takes between the query and the output, in its order, for one draw."""

    frequencies: NDArray[np.float32]
    phases: NDArray[np.float32]
    amplitudes: NDArray[np.float32]
    update: Array
    points: Array
    inverse_lengthscales_squared: Array
    signal_variance: Array
    constant: Array
    slopes: Array


@dataclass(frozen=True, eq=False)
class PosteriorDraws:
    """`count` functions drawn from a posterior, each a draw of all m outputs.

    The draw is sum_f amplitude_f cos(2 pi (frequency_f . u + phase_f)) + k(u, X) update + constant + slopes u, k being
    the squared exponential. frequencies (count, m, d, F) in turns a unit of u, phases and amplitudes (count, m, F), all
    single precision (a cosine costs a tenth; a value is good to about 1e-6 of the signal's standard deviation); update
    (count, m, n); points (d, n); constant (count, m) and slopes (count, m, d), the affine part's own draw included.
    """

    frequencies: NDArray[np.float32]
    phases: NDArray[np.float32]
    amplitudes: NDArray[np.float32]
    update: Array
    points: Array
    inverse_lengthscales_squared: Array
    signal_variance: Array
    constant: Array
    slopes: Array

    @classmethod
    def sample(cls, gp: GaussianProcess, rng: np.random.Generator, draws: int, features: int = 512) -> PosteriorDraws:
        """Draw `draws` functions with `features` waves each.

        A wave a cos + b sin with normal a and b is one cosine of Rayleigh amplitude and uniform phase: half the
        cosines of the usual pairs, and a variance that is exact for any set of frequencies.
        """
        if draws < 1 or features < 1:
            raise ValueError(problem(f"{draws} draws of {features} features", "at least 1 of each", "Ask for more."))
        turns = rng.standard_normal((draws, gp.m, gp.d, features), dtype=np.float32)
        turns /= (2.0 * np.pi * gp.lengthscales[:, :, None]).astype(np.float32)
        phases = rng.random((draws, gp.m, features), dtype=np.float32)
        scale = np.sqrt(2.0 * gp.signal_variance / features)[:, None].astype(np.float32)
        amplitudes = scale * np.sqrt(rng.standard_exponential((draws, gp.m, features), dtype=np.float32))
        noise = np.sqrt(gp.noise_variance) * rng.standard_normal((draws, gp.n, gp.m))

        residual = np.empty((draws, gp.n, gp.m))
        _prior_values(gp.X, turns, phases, amplitudes, residual)
        weights = np.zeros((draws, gp.m, gp.d + 1)) if gp.affine is None else gp.affine.sample(rng, draws)
        if gp.affine is not None:
            residual += np.einsum("ni,koi->kno", gp.affine.features(gp.X), weights)
        residual = gp.Y - gp.prior_mean - residual - noise
        update = np.empty((draws, gp.m, gp.n))
        for o in range(gp.m if gp.n else 0):
            update[:, o] = cho_solve((gp.L[o], True), residual[:, :, o].T, check_finite=False).T
        constant = np.repeat(gp.prior_mean[None], draws, axis=0)
        if gp.affine is not None:
            weights = weights + np.stack([gp.affine.weights(gp.X, one) for one in update])
            constant = constant + weights[:, :, 0] - weights[:, :, 1:] @ gp.affine.origin
        arrays = gp.mean_arrays
        return cls(
            turns,
            phases,
            amplitudes,
            update,
            arrays.points,
            arrays.inverse_lengthscales_squared,
            arrays.signal_variance,
            constant,
            np.ascontiguousarray(weights[:, :, 1:]),
        )

    @property
    def count(self) -> int:
        """Number of draws."""
        return len(self.update)

    def part(self, start: int, stop: int) -> PosteriorDraws:
        """The draws from `start` to before `stop` alone (views, no copies)."""
        own = ("frequencies", "phases", "amplitudes", "update", "constant", "slopes")
        return replace(self, **{name: getattr(self, name)[start:stop] for name in own})

    def one(self, k: int) -> DrawArrays:
        """Arrays of draw k for `compiled.draw_value` (views, no copies)."""
        return DrawArrays(
            self.frequencies[k],
            self.phases[k],
            self.amplitudes[k],
            self.update[k],
            self.points,
            self.inverse_lengthscales_squared,
            self.signal_variance,
            self.constant[k],
            self.slopes[k],
        )

    def __call__(self, U: ArrayLike) -> Array:
        """Values of every draw, (count, k, m), at inputs (k, d) common to all or (count, k, d), a set a draw."""
        U = _queries(U, self.count, self.points.shape[0])
        out = np.empty((self.count, U.shape[1], self.constant.shape[1]))
        _draw_values(
            U,
            self.frequencies,
            self.phases,
            self.amplitudes,
            self.update,
            self.points,
            self.inverse_lengthscales_squared,
            self.signal_variance,
            self.constant,
            self.slopes,
            out,
        )
        return out


@dataclass(frozen=True, eq=False)
class MarginalDraws:
    """Posterior mean plus standard deviation times a fresh normal number, independent at every query and call."""

    gp: GaussianProcess
    rng: np.random.Generator
    count: int

    def __post_init__(self) -> None:
        if self.gp.affine is not None:
            remedy = "Draw from `PosteriorDraws`."
            raise ValueError(problem("marginal draws of a process with an affine prior", "one without", remedy))

    @property
    def arrays(self) -> tuple[Array, ...]:
        """What `residual.compiled.marginal_value` takes between the query and the normal numbers, in its order."""
        points, alpha, inverse_squared, signal_variance, constant, _ = self.gp.mean_arrays
        return points, alpha, self.gp.L, inverse_squared, signal_variance, constant

    def __call__(self, U: ArrayLike) -> Array:
        """Fresh values, (count, k, m), at inputs (k, d) common to all or (count, k, d)."""
        U = _queries(U, self.count, self.gp.d)
        out = np.empty((*U.shape[:2], self.gp.m))
        normal = self.rng.standard_normal(out.shape)
        points, alpha, L, inverse_squared, variance, prior_mean = self.arrays
        _marginal_values(U, points, alpha, L, inverse_squared, variance, prior_mean, normal, out)
        return out


def _queries(U: ArrayLike, count: int, d: int) -> Array:
    U = np.asarray(U, dtype=float)
    if U.ndim == 2:
        U = np.broadcast_to(U, (count, *U.shape))
    if U.ndim != 3 or len(U) != count or U.shape[2] != d:
        raise ValueError(problem(f"inputs of shape {U.shape}", f"(k, {d}) or ({count}, k, {d})", "Reshape."))
    return np.ascontiguousarray(U)


@njit(cache=True)
def _prior_values(X, frequencies, phases, amplitudes, out):
    for k in range(out.shape[0]):
        for j in range(X.shape[0]):
            prior_draw_value(X[j], frequencies[k], phases[k], amplitudes[k], out[k, j])


@njit(cache=True)
def _draw_values(U, frequencies, phases, amplitudes, update, points, inverse_squared, variance, constant, slopes, out):
    for k in range(U.shape[0]):
        for j in range(U.shape[1]):
            draw_value(
                U[k, j],
                frequencies[k],
                phases[k],
                amplitudes[k],
                update[k],
                points,
                inverse_squared,
                variance,
                constant[k],
                slopes[k],
                out[k, j],
            )


@njit(cache=True)
def _marginal_values(U, points, alpha, L, inverse_squared, variance, prior_mean, normal, out):
    scratch = np.empty(points.shape[1])
    for k in range(U.shape[0]):
        for j in range(U.shape[1]):
            marginal_value(
                U[k, j], points, alpha, L, inverse_squared, variance, prior_mean, normal[k, j], scratch, out[k, j]
            )
