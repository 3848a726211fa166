"""Whitening: what it makes of known noise, that it is linear, and that it starts again with every run."""

import numpy as np
import pytest

from infotraj.diagnosis.whitening import estimate, place_in_run


def correlations(x, most=30):
    x = x - x.mean()
    return np.array([np.mean(x[k:] * x[: len(x) - k]) for k in range(1, most)]) / np.mean(x**2)


def test_differences_of_noisy_samples_become_white():
    rng = np.random.default_rng(1)
    noise = 0.01 * rng.standard_normal(6001)
    run = np.zeros(6000, dtype=int)
    d = np.diff(noise)
    (whitener,) = estimate([d[:, None]], [run], difference=True)
    white = whitener.apply(d[:, None], run)[whitener.used(run), 0]
    assert abs(np.std(white) - 1) < 0.05
    assert np.abs(correlations(white)).max() < 4 / np.sqrt(len(white))
    assert abs(whitener.deviation - 0.01) < 5e-4  # the noise of a sample, not of a difference
    assert whitener.gain < 0.05


def test_a_level_that_walks_is_followed():
    rng = np.random.default_rng(2)
    y = 0.01 * rng.standard_normal(6001) + np.cumsum(0.01 * rng.standard_normal(6001))
    d, run = np.diff(y), np.zeros(6000, dtype=int)
    (whitener,) = estimate([d[:, None]], [run], difference=True)
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
    (whitener,) = estimate([x[:, None]], [run], difference=False)
    assert abs(whitener.deviation - 0.3) < 0.01
    assert np.abs(correlations(whitener.apply(x[:, None], run)[20:, 0])).max() < 4 / np.sqrt(8000)


def test_the_filter_is_linear_and_the_same_for_every_column():
    rng = np.random.default_rng(4)
    x, run = rng.standard_normal((500, 3)), np.repeat([0, 1], 250)
    (whitener,) = estimate([x[:, :1]], [run], difference=True)
    out = whitener.apply(x, run)
    np.testing.assert_allclose(whitener.apply(x @ [[1.0], [2.0], [-3.0]], run), out @ [[1.0], [2.0], [-3.0]], atol=1e-9)


def test_every_run_starts_anew():
    rng = np.random.default_rng(5)
    x, run = rng.standard_normal((400, 1)), np.repeat([0, 1], 200)
    (whitener,) = estimate([x[:, :1]], [run], difference=True)
    alone = whitener.apply(x[200:], run[200:])
    np.testing.assert_allclose(whitener.apply(x, run)[200:], alone, atol=1e-12)
    assert place_in_run(run)[200] == 0
    assert place_in_run(run)[199] == 199


def wandering(rng, count, walk=0.04):
    """Differences (count, 3) of noisy samples of levels that walk, by `walk` times the noise a sample."""
    level = np.cumsum(walk * rng.standard_normal((count + 1, 3)), axis=0)
    return np.diff(level + rng.standard_normal((count + 1, 3)), axis=0)


def doubted(whitener, differences, walk):
    """The error that a walk leaves in the mean of some differences, over what the filter makes of it."""
    count = len(differences)
    white = whitener.apply(np.column_stack([differences, np.ones(count)]), np.zeros(count, dtype=int))
    return walk / np.sqrt(count) * np.linalg.norm(white[:, 1])


def test_short_flights_do_not_hide_that_a_level_walks():
    """Four flights of 4 s at 100 Hz: a mean change is as uncertain as the walk makes it, on every axis."""
    ratios = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        flights, run = [wandering(rng, 400) for _ in range(4)], np.zeros(400, dtype=int)
        filters = estimate(flights, [run] * 4, difference=True)
        ratios += [doubted(w, flights[0][:, i], 0.04) for i, w in enumerate(filters)]
    assert np.median(ratios) < 1.15
    assert np.max(ratios) < 2.5


@pytest.mark.parametrize("seed", [6, 7, 8])
def test_an_axis_that_wanders_more_has_a_gain_of_its_own(seed):
    """With the others' gain an autoregression stands for the walk, and its mean is believed twice as much as it may."""
    rng = np.random.default_rng(seed)
    walks = np.array([0.002, 0.002, 0.05])
    flights = [wandering(rng, 1500, walk=walks) for _ in range(4)]
    filters = estimate(flights, [np.zeros(1500, dtype=int)] * 4, difference=True)
    assert filters[0].gain == filters[1].gain
    assert filters[2].gain > 5 * filters[0].gain
    assert doubted(filters[2], flights[0][:, 2], walks[2]) < 1.7


def test_a_flight_in_pieces_has_no_say():
    """No stretch of it is as long as the autoregression: its error under it is no number."""
    rng = np.random.default_rng(7)
    whole, pieces = wandering(rng, 2000), wandering(rng, 60)
    found = estimate([whole, pieces], [np.zeros(2000, dtype=int), np.arange(60) // 5], difference=True)
    assert all(w.gain < 0.1 for w in found)
    assert all(np.isfinite(w.deviation) for w in found)
