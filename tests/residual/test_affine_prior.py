"""The affine prior: Bayesian linear regression where there is nothing else, and the same posterior by every way."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from infotraj.control.inversion import invert
from infotraj.residual.affine_prior import AffinePrior
from infotraj.residual.compiled import mean_and_jacobian
from infotraj.residual.draws import MarginalDraws, PosteriorDraws
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.hyperparameters import REMAINDER_PRIOR, _likelihood, fit
from infotraj.residual.marginal_likelihood import MarginalLikelihood
from infotraj.residual.posterior_variance import RegionVariance


def affine(seed: int = 0, d: int = 6, m: int = 3) -> AffinePrior:
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(m, d + 1, 4))  # fewer than weights: a covariance that is singular, as four effects make
    return AffinePrior(rng.normal(size=d), columns @ columns.transpose(0, 2, 1))


def process(n: int, signal: float = 0.3, noise: float = 0.04) -> GaussianProcess:
    rng = np.random.default_rng(1)
    return GaussianProcess(
        rng.normal(size=(n, 6)),
        rng.normal(size=(n, 3)),
        rng.uniform(0.7, 3.0, (3, 6)),
        np.full(3, signal),
        np.full(3, noise),
        rng.normal(size=3),
        affine(),
    )


def queries(k: int) -> np.ndarray:
    return 1.5 * np.random.default_rng(2).normal(size=(k, 6))


@pytest.mark.parametrize("n", [3, 40])
def test_without_a_remainder_it_is_bayesian_linear_regression(n):
    """Rasmussen and Williams, eq. 2.8, on the effects' own weights: y = S theta + noise, theta ~ N(0, I)."""
    rng = np.random.default_rng(3)
    columns = rng.normal(size=(7, 4))
    prior = AffinePrior(np.zeros(6), (columns @ columns.T)[None])
    X, Y, U, noise = rng.normal(size=(n, 6)), rng.normal(size=(n, 1)), queries(9), 0.2
    gp = GaussianProcess(X, Y, np.ones((1, 6)), [1e-14], [noise], [0.0], prior)
    S, asked = prior.features(X) @ columns, prior.features(U) @ columns
    covariance = np.linalg.inv(S.T @ S / noise + np.eye(4))
    theta = covariance @ S.T @ Y / noise
    np.testing.assert_allclose(gp.mean(U), asked @ theta, atol=1e-9)
    np.testing.assert_allclose(gp.covariance(U)[0], asked @ covariance @ asked.T, atol=1e-9)
    constant, slopes = gp.affine_mean
    weights = (columns @ theta)[:, 0]
    np.testing.assert_allclose([constant[0], *slopes[0]], weights, atol=1e-9)


def test_a_covariance_of_nothing_is_the_plain_process():
    gp = process(30)
    nothing = AffinePrior(gp.affine.origin, 0.0 * gp.affine.covariance)
    hyper = (gp.lengthscales, gp.signal_variance, gp.noise_variance, gp.prior_mean)
    without, plain = GaussianProcess(gp.X, gp.Y, *hyper, nothing), GaussianProcess(gp.X, gp.Y, *hyper)
    np.testing.assert_allclose(without.mean(queries(9)), plain.mean(queries(9)), atol=1e-12)
    np.testing.assert_allclose(without.variance(queries(9)), plain.variance(queries(9)), atol=1e-12)
    assert np.abs(gp.mean(queries(9)) - plain.mean(queries(9))).max() > 0.1


@pytest.mark.parametrize("n", [0, 25])
def test_compiled_mean_and_its_slopes(n):
    gp, U, step = process(n), queries(5), 1e-5
    for u, mean in zip(U, gp.mean(U), strict=True):
        found, slopes = np.empty(3), np.empty((3, 6))
        mean_and_jacobian(u, *gp.mean_arrays, found, slopes)
        np.testing.assert_allclose(found, mean, atol=1e-9)
        moved = [gp.mean(u + step * np.stack([e, -e])) for e in np.eye(6)]
        np.testing.assert_allclose(slopes, np.stack([(a - b) / (2 * step) for a, b in moved], axis=1), atol=1e-6)


def test_the_command_inverts_an_affine_residual():
    """u + c + S u = d has one solution: that of the linear equations."""
    gp = process(40, signal=1e-14, noise=1e-2)
    gp = GaussianProcess(
        gp.X, 0.1 * gp.Y, gp.lengthscales, gp.signal_variance, gp.noise_variance, np.zeros(3), gp.affine
    )
    wanted, command = np.array([0.3, -0.2, 9.8, 1.0, -0.5, 0.2]), np.empty(6)
    assert invert(wanted, gp.mean_arrays, 50.0, np.zeros(3), command) < 1e-6
    constant, slopes = gp.affine_mean
    torque = np.linalg.solve(np.eye(3) + slopes[:, 3:], wanted[3:] - constant - slopes[:, :3] @ wanted[:3])
    np.testing.assert_allclose(command, [*wanted[:3], *torque], atol=1e-3)


def test_points_added_later_or_at_once():
    whole, U = process(40), queries(9)
    part = GaussianProcess(
        whole.X[:15],
        whole.Y[:15],
        whole.lengthscales,
        whole.signal_variance,
        whole.noise_variance,
        whole.prior_mean,
        whole.affine,
    )
    grown = part.condition(whole.X[15:], whole.Y[15:])
    np.testing.assert_allclose(grown.mean(U), whole.mean(U), atol=1e-9)
    np.testing.assert_allclose(grown.variance(U), whole.variance(U), atol=1e-9)


