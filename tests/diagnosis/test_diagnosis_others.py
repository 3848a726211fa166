"""One of several numbers held against the mean of the others."""

import numpy as np
import pytest

from infotraj.diagnosis.judge.others import beside_others

X = np.array([0.1, -0.3, 0.2, 0.6])


@pytest.mark.parametrize("count", [2, 3, 4])
def test_each_is_as_far_off_as_from_the_mean_of_the_rest(count):
    apart, error = beside_others(X[:count], np.zeros((count, count)))
    assert apart == pytest.approx([X[i] - np.delete(X[:count], i).mean() for i in range(count)])
    assert error == pytest.approx(np.zeros(count))


def test_the_error_is_that_of_drawn_numbers_and_nothing_of_what_they_have_in_common():
    rng = np.random.default_rng(3)
    mixed = rng.normal(size=(4, 4))
    covariance = mixed @ mixed.T
    drawn = rng.multivariate_normal(X, covariance, size=40000)
    spread = np.std([beside_others(x, covariance)[0] for x in drawn], axis=0)
    assert beside_others(X, covariance)[1] == pytest.approx(spread, rel=0.02)
    assert beside_others(X, covariance + 9.0)[1] == pytest.approx(beside_others(X, covariance)[1])


def test_one_alone_is_as_far_off_as_it_is_large():
    apart, error = beside_others(np.array([0.3]), np.array([[0.04]]))
    assert (apart[0], error[0]) == (pytest.approx(0.3), pytest.approx(0.2))
