"""Hyperparameters of the Gaussian process: maximum a posteriori, and draws around it to study their uncertainty.

The marginal likelihood and its gradient are scikit-learn's (kernel ConstantKernel * RBF + WhiteKernel, outputs
independent); the log-prior is added and the sum is maximised by L-BFGS-B in log-parameters. Inputs and outputs are
scaled to unit spread first, so that one prior and one set of bounds serve all.

Why a prior: 20 points along one flight do not determine six lengthscales. The likelihood is flat in most directions,
and its maximum then lies at a bound: a lengthscale of infinity (the input is ignored, its variance costs nothing) or
noise of zero. A weak log-normal prior keeps what the data leave open near "neighbours half a spread apart agree"; with
100 points it hardly matters. In d dimensions two points differ by sqrt(2 d) spreads, hence the median sqrt(d); see
C. Hvarfner et al., "Vanilla Bayesian optimization performs great in high dimensions" (ICML 2024), for this scaling.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from infotraj.errors import InputError, problem
from infotraj.residual.affine_prior import AffinePrior
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.marginal_likelihood import MarginalLikelihood
from infotraj.rotations import Array

Bounds = tuple[float, float]

_LARGE = 1e25  # objective where the covariance is singular: the line search turns back
_STEP = 1e-3  # of log-parameters, for second derivatives from first ones
_WIDEST = 1.5  # standard deviation of a log-parameter that neither data nor prior determine


@dataclass(frozen=True)
class LogNormalPrior:
    """Medians in scaled units, spreads in natural logarithms; the lengthscale's median is multiplied by sqrt(d).

    Variances are relative to the variance of the output. The numbers are assumed, wide enough (a factor 3 to 4 either
    way within one spread) that 100 points overrule them.
    """

    lengthscale: float = 1.0
    lengthscale_spread: float = 1.0
    signal: float = 1.0
    signal_spread: float = 1.5
    noise: float = 0.05
    noise_spread: float = 1.5

    def medians(self, lengthscales: int, d: int) -> Array:
        """Logarithms of the medians: signal variance, lengthscales, noise variance, (lengthscales + 2,)."""
        return np.log([self.signal, *[self.lengthscale * np.sqrt(d)] * lengthscales, self.noise])

    def spreads(self, lengthscales: int) -> Array:
        """Spreads in the same order."""
        return np.array([self.signal_spread, *[self.lengthscale_spread] * lengthscales, self.noise_spread])


DEFAULT_PRIOR = LogNormalPrior()

# Of what an affine prior leaves, in units of the output (rad/s^2): a remainder of 0.3 and noise of 0.2, within a factor
# of 1.2 each. Found on omav_a to omav_c, base seed 2, and tight for a reason: in the first flight feedback holds the
# residual, so that "achieved minus commanded" is nearly minus the command, and a likelihood left to itself explains it
# by a slope of -1 that is not there (docs/study.md).
REMAINDER_PRIOR = LogNormalPrior(signal=0.09, signal_spread=0.3, noise=0.04, noise_spread=0.3)


@dataclass(frozen=True)
class SearchBounds:
    """Limits in scaled units: lengthscales in spreads of the inputs, variances in variances of the output."""

    lengthscale: Bounds = (0.05, 100.0)
    signal: Bounds = (1e-3, 100.0)
    noise: Bounds = (1e-5, 2.0)

    def logarithms(self, lengthscales: int) -> Array:
        """Lower and upper limits of the log-parameters, (lengthscales + 2, 2)."""
        return np.log([self.signal, *[self.lengthscale] * lengthscales, self.noise])


DEFAULT_BOUNDS = SearchBounds()


class _NegativeLogPosterior:
    """Value and gradient in log-parameters for one output y (n,) at inputs X (n, d), both scaled.

    known: covariance (n, n) of y beside that of the squared exponential, in the scaled units; None: none.
    """

    def __init__(self, X: Array, y: Array, ard: bool, prior: LogNormalPrior | None, known: Array | None = None) -> None:
        d = X.shape[1]
        self.lengthscales = d if ard else 1
        self._likelihood = _likelihood(X, y, ard) if known is None else MarginalLikelihood(X, y, known, ard)
        guide = prior or DEFAULT_PRIOR
        self.median, self.spread = guide.medians(self.lengthscales, d), guide.spreads(self.lengthscales)
        self._with_prior = prior is not None

    def __call__(self, theta: Array) -> tuple[float, Array]:
        value, gradient = self._likelihood(theta)
        if not np.isfinite(value):
            return _LARGE, np.zeros_like(theta)
        z = (theta - self.median) / self.spread if self._with_prior else np.zeros_like(theta)
        return 0.5 * float(z @ z) - float(value), z / self.spread - gradient

    def minimum(self, bounds: Array, rng: np.random.Generator, restarts: int) -> Array:
        """Best log-parameters of a search from the median and of `restarts` from random draws about it."""
        from scipy.optimize import minimize

        starts = self.median + self.spread * rng.standard_normal((restarts + 1, len(self.median)))
        starts[0] = self.median
        # A search that stops at its limit of iterations still returns its best point; the best of all is kept.
        found = [
            minimize(self, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": 100, "ftol": 1e-8})
            for start in np.clip(starts, bounds[:, 0], bounds[:, 1])
        ]
        return np.asarray(min(found, key=lambda result: result.fun).x)

    def hessian(self, theta: Array) -> Array:
        """Second derivatives by central differences of the gradient, symmetrised."""
        steps = _STEP * np.eye(len(theta))
        H = np.stack([(self(theta + s)[1] - self(theta - s)[1]) / (2.0 * _STEP) for s in steps])
        return 0.5 * (H + H.T)


def _likelihood(X: Array, y: Array, ard: bool) -> Callable[[Array], tuple[float, Array]]:
    """scikit-learn's log-marginal likelihood and its gradient."""
    from sklearn.gaussian_process import GaussianProcessRegressor  # late: 0.4 s
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    kernel = ConstantKernel(1.0) * RBF(np.ones(X.shape[1]) if ard else 1.0) + WhiteKernel(0.1)
    # optimizer=None: the search is ours, so scikit-learn has nothing to warn about
    regressor = GaussianProcessRegressor(kernel, alpha=0.0, optimizer=None).fit(X, y)
    return partial(regressor.log_marginal_likelihood, eval_gradient=True, clone_kernel=False)