@pytest.mark.parametrize("n", [0, 20])
def test_variance_of_the_region_after_points(n):
    gp, region, added = process(n), queries(300), np.random.default_rng(4).normal(size=(30, 6))
    after = gp.condition(added, np.zeros((30, 3))).variance(region)
    asked = RegionVariance(gp, region)
    np.testing.assert_allclose(asked.before, gp.variance(region), atol=1e-9)
    np.testing.assert_allclose(asked.after(added), after, atol=1e-8)
    np.testing.assert_allclose(asked.sum_after(added), after.sum(axis=0), rtol=1e-7)


@pytest.mark.parametrize("n", [0, 15])
def test_draws_have_the_posterior_s_moments(n):
    gp, U, count = process(n), 0.5 * queries(4), 6000
    values = PosteriorDraws.sample(gp, np.random.default_rng(5), count, features=64)(U)
    for o in range(3):
        mean, covariance = gp.mean(U)[:, o], gp.covariance(U)[o]
        spread = np.sqrt(np.diag(covariance) / count)
        np.testing.assert_array_less(np.abs(values[:, :, o].mean(axis=0) - mean), 5.0 * spread)
        variance = np.diag(covariance)
        error = np.sqrt((covariance**2 + np.outer(variance, variance)) / count)
        np.testing.assert_array_less(np.abs(np.cov(values[:, :, o].T) - covariance), 5.0 * error)


def test_marginal_draws_refuse_it():
    with pytest.raises(ValueError, match="PosteriorDraws"):
        MarginalDraws(process(5), np.random.default_rng(0), 2)


def test_marginal_likelihood_is_that_of_the_normal_distribution():
    rng = np.random.default_rng(6)
    X, y = rng.normal(size=(12, 6)), rng.normal(size=12)
    A, theta = affine(m=1).cross(X, X)[0], np.array([-0.5, *rng.normal(0.3, 0.3, 6), -1.0])
    gp = GaussianProcess.empty([np.exp(theta[1:7])], [np.exp(theta[0])], [np.exp(theta[7])])
    covariance = gp.covariance(X)[0] + A + np.exp(theta[7]) * np.eye(12)
    value, gradient = MarginalLikelihood(X, y, A, ard=True)(theta)
    assert value == pytest.approx(multivariate_normal(np.zeros(12), covariance).logpdf(y), abs=1e-8)
    steps = 1e-5 * np.eye(8)
    likelihood = MarginalLikelihood(X, y, A, ard=True)
    differences = [(likelihood(theta + s)[0] - likelihood(theta - s)[0]) / 2e-5 for s in steps]
    np.testing.assert_allclose(gradient, differences, atol=1e-6)


@pytest.mark.parametrize("ard", [True, False])
def test_without_an_affine_part_the_likelihood_is_scikit_learn_s(ard):
    rng = np.random.default_rng(7)
    X, y = rng.normal(size=(20, 6)), rng.normal(size=20)
    theta = np.array([0.2, *rng.normal(0.5, 0.2, 6 if ard else 1), -1.5])
    value, gradient = MarginalLikelihood(X, y, np.zeros((20, 20)), ard)(theta)
    other, slopes = _likelihood(X, y, ard)(theta)
    assert value == pytest.approx(other, abs=1e-9)
    np.testing.assert_allclose(gradient, slopes, atol=1e-8)


def test_few_points_of_a_known_form_extrapolate():
    """Outputs of four weights from the prior, 20 points near the origin: far away the affine part goes on, a constant
    mean does not."""
    rng = np.random.default_rng(8)
    prior = affine(m=1)
    weights = prior.sample(rng, 1)[0]
    X, far = 0.3 * rng.normal(size=(20, 6)), 5.0 * rng.normal(size=(50, 6))
    Y = prior.features(X) @ weights.T + 0.05 * rng.normal(size=(20, 1))
    found = fit(X, Y, rng, prior=REMAINDER_PRIOR, input_scale=np.full(6, 3.0), affine=prior)
    plain = fit(X, Y, rng, input_scale=np.full(6, 3.0))
    truth = prior.features(far) @ weights.T
    error, without = (np.abs(gp.mean(far) - truth).mean() for gp in (found, plain))
    assert error < 0.5 * without


def test_a_file_holds_it(tmp_path):
    gp = process(12)
    gp.save(tmp_path / "model.npz")
    again = GaussianProcess.load(tmp_path / "model.npz")
    np.testing.assert_array_equal(again.affine.origin, gp.affine.origin)
    np.testing.assert_array_equal(again.mean(queries(3)), gp.mean(queries(3)))


def test_what_does_not_fit_is_told():
    good = affine()
    with pytest.raises(ValueError, match="Reshape"):
        AffinePrior(good.origin, good.covariance[:, :3, :3])
    with pytest.raises(ValueError, match="not negative"):
        AffinePrior(good.origin, -good.covariance)
    with pytest.raises(ValueError, match="for these inputs"):
        GaussianProcess(np.zeros((0, 6)), np.zeros((0, 2)), np.ones((2, 6)), np.ones(2), np.ones(2), np.zeros(2), good)
