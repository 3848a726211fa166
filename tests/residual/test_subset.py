"""k-medoids: representatives of the inputs."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from infotraj.residual.subset import LARGEST, farthest_first, k_medoids


def loss(X: np.ndarray, chosen) -> float:
    """Sum of squared distances to the nearest medoid."""
    return float(((X[:, None] - X[list(chosen)]) ** 2).sum(-1).min(axis=1).sum())


def test_finds_the_best_medoids_of_a_small_set():
    X = np.random.default_rng(0).normal(size=(14, 2))
    best = min(loss(X, c) for c in itertools.combinations(range(14), 3))
    found = min(loss(X, k_medoids(X, 3, np.random.default_rng(s))) for s in range(5))
    assert found == pytest.approx(best)


def test_farthest_first_covers_what_a_flight_reached_to_within_twice_the_best():
    """k-medoids follow where the flight mostly is; the traversal also holds what it reached once."""
    X = np.random.default_rng(3).normal(size=(12, 2))

    def reach(chosen) -> float:
        return float(np.linalg.norm(X[:, None] - X[list(chosen)], axis=2).min(axis=1).max())

    assert reach(farthest_first(X, 4)) <= 2 * min(reach(c) for c in itertools.combinations(range(12), 4))
    flight = np.concatenate([0.1 * np.random.default_rng(4).normal(size=(400, 6)), np.full((1, 6), 9.0)])
    assert 400 in farthest_first(flight, 2)
    assert sorted(farthest_first(flight, 500)) == list(range(401))
    with pytest.raises(ValueError, match="finite"):
        farthest_first(np.full((3, 2), np.nan), 2)


def test_one_medoid_a_cluster_wherever_the_origin():
    rng = np.random.default_rng(1)
    centres = 10.0 * rng.normal(size=(8, 6)) + 1e5
    X = np.repeat(centres, 40, axis=0) + 0.1 * rng.normal(size=(320, 6))
    assert sorted(k_medoids(X, 8, rng) // 40) == list(range(8))


def test_better_than_random_rows_on_a_flight():
    rng = np.random.default_rng(2)
    X = np.cumsum(rng.normal(size=(1500, 6)), axis=0)
    chosen = k_medoids(X, 40, rng)
    assert len(set(chosen)) == 40
    random = [loss(X, rng.choice(len(X), 40, replace=False)) for _ in range(20)]
    assert loss(X, chosen) < 0.8 * min(random)


def test_same_seed_same_rows():
    X = np.random.default_rng(3).normal(size=(500, 6))
    first, second = (k_medoids(X, 20, np.random.default_rng(4)) for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_fewer_rows_than_medoids():
    X = np.arange(12.0).reshape(6, 2)
    for count in (6, 7, 100):
        np.testing.assert_array_equal(k_medoids(X, count, np.random.default_rng(0)), np.arange(6))
    assert len(k_medoids(X, 0, np.random.default_rng(0))) == 0
    assert len(k_medoids(X[:0], 3, np.random.default_rng(0))) == 0


@pytest.mark.parametrize("count", [2, 3, 5, 20])
def test_repeated_rows(count):
    X = np.repeat(np.array([[0.0, 0.0], [1.0, 0.0], [5.0, 5.0]]), 20, axis=0)
    chosen = k_medoids(X, count, np.random.default_rng(0))
    assert len(set(chosen)) == count
    assert len(np.unique(X[chosen], axis=0)) == min(count, 3)


def test_many_rows_are_thinned():
    X = np.random.default_rng(5).normal(size=(3 * LARGEST, 3))
    chosen = k_medoids(X, 10, np.random.default_rng(0))
    assert len(set(chosen)) == 10
    assert chosen.max() > 2 * LARGEST
    rows = np.random.default_rng(6).choice(len(X), 10, replace=False)
    assert loss(X, chosen) < loss(X, rows)


def test_nan_is_refused():
    with pytest.raises(ValueError, match="finite"):
        k_medoids([[0.0], [np.nan]], 1, np.random.default_rng(0))