def fit(
    X: ArrayLike,
    Y: ArrayLike,
    rng: np.random.Generator,
    *,
    restarts: int = 2,
    ard: bool = True,
    prior: LogNormalPrior | None = DEFAULT_PRIOR,
    bounds: SearchBounds = DEFAULT_BOUNDS,
    input_scale: ArrayLike | None = None,
    prior_mean: ArrayLike | None = None,
    affine: AffinePrior | None = None,
) -> GaussianProcess:
    """Gaussian process for inputs X (n, d), outputs Y (n, m), n >= 2, with fitted hyperparameters.

    ard: a lengthscale for each input, else one for all (in spreads). prior None: maximum likelihood. input_scale (d,):
    spread of each input in the units of X; None takes the data's, which misjudges an input that hardly moved in this
    flight: give the physical spread then. prior_mean (m,): None takes the mean of Y, or 0 beside an affine prior, which
    holds the constant. affine: what is known of the outputs, kept as it is; the variances of `prior` and `bounds` are
    then in units of Y. InputError with fewer than 2 rows or numbers that are not finite.
    """
    X, Y = np.asarray(X, dtype=float), np.asarray(Y, dtype=float)
    if X.ndim != 2 or Y.ndim != 2 or len(X) != len(Y):
        raise ValueError(problem(f"X {X.shape}, Y {Y.shape}", "(n, d) and (n, m)", "Give each row an output."))
    if len(X) < 2 or not (np.isfinite(X).all() and np.isfinite(Y).all()):
        raise InputError(
            problem(f"{len(X)} training rows", "at least 2, all finite", "Drop rows with NaN or log a longer flight.")
        )
    own = Y.mean(axis=0) if affine is None else np.zeros(Y.shape[1])
    mean = own if prior_mean is None else np.asarray(prior_mean, dtype=float)
    x_scale, y_scale = _input_scale(X, input_scale), _spread(Y) if affine is None else np.ones(Y.shape[1])
    known = [None] * Y.shape[1] if affine is None else affine.cross(X, X)
    lengthscales, signal, noise = [], [], []
    for o in range(Y.shape[1]):
        objective = _NegativeLogPosterior(X / x_scale, (Y[:, o] - mean[o]) / y_scale[o], ard, prior, known[o])
        theta = objective.minimum(bounds.logarithms(objective.lengthscales), rng, restarts)
        s, scales, e = _natural(theta, x_scale, y_scale[o])
        lengthscales.append(scales)
        signal.append(s)
        noise.append(e)
    return GaussianProcess(X, Y, np.array(lengthscales), np.array(signal), np.array(noise), mean, affine)


