"""Which candidate is flown (eq. 18), what its cost is of, and the numbers that Fig. 4 and Table I are made of."""

import numpy as np
import pytest

from infotraj.evaluation.angular_acceleration import AxisErrors
from infotraj.evaluation.intervals import bootstrap_mean
from infotraj.experiment.paper.selecting import Scored
from infotraj.informative import region
from infotraj.informative.cost import Scorer
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.subset import k_medoids


def test_the_candidate_that_leaves_least_variance_is_chosen_and_never_the_task():
    # Three candidates and the task; two draws. By the mean the second is best, by one draw the first.
    costs = np.array([[0.5, 4.0], [1.0, 2.0], [3.0, 3.0], [0.1, 0.1]])
    scored = Scored([None] * 4, np.zeros((4, 2, 1, 6)), costs, np.zeros((1, 6)), None)
    assert scored.chosen == 1
    table = scored.table()
    assert table["candidate"].tolist() == [0, 1, 2, -1]
    assert table["chosen"].tolist() == [False, True, False, False]
    assert table["cost"].tolist() == [2.25, 1.5, 3.0, pytest.approx(0.1)]
    assert table["cost_std"].tolist() == [1.75, 0.5, 0.0, 0.0]


def a_prior(points=0):
    X = np.random.default_rng(0).uniform(-1, 1, (points, 6))
    return GaussianProcess(X, np.zeros((points, 3)), np.full((3, 6), 1.0), np.ones(3), np.full(3, 1e-4), np.zeros(3))


def test_each_cost_is_of_its_own_candidate_and_draw():
    """Each flight stays near a place of its own: the cost grows with that place's distance from the region."""
    away = np.array([[0.0, 2.0, 0.5], [3.0, 1.0, 1.5]])  # (candidates, draws)
    rng = np.random.default_rng(1)
    flights = 0.3 * rng.standard_normal((2, 3, 60, 6))
    flights[..., 0] += away[..., None]
    where = 0.3 * rng.standard_normal((50, 6))
    costs = Scorer(a_prior(4), where, 10, k_medoids).costs(flights, np.random.default_rng(2))
    assert np.array_equal(np.argsort(costs, axis=None), np.argsort(away, axis=None))


def test_epsilon_of_a_residual_that_is_off_by_a_constant_is_that_constant():
    """u + g' = u' + mu: where g' is mu plus c, every command moves by -c."""
    process, off = a_prior(), np.array([0.3, -0.4, 1.2])

    def draws(commands):
        return np.broadcast_to(off, (*commands.shape[:-1], 3))

    commands = np.random.default_rng(6).uniform(-1, 1, (4, 30, 6))
    assert region.epsilon(process, draws, commands) == pytest.approx(1.3, rel=2e-3)


def test_the_spread_of_figure_4_is_over_time_of_the_mean_over_the_axes():
    axes_differ = AxisErrors(np.arange(4.0), np.tile([1.0, 2.0, 6.0], (4, 1)))
    assert (axes_differ.mean, axes_differ.spread) == (3.0, 0.0)
    times_differ = AxisErrors(np.arange(4.0), np.array([1.0, 3.0, 1.0, 3.0])[:, None] * np.ones(3))
    assert (times_differ.mean, times_differ.spread) == (2.0, 1.0)


def test_plants_weigh_alike_however_many_runs_each_has():
    values, plants = [0.0] * 9 + [10.0], ["a"] * 9 + ["b"]
    made = bootstrap_mean(values, plants)
    assert (made.mean, made.low, made.high, made.runs) == (5.0, 5.0, 5.0, 10)  # within a plant nothing varies
    assert bootstrap_mean(values).mean == 1.0


def test_the_interval_is_as_wide_as_the_runs_scatter():
    """Of n runs with standard deviation s: 1.96 s / sqrt(n) to each side; of two plants, their mean's."""
    rng = np.random.default_rng(7)
    values = rng.standard_normal(400)
    whole = bootstrap_mean(values)
    assert (whole.high - whole.low) / 2 == pytest.approx(1.96 * values.std() / 20, rel=0.05)
    plants = np.repeat(["a", "b"], 200)
    apart = bootstrap_mean(values + 100.0 * (plants == "b"), plants)
    within = np.sqrt(values[:200].var() / 200 + values[200:].var() / 200) / 2
    assert (apart.high - apart.low) / 2 == pytest.approx(1.96 * within, rel=0.05)
