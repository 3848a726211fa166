"""Whitening: what it makes of known noise, that it is linear, and that it starts again with every run."""

import numpy as np

from infotraj.diagnosis.whitening import estimate, place_in_run


def correlations(x, most=30):
    x = x - x.mean()
    return np.array([np.mean(x[k:] * x[: len(x) - k]) for k in range(1, most)]) / np.mean(x**2)


def test_differences_of_noisy_samples_become_white():
    rng = np.random.default_rng(1)
    noise = 0.01 * rng.standard_normal(6001)
    run = np.zeros(6000, dtype=int)
    d = np.diff(noise)
    whitener = estimate([d], [run], difference=True)
    white = whitener.apply(d[:, None], run)[whitener.used(run), 0]
    assert abs(np.std(white) - 1) < 0.05
    assert np.abs(correlations(white)).max() < 4 / np.sqrt(len(white))
    assert abs(whitener.deviation - 0.01) < 5e-4  # the noise of a sample, not of a difference
    assert whitener.gain < 0.05


def test_a_level_that_walks_is_followed():
    rng = np.random.default_rng(2)
    y = 0.01 * rng.standard_normal(6001) + np.cumsum(0.01 * rng.standard_normal(6001))
    d, run = np.diff(y), np.zeros(6000, dtype=int)
    whitener = estimate([d], [run], difference=True)
    white = whitener.apply(d[:, None], run)[whitener.used(run), 0]
    assert abs(whitener.deviation - 0.0162) < 5e-4  # variance of the innovations: (3 + sqrt 5) / 2 of the noise's
    assert np.abs(correlations(white)).max() < 4 / np.sqrt(len(white))


def test_red_noise_becomes_white():
    rng = np.random.default_rng(3)
    x = np.zeros(8000)
    e = rng.standard_normal(8000)
    for k in range(2, 8000):
        x[k] = 1.2 * x[k - 1] - 0.4 * x[k - 2] + 0.3 * e[k]
    run = np.zeros(8000, dtype=int)
    whitener = estimate([x], [run], difference=False)
    assert abs(whitener.deviation - 0.3) < 0.01
    assert np.abs(correlations(whitener.apply(x[:, None], run)[20:, 0])).max() < 4 / np.sqrt(8000)


def test_the_filter_is_linear_and_the_same_for_every_column():
    rng = np.random.default_rng(4)
    x, run = rng.standard_normal((500, 3)), np.repeat([0, 1], 250)
    whitener = estimate([x[:, 0]], [run], difference=True)
    out = whitener.apply(x, run)
    np.testing.assert_allclose(whitener.apply(x @ [[1.0], [2.0], [-3.0]], run), out @ [[1.0], [2.0], [-3.0]], atol=1e-9)


def test_every_run_starts_anew():
    rng = np.random.default_rng(5)
    x, run = rng.standard_normal((400, 1)), np.repeat([0, 1], 200)
    whitener = estimate([x[:, 0]], [run], difference=True)
    alone = whitener.apply(x[200:], run[200:])
    np.testing.assert_allclose(whitener.apply(x, run)[200:], alone, atol=1e-12)
    assert place_in_run(run)[200] == 0
    assert place_in_run(run)[199] == 199