def sample_hyperparameters(
    gp: GaussianProcess,
    rng: np.random.Generator,
    count: int,
    *,
    ard: bool = True,
    prior: LogNormalPrior | None = DEFAULT_PRIOR,
    bounds: SearchBounds = DEFAULT_BOUNDS,
    input_scale: ArrayLike | None = None,
) -> list[GaussianProcess]:
    """`count` Gaussian processes on the data of `gp` with hyperparameters drawn about its own.

    Laplace approximation: normal in log-parameters, precision the second derivatives of the negative log-posterior
    (Rasmussen and Williams, sec. 3.4), a direction without curvature limited to a spread of 1.5 and draws to the
    bounds. Give the options that `fit` had; `gp` should hold the data that it was fitted to.
    """
    if gp.n < 2 or gp.affine is not None:
        found = f"a process with {gp.n} points" + (" and an affine prior" if gp.affine is not None else "")
        raise ValueError(problem(found, "at least 2 points and none", "Fit it to data first, without one."))
    x_scale, y_scale = _input_scale(gp.X, input_scale), _spread(gp.Y)
    natural = []
    for o in range(gp.m):
        objective = _NegativeLogPosterior(gp.X / x_scale, (gp.Y[:, o] - gp.prior_mean[o]) / y_scale[o], ard, prior)
        limits = bounds.logarithms(objective.lengthscales)
        scaled = (gp.lengthscales[o] / x_scale)[: objective.lengthscales]
        variances = np.array([gp.signal_variance[o], gp.noise_variance[o]]) / y_scale[o] ** 2
        theta = np.clip(np.log([variances[0], *scaled, max(variances[1], 1e-300)]), *limits.T)
        precision, directions = np.linalg.eigh(objective.hessian(theta))
        spread = 1.0 / np.sqrt(np.maximum(precision, _WIDEST**-2))
        draws = theta + (rng.standard_normal((count, len(theta))) * spread) @ directions.T
        natural.append([_natural(t, x_scale, y_scale[o]) for t in np.clip(draws, *limits.T)])
    return [
        GaussianProcess(
            gp.X,
            gp.Y,
            np.array([outputs[k][1] for outputs in natural]),
            np.array([outputs[k][0] for outputs in natural]),
            np.array([outputs[k][2] for outputs in natural]),
            gp.prior_mean,
        )
        for k in range(count)
    ]


def _natural(theta: Array, x_scale: Array, y_scale: float) -> tuple[float, Array, float]:
    """Signal variance, lengthscales (d,), noise variance in the units of the data."""
    values = np.exp(theta)
    return values[0] * y_scale**2, values[1:-1] * x_scale, values[-1] * y_scale**2


def _input_scale(X: Array, given: ArrayLike | None) -> Array:
    if given is None:
        return _spread(X)
    scale = np.broadcast_to(np.asarray(given, dtype=float), X.shape[1:])
    if not (np.isfinite(scale) & (scale > 0)).all():
        raise ValueError(problem(f"input_scale {scale.tolist()}", "positive numbers", "Give each input's spread."))
    return scale


def _spread(A: Array) -> Array:
    """Standard deviation of each column; 1 for a column that is constant, which has no scale of its own."""
    spread = A.std(axis=0)
    return np.where(spread > 1e-12 * np.maximum(np.abs(A).max(axis=0), 1e-12), spread, 1.0)
