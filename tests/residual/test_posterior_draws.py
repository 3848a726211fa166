"""Posterior draws: right in distribution, consistent as functions, equal in compiled loops."""

from __future__ import annotations

import numpy as np
import pytest

from infotraj.residual.compiled import draw_value
from infotraj.residual.draws import MarginalDraws, PosteriorDraws
from infotraj.residual.gaussian_process import GaussianProcess

SIGMAS = 5.0  # of a sampled moment: about 1e-6 a comparison


def process(n: int, noise: float = 1e-2) -> GaussianProcess:
    rng = np.random.default_rng(0)
    return GaussianProcess(
        rng.normal(size=(n, 6)),
        rng.normal(size=(n, 3)),
        rng.uniform(1.5, 4.0, (3, 6)),
        np.array([1.0, 0.3, 2.0]),
        np.full(3, noise),
        np.array([0.5, -1.0, 0.0]),
    )


def moments_agree(values: np.ndarray, mean: np.ndarray, covariance: np.ndarray) -> None:
    """values (draws, k), within SIGMAS standard errors of a normal sample of that mean and covariance."""
    count, variance = len(values), np.diag(covariance)
    np.testing.assert_array_less(np.abs(values.mean(axis=0) - mean), SIGMAS * np.sqrt(variance / count))
    error = np.sqrt((covariance**2 + np.outer(variance, variance)) / count)
    np.testing.assert_array_less(np.abs((values - mean).T @ (values - mean) / count - covariance), SIGMAS * error)


@pytest.mark.parametrize("n", [0, 15])
def test_moments_are_those_of_the_posterior(n):
    gp, U = process(n), np.random.default_rng(1).normal(size=(6, 6))
    U[1] = U[0] + 0.3  # neighbours, strongly correlated
    values = PosteriorDraws.sample(gp, np.random.default_rng(2), 6000, features=64)(U)
    for o in range(gp.m):
        moments_agree(values[:, :, o], gp.mean(U)[:, o], gp.covariance(U)[o])
    across = np.corrcoef(values[:, 0].T)[np.triu_indices(3, 1)]
    assert np.abs(across).max() < SIGMAS / np.sqrt(6000)


def test_a_single_draw_of_the_prior_has_the_kernel_as_its_autocovariance():
    # averaged over places instead of draws: one function of many waves is close to ergodic on a long line
    gp = GaussianProcess.empty([[1.0]], [2.0], [0.0])
    draw = PosteriorDraws.sample(gp, np.random.default_rng(3), 1, features=4000)
    line = np.linspace(0, 2000, 200001)[:, None]
    f = draw(line)[0, :, 0]
    for lag in (0.5, 1.0, 2.0):
        shift = round(lag / 0.01)
        # about 2000 / sqrt(pi) independent stretches
        assert abs(np.mean(f[:-shift] * f[shift:]) - 2.0 * np.exp(-0.5 * lag**2)) < SIGMAS * 2.0 / np.sqrt(1128)


def test_draws_pass_through_noiseless_data():
    gp = process(20, noise=1e-10)
    values = PosteriorDraws.sample(gp, np.random.default_rng(0), 50)(gp.X)
    np.testing.assert_allclose(values, np.broadcast_to(gp.Y, values.shape), atol=2e-4)
    away = PosteriorDraws.sample(gp, np.random.default_rng(0), 50)(gp.X + 2.0)
    assert away.std(axis=0).min() > 0.01


def test_a_draw_is_a_function():
    gp, U = process(15), np.random.default_rng(1).normal(size=(8, 6))
    draws = PosteriorDraws.sample(gp, np.random.default_rng(0), 10)
    once = draws(U)
    np.testing.assert_array_equal(draws(U), once)
    np.testing.assert_array_equal(draws(U[::-1])[:, ::-1], once)
    np.testing.assert_array_equal(draws(np.tile(U, (10, 1, 1))), once)
    assert np.abs(draws(U + 1e-4) - once).max() < 1e-3
    assert np.abs(once[0] - once[1]).max() > 1e-2
    np.testing.assert_array_equal(PosteriorDraws.sample(gp, np.random.default_rng(0), 10)(U), once)


@pytest.mark.parametrize(("n", "features"), [(0, 1), (15, 128), (15, 300)])
def test_compiled_value_is_the_sum_of_waves_and_the_update(n, features):
    gp, U = process(n), np.random.default_rng(1).normal(size=(5, 6))
    draws = PosteriorDraws.sample(gp, np.random.default_rng(0), 4, features)
    out = np.empty(3)
    for k in range(draws.count):
        one = draws.one(k)
        angle = np.einsum("odf,kd->kof", one.frequencies.astype(float), U) + one.phases
        waves = (one.amplitudes * np.cos(2 * np.pi * angle)).sum(axis=-1)
        exact = waves + np.einsum("okn,on->ko", gp._covariance(U, gp.X), one.update) + gp.prior_mean
        for u, expected in zip(U, exact, strict=True):
            draw_value(u, *one, out)
            np.testing.assert_allclose(out, expected, atol=1e-5)


def test_every_input_goes_to_its_own_draw():
    gp = process(15)
    draws = PosteriorDraws.sample(gp, np.random.default_rng(0), 3)
    U = np.random.default_rng(1).normal(size=(3, 4, 6))
    for k in range(3):
        np.testing.assert_array_equal(draws(U)[k], draws(U[k])[k])
        np.testing.assert_array_equal(draws(U)[k], draws.part(k, k + 1)(U[k])[0])
    with pytest.raises(ValueError, match="inputs of shape"):
        draws(U[:2])
    with pytest.raises(ValueError, match="at least 1"):
        PosteriorDraws.sample(gp, np.random.default_rng(0), 0)


@pytest.mark.parametrize("n", [0, 15])
def test_marginal_draws_have_the_marginals_and_forget(n):
    gp, U = process(n), np.random.default_rng(1).normal(size=(2, 6))
    U[1] = U[0]
    draws = MarginalDraws(gp, np.random.default_rng(2), 6000)
    values = draws(U)
    assert np.abs(draws(U) - values).max() > 0.1
    for o in range(gp.m):
        moments_agree(values[:, :, o], gp.mean(U)[:, o], np.diag(gp.variance(U)[:, o]))
