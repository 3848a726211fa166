"""The Gaussian process against scikit-learn, its own definitions, and itself by another way."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from infotraj.errors import InputError
from infotraj.residual.compiled import _exp, marginal_value, mean_and_jacobian
from infotraj.residual.draws import MarginalDraws
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.hyperparameters import (
    DEFAULT_PRIOR,
    SearchBounds,
    _NegativeLogPosterior,
    fit,
    sample_hyperparameters,
)
from infotraj.residual.posterior_variance import RegionVariance


def process(n: int, d: int = 6, m: int = 3, seed: int = 0, noise: float = 1e-2) -> GaussianProcess:
    rng = np.random.default_rng(seed)
    return GaussianProcess(
        rng.normal(size=(n, d)),
        rng.normal(size=(n, m)),
        rng.uniform(0.7, 3.0, (m, d)),
        rng.uniform(0.5, 2.0, m),
        noise * rng.uniform(1.0, 2.0, m),
        rng.normal(size=m),
    )


def queries(k: int, d: int = 6, seed: int = 1) -> np.ndarray:
    return 1.5 * np.random.default_rng(seed).normal(size=(k, d))


def truth(lengthscales, n: int, seed: int, noise: float = 1e-2) -> tuple[np.ndarray, np.ndarray]:
    """Inputs and one output sampled from a process with known hyperparameters (signal variance 1)."""
    rng = np.random.default_rng(seed)
    X = rng.normal(size=(n, len(lengthscales)))
    prior = GaussianProcess.empty([lengthscales], [1.0], [noise])
    K = prior.covariance(X)[0] + noise * np.eye(n)
    return X, (np.linalg.cholesky(K) @ rng.standard_normal(n))[:, None]


def compiled_mean(gp: GaussianProcess, U: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    mean, jacobian = np.empty((len(U), gp.m)), np.empty((len(U), gp.m, gp.d))
    for k, u in enumerate(U):
        mean_and_jacobian(u, *gp.mean_arrays, mean[k], jacobian[k])
    return mean, jacobian


def test_equals_scikit_learn():
    gp, U = process(100), queries(50)
    for o in range(gp.m):
        kernel = ConstantKernel(gp.signal_variance[o]) * RBF(gp.lengthscales[o])
        other = GaussianProcessRegressor(kernel, alpha=gp.noise_variance[o], optimizer=None)
        other.fit(gp.X, gp.Y[:, o] - gp.prior_mean[o])
        mean, covariance = other.predict(U, return_cov=True)
        np.testing.assert_allclose(gp.mean(U)[:, o], gp.prior_mean[o] + mean, atol=1e-8, rtol=0)
        np.testing.assert_allclose(gp.variance(U)[:, o], np.diag(covariance), atol=1e-8, rtol=0)
        np.testing.assert_allclose(gp.covariance(U)[o], covariance, atol=1e-8, rtol=0)


# 128 is the block of the compiled loops; sizes on, below and beyond it, and a single dimension
@pytest.mark.parametrize(("n", "d", "m"), [(0, 6, 3), (1, 1, 1), (100, 6, 3), (128, 4, 2), (300, 7, 1)])
def test_compiled_mean_equals_class_and_its_slopes_central_differences(n, d, m):
    gp, U, step = process(n, d, m), queries(15, d), 1e-5
    mean, jacobian = compiled_mean(gp, U)
    np.testing.assert_allclose(mean, gp.mean(U), atol=1e-10)
    for i, e in enumerate(step * np.eye(d)):
        slope = (gp.mean(U + e) - gp.mean(U - e)) / (2 * step)
        np.testing.assert_allclose(jacobian[:, :, i], slope, atol=1e-7)


def test_compiled_exponential_is_exact_to_rounding():
    x = np.concatenate([-np.logspace(-18, np.log10(699), 2000), np.linspace(-3, 0, 2000)])
    np.testing.assert_allclose([_exp(value) for value in x], np.exp(x), rtol=6e-16)
    assert 0 <= _exp(-1e9) < 1e-300


def test_compiled_far_from_the_data_is_the_prior():
    gp = process(50)
    mean, jacobian = compiled_mean(gp, np.full((1, gp.d), 1e4))
    np.testing.assert_array_equal(mean[0], gp.prior_mean)
    np.testing.assert_allclose(jacobian, 0.0, atol=1e-250)


def test_compiled_marginal_is_mean_plus_deviations():
    gp, U = process(80), queries(10)
    scratch, out = np.empty(gp.n), np.empty((2, len(U), gp.m))
    for k, u in enumerate(U):
        for s, normal in enumerate((0.0, -2.0)):
            arrays = MarginalDraws(gp, np.random.default_rng(0), 1).arrays
            marginal_value(u, *arrays, np.full(gp.m, normal), scratch, out[s, k])  # type: ignore[call-arg]
    np.testing.assert_allclose(out[0], gp.mean(U), atol=1e-10)
    np.testing.assert_allclose(out[1], gp.mean(U) - 2 * np.sqrt(gp.variance(U)), atol=1e-8)


def test_prior_without_data():
    gp, U = GaussianProcess.empty([[1.0, 2.0], [3.0, 4.0]], [1.5, 0.5], [0.1, 0.1]), queries(5, 2)
    np.testing.assert_array_equal(gp.mean(U), np.zeros((5, 2)))
    np.testing.assert_array_equal(gp.variance(U), np.tile([1.5, 0.5], (5, 1)))
    np.testing.assert_array_equal(compiled_mean(gp, U)[1], np.zeros((5, 2, 2)))
    X, Y = queries(7, 2, seed=3), queries(7, 2, seed=4)
    whole = GaussianProcess(X, Y, gp.lengthscales, gp.signal_variance, gp.noise_variance, gp.prior_mean)
    np.testing.assert_allclose(gp.condition(X, Y).mean(U), whole.mean(U), atol=1e-12)


def test_condition_equals_all_data_at_once():
    whole, U = process(90), queries(30)
    hyper = (whole.lengthscales, whole.signal_variance, whole.noise_variance, whole.prior_mean)
    part = GaussianProcess(whole.X[:50], whole.Y[:50], *hyper)
    grown = part.condition(whole.X[50:70], whole.Y[50:70]).condition(whole.X[70:], whole.Y[70:])
    np.testing.assert_allclose(grown.L, whole.L, atol=1e-10)
    np.testing.assert_allclose(grown.mean(U), whole.mean(U), atol=1e-9)
    np.testing.assert_allclose(grown.variance(U), whole.variance(U), atol=1e-9)
    nothing = whole.condition(np.empty((0, 6)), np.empty((0, 3)))
    np.testing.assert_array_equal(nothing.mean(U), whole.mean(U))


def test_interpolates_noiseless_data_and_loses_its_variance_there():
    gp = process(25, noise=1e-12)
    np.testing.assert_allclose(gp.mean(gp.X), gp.Y, atol=1e-7)
    assert gp.variance(gp.X).max() < 1e-9
    assert gp.variance(queries(10)).max() > 0.1


@pytest.mark.parametrize("n", [0, 30])
def test_saved_and_loaded_is_the_same(tmp_path, n):
    gp, U = process(n), queries(10)
    gp.save(tmp_path / "deep" / "gp.npz")
    back = GaussianProcess.load(tmp_path / "deep" / "gp.npz")
    np.testing.assert_array_equal(back.mean(U), gp.mean(U))
    np.testing.assert_array_equal(back.variance(U), gp.variance(U))
    assert [p.name for p in (tmp_path / "deep").iterdir()] == ["gp.npz"]


def test_broken_files_are_named(tmp_path):
    path = tmp_path / "gp.npz"
    process(10).save(path)
    content = path.read_bytes()
    np.savez(tmp_path / "other.npz", a=np.ones(3))
    np.savez(tmp_path / "pickled.npz", **dict.fromkeys(("X", "Y"), np.array([None])))
    np.save(tmp_path / "single.npy", np.ones(3))
    gp = process(10)
    arrays = {k: getattr(gp, k) for k in ("X", "lengthscales", "signal_variance", "noise_variance", "prior_mean")}
    np.savez(tmp_path / "shapes.npz", Y=gp.Y[:5], **arrays)
    np.savez(tmp_path / "nan.npz", Y=gp.Y * np.nan, **arrays)
    (tmp_path / "cut.npz").write_bytes(content[: len(content) // 2])
    (tmp_path / "text.npz").write_text("no model")
    (tmp_path / "void.npz").write_bytes(b"")
    damaged = bytearray(content)
    damaged[200] ^= 0xFF
    (tmp_path / "damaged.npz").write_bytes(damaged)
    names = ["absent.npz", "other.npz", "pickled.npz", "single.npy", "shapes.npz", "nan.npz"]
    for name in [*names, "cut.npz", "text.npz", "void.npz", "damaged.npz"]:
        with pytest.raises(InputError, match=name) as caught:
            GaussianProcess.load(tmp_path / name)
        assert "\n" not in str(caught.value)


def test_bad_arrays_are_refused():
    gp = process(5)
    with pytest.raises(ValueError, match="inputs of shape"):
        gp.mean(np.zeros((3, 5)))
    with pytest.raises(ValueError, match="positive"):
        GaussianProcess.empty([[1.0, -1.0]], [1.0], [0.1])
    with pytest.raises(ValueError, match="shapes"):
        GaussianProcess(gp.X, gp.Y[:, :2], gp.lengthscales, gp.signal_variance, gp.noise_variance, gp.prior_mean)
    twice = np.zeros((2, 1))
    with pytest.raises(InputError, match="singular"):
        GaussianProcess(twice, twice, [[1.0]], [1.0], [0.0], [0.0])


@pytest.mark.parametrize("n", [0, 60])
def test_variance_after_adding_points_equals_conditioning(n):
    gp, region = process(n, noise=1e-3), queries(700)
    shared = RegionVariance(gp, region)
    for seed, q in ((5, 40), (6, 40), (7, 1), (8, 0)):
        added = queries(q, seed=seed)
        expected = gp.condition(added, np.zeros((q, gp.m))).variance(region)
        np.testing.assert_allclose(shared.after(added), expected, atol=1e-8, rtol=0)
        np.testing.assert_allclose(shared.sum_after(added), expected.sum(axis=0), atol=1e-8 * len(region), rtol=0)
        np.testing.assert_allclose(shared.sum_after(added), expected.sum(axis=0), rtol=1e-8)


def test_variance_far_from_the_origin_keeps_its_digits():
    gp = process(60)
    shift = np.array([0.0, 0.0, 1e6, 0.0, 50.0, 0.0])
    far = GaussianProcess(gp.X + shift, gp.Y, gp.lengthscales, gp.signal_variance, gp.noise_variance, gp.prior_mean)
    region, added = queries(300), queries(40, seed=5)
    near = RegionVariance(gp, region).sum_after(added)
    np.testing.assert_allclose(RegionVariance(far, region + shift).sum_after(added + shift), near, rtol=1e-7)


def test_objective_gradient_equals_central_differences():
    X, Y = truth([1.0, 2.0, 5.0], 30, seed=0)
    objective = _NegativeLogPosterior(X, Y[:, 0], True, DEFAULT_PRIOR)
    theta = np.array([0.3, 0.1, 0.9, 1.4, -3.0])
    steps = 1e-5 * np.eye(len(theta))
    slope = [(objective(theta + s)[0] - objective(theta - s)[0]) / 2e-5 for s in steps]
    np.testing.assert_allclose(objective(theta)[1], slope, rtol=1e-5, atol=1e-6)


def test_fit_recovers_the_process_that_made_the_data():
    lengthscales = np.array([1.0, 2.0, 4.0])
    X, Y = truth(lengthscales, 150, seed=2)
    gp = fit(X, Y, np.random.default_rng(0))
    # Laplace's own spread is the yardstick: three of it, for five parameters
    draws = sample_hyperparameters(gp, np.random.default_rng(1), 200)
    for name, expected in (("lengthscales", [lengthscales]), ("signal_variance", [1.0]), ("noise_variance", [1e-2])):
        logs = np.log([getattr(draw, name) for draw in draws])
        assert (np.abs(np.log(getattr(gp, name)) - np.log(expected)) < 3 * logs.std(axis=0)).all(), name
        assert (logs.std(axis=0) < 1.0).all(), name


def test_maximum_likelihood_is_as_good_as_scikit_learn():
    X, Y = truth([1.0, 2.0, 4.0], 60, seed=3)
    X, Y = X / X.std(axis=0), Y / Y.std()
    gp = fit(X, Y, np.random.default_rng(0), prior=None, prior_mean=[0.0])
    kernel = ConstantKernel(1.0) * RBF(np.ones(3), (0.05, 100)) + WhiteKernel(0.1)
    other = GaussianProcessRegressor(kernel, alpha=0.0, n_restarts_optimizer=2, random_state=0).fit(X, Y[:, 0])
    theta = np.log([gp.signal_variance[0], *gp.lengthscales[0], gp.noise_variance[0]])
    assert other.log_marginal_likelihood(theta) > other.log_marginal_likelihood_value_ - 1e-3


def test_fit_follows_the_units_of_the_data():
    X, Y = truth([1.0, 2.0, 5.0], 40, seed=4)
    a, b = np.array([10.0, 0.01, 3.0]), np.array([100.0, -1.0, 0.0])
    plain, scaled = (fit(x, y, np.random.default_rng(0)) for x, y in ((X, Y), (a * X + b, 5.0 * Y + 2.0)))
    np.testing.assert_allclose(scaled.lengthscales, a * plain.lengthscales, rtol=1e-2)
    np.testing.assert_allclose(scaled.noise_variance, 25 * plain.noise_variance, rtol=1e-2)
    np.testing.assert_allclose(scaled.mean(a * X + b), 5 * plain.mean(X) + 2, atol=1e-2)


def test_same_seed_same_fit_and_a_scalar_lengthscale_without_ard():
    X, Y = truth([1.0, 2.0, 5.0], 20, seed=5)
    first, second = (fit(X, Y, np.random.default_rng(7)) for _ in range(2))
    np.testing.assert_array_equal(first.lengthscales, second.lengthscales)
    isotropic = fit(X, Y, np.random.default_rng(7), ard=False, input_scale=1.0)
    assert np.ptp(isotropic.lengthscales) == 0.0
    for draw in sample_hyperparameters(isotropic, np.random.default_rng(0), 3, ard=False, input_scale=1.0):
        assert np.ptp(draw.lengthscales) == 0.0


def test_prior_keeps_twenty_points_off_the_bounds_and_a_hundred_overrule_it():
    lengthscales = [0.8, 1.5, 2.0, 3.0, 3.0, 4.0]
    extremes = {}
    for prior in (None, DEFAULT_PRIOR):
        found = [fit(*truth(lengthscales, 20, seed=s), np.random.default_rng(0), prior=prior) for s in range(6)]
        logs = np.log([gp.lengthscales[0] for gp in found])
        extremes[prior is None] = np.abs(logs - np.log(lengthscales)).max()
    assert extremes[True] > np.log(10)
    assert extremes[False] < np.log(10)
    few, many = (
        sample_hyperparameters(fit(X, Y, np.random.default_rng(0)), np.random.default_rng(0), 100)
        for X, Y in (truth(lengthscales, n, seed=9) for n in (20, 120))
    )
    spread = [np.log([gp.lengthscales[0, 0] for gp in draws]).std() for draws in (few, many)]
    assert spread[1] < 0.5 * spread[0]


def test_degenerate_training_data():
    X, Y = truth([1.0, 2.0], 30, seed=6)
    X = np.column_stack([X, np.full(30, 9.81)])
    gp = fit(X, np.column_stack([Y, np.full(30, 3.0)]), np.random.default_rng(0))
    assert np.isfinite(gp.mean(X)).all()
    np.testing.assert_allclose(gp.mean(X)[:, 1], 3.0, atol=1e-6)
    with pytest.raises(InputError, match="at least 2"):
        fit(X[:1], Y[:1], np.random.default_rng(0))
    with pytest.raises(InputError, match="finite"):
        fit(X, Y * np.nan, np.random.default_rng(0))


def test_a_direction_that_neither_data_nor_prior_determine_is_as_wide_as_is_said():
    """Of an input that never changes no lengthscale is told: draws of its logarithm spread by 1.5, within bounds."""
    rng, wide = np.random.default_rng(0), SearchBounds(lengthscale=(1e-6, 1e9))
    X = np.column_stack([rng.uniform(-2.0, 2.0, 60), np.full(60, 0.3)])
    gp = fit(X, np.sin(2.0 * X[:, :1]), np.random.default_rng(0), prior=None, bounds=wide, input_scale=np.ones(2))
    draws = sample_hyperparameters(gp, rng, 4000, prior=None, bounds=wide, input_scale=np.ones(2))
    spread = np.log([draw.lengthscales[0] for draw in draws]).std(axis=0)
    assert spread[1] == pytest.approx(1.5, rel=0.1)
    assert spread[0] < 0.5
