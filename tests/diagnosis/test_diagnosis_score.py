"""Spike and slab on sums: which set is most probable, beside a file that is as wrong as it is."""

import numpy as np
import pytest
from given_sums import given_sums

from infotraj.diagnosis.select.prior import SLAB
from infotraj.diagnosis.select.score import Choice, Scorer, diluted

RNG = np.random.default_rng(0)


def sums_of(r, s, folds=4):
    """Sums of a residual (n,) and columns (n, p) on one axis, noise of variance 1."""
    x = np.column_stack([r, s])
    parts = np.array_split(x, folds)
    gram = np.array([[p.T @ p for p in parts]])
    return given_sums(gram, np.array([[len(p) for p in parts]]), ("fx",))


def scorer(r, s, names, spike=None, low=-np.inf, high=np.inf, price=3.0):
    p = s.shape[1]
    choices = [Choice(n, (i,), price) for i, n in enumerate(names)]
    bounds = np.broadcast_to(low, p).astype(float), np.broadcast_to(high, p).astype(float)
    return Scorer(sums_of(r, s), choices, (), np.diag(np.square(np.zeros(p) if spike is None else spike)), *bounds)


def test_the_score_is_the_marginal_likelihood():
    s = RNG.standard_normal((60, 2))
    r = s @ [0.4, 0.0] + RNG.standard_normal(60)
    made = scorer(r, s, "ab", spike=[0.0, 0.5])
    covariance = np.eye(60) + SLAB**2 * np.outer(s[:, 0], s[:, 0]) + 0.25 * np.outer(s[:, 1], s[:, 1])
    without = np.eye(60) + 0.25 * np.outer(s[:, 1], s[:, 1])

    def density(c):
        return -0.5 * (r @ np.linalg.solve(c, r) + np.linalg.slogdet(c)[1])

    both, none = made.scores([(0,), ()])
    assert both - none == pytest.approx(density(covariance) - density(without) - 3.0, abs=1e-6)


def test_the_search_finds_the_set_and_its_numbers():
    s = RNG.standard_normal((400, 8))
    r = s @ [0.0, 1.0, 0.0, -0.7, 0.0, 0.0, 0.5, 0.0] + RNG.standard_normal(400)
    found = scorer(r, s, "abcdefgh").search(6, range(8))
    assert found.chosen == (1, 3, 6)
    np.testing.assert_allclose(found.theta[[1, 3, 6]], [1.0, -0.7, 0.5], atol=0.2)
    assert found.each.shape == (4, 8)


def test_nothing_is_chosen_from_noise():
    wrong = 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        wrong += bool(
            scorer(rng.standard_normal(100), rng.standard_normal((100, 20)), range(20)).search(3, range(20)).chosen
        )
    assert wrong <= 6


@pytest.mark.parametrize(("size", "named"), [(0.3, False), (1.0, True)])
def test_a_number_is_an_effect_only_where_it_is_out_of_line_with_the_file(size, named):
    s = RNG.standard_normal((400, 1))
    r = s @ [size] + RNG.standard_normal(400)
    found = scorer(r, s, "a", spike=[0.15]).search(1, [0])
    assert bool(found.chosen) == named
    assert found.theta[0] == pytest.approx(size, abs=0.2)


def test_a_strong_effect_is_not_lost_beside_a_wrong_file():
    """Ten file numbers that are all off, one of them much as the effect is."""
    s = RNG.standard_normal((600, 11))
    s[:, 1] = 0.9 * s[:, 0] + 0.4 * s[:, 1]
    theta = np.concatenate([[1.5], 0.3 * RNG.standard_normal(10)])
    r = s @ theta + RNG.standard_normal(600)
    found = scorer(r, s, range(11), spike=[0.0] + [0.3] * 10).search(4, range(11))
    assert found.chosen == (0,)
    assert found.theta[0] == pytest.approx(1.5, abs=0.5)


def test_a_number_beyond_a_bound_is_held_there():
    s = RNG.standard_normal((400, 2))
    r = s @ [-1.0, 1.0] + RNG.standard_normal(400)
    made = scorer(r, s, "ab", low=0.0)
    found = made.search(2, range(2))
    assert found.chosen == (1,)
    assert made.solution((0, 1)).theta[0] == 0.0


def test_what_an_effect_leaves_is_not_taken_up_by_numbers_that_no_file_has():
    s = RNG.standard_normal((400, 2))
    s[:, 1] = 0.9 * s[:, 0] + 0.4 * s[:, 1]
    r = s @ [2.0, 0.0] + 0.1 * RNG.standard_normal(400)
    made = scorer(r, s, "ab", spike=[0.0, 0.1])
    full = made.solution((0,))
    assert np.abs(made.solution(()).theta[1]) > 1.0
    out = made.beside((), full.each, [0])
    np.testing.assert_allclose(out[:, 1], 0.2)
    assert (out[:, 0] == 0.0).all()


def log_density(r, covariance):
    return -0.5 * (r @ np.linalg.solve(covariance, r) + np.linalg.slogdet(covariance)[1])


def test_a_number_that_is_held_at_its_bound_is_a_known_one():
    s = RNG.standard_normal((60, 2))
    r = s @ [-1.0, 1.0] + RNG.standard_normal(60)
    made = scorer(r, s, "ab", low=-0.2)
    slab = np.eye(60) + SLAB**2 * np.outer(s[:, 1], s[:, 1])
    held, alone = made.scores([(0, 1), (1,)])
    expected = log_density(r + 0.2 * s[:, 0], slab) - log_density(r, slab) - 3.0
    assert held - alone == pytest.approx(expected, abs=1e-6)


def test_how_far_a_file_is_off_is_weighed_by_the_marginal_likelihood():
    s = RNG.standard_normal((60, 2))
    r = s @ [0.0, 0.3] + RNG.standard_normal(60)
    said = [float(scorer(r, s, "ab", spike=[0.0, size]).scores([()])[0]) for size in (0.1, 1.0, 5.0)]
    wanted = [log_density(r, np.eye(60) + size**2 * np.outer(s[:, 1], s[:, 1])) for size in (0.1, 1.0, 5.0)]
    np.testing.assert_allclose(np.diff(said), np.diff(wanted), atol=1e-6)


def test_what_flights_differ_by_is_integrated_out():
    x, scatter = RNG.standard_normal((30, 3)), np.array([0.5, 2.0])
    covariance = np.eye(30) + x[:, 1:] * scatter**2 @ x[:, 1:].T
    np.testing.assert_allclose(diluted(x.T @ x, scatter), x.T @ np.linalg.solve(covariance, x), atol=1e-9)


def with_bounds(r, s, names, low, high, **more):
    """Like `scorer`, with bounds of each number and what else a scorer takes."""
    choices = [Choice(n, (i,), 0.0) for i, n in enumerate(names)]
    prior = more.pop("prior", np.zeros((s.shape[1], s.shape[1])))
    return Scorer(sums_of(r, s), choices, more.pop("kept", ()), prior, np.array(low), np.array(high), **more)


def test_effects_that_stay_are_integrated_out_under_a_slab():
    s = RNG.standard_normal((60, 2))
    r = s @ [1.0, 0.4] + RNG.standard_normal(60)
    made = with_bounds(r, s, "ab", [-9.0, -9.0], [9.0, 9.0], kept=(0,))
    both = np.eye(60) + SLAB**2 * s @ s.T
    kept = np.eye(60) + SLAB**2 * np.outer(s[:, 0], s[:, 0])
    with_b, without = made.scores([(1,), ()])
    assert with_b - without == pytest.approx(log_density(r, both) - log_density(r, kept), abs=1e-6)


def test_numbers_and_their_covariance_are_those_of_the_posterior_on_all_folds_and_without_each():
    s = RNG.standard_normal((80, 3))
    r = s @ [1.0, -0.5, 0.2] + RNG.standard_normal(80)
    made = with_bounds(r, s, "abc", [-9.0] * 3, [9.0] * 3, prior=np.diag([0.0, 0.0, 0.3**2]), given=np.full(3, 0.1))
    known = np.diag([SLAB**-2.0, SLAB**-2.0, 0.3**-2.0])
    found = made.solution((0, 1))
    rows = np.arange(80)
    folds = [rows, *(np.delete(rows, part) for part in np.array_split(rows, 4))]
    for theta, kept in zip([found.theta, *found.each], folds, strict=True):
        x = s[kept]
        np.testing.assert_allclose(theta - 0.1, np.linalg.solve(x.T @ x + known, x.T @ r[kept]))
    free, covariance = made.covariance((0, 1))
    assert free.tolist() == [0, 1, 2]
    np.testing.assert_allclose(covariance, np.linalg.inv(s.T @ s + known))


def test_a_number_that_is_both_is_told_apart_as_what_is_new_beside_what_could_be():
    """One column under a spike of 0.3 for what was not known of it and under a slab for what is new."""
    s = RNG.standard_normal((80, 2))
    r = s @ [1.5, 0.3] + RNG.standard_normal(80)
    prior = np.array([[0.09, 0.03], [0.03, 0.04]])
    made = with_bounds(r, s, "ab", [-9.0, -9.0], [9.0, 9.0], prior=prior)
    new, each, error = made.apart((0,))
    x = np.column_stack([s, s[:, 0]])
    known = np.zeros((3, 3))
    known[:2, :2], known[2, 2] = np.linalg.inv(prior), SLAB**-2.0
    precision = x.T @ x + known
    np.testing.assert_allclose(new, [np.linalg.solve(precision, x.T @ r)[2], 0.0], atol=1e-9)
    np.testing.assert_allclose(error, [np.sqrt(np.linalg.inv(precision)[2, 2]), 0.0], atol=1e-9)
    assert each.shape == (4, 2)
    # What is new is a change within the bounds.
    assert with_bounds(r, s, "ab", [-9.0, -9.0], [0.5, 9.0], prior=prior).apart((0,))[0][0] == 0.5


@pytest.mark.parametrize(("beyond", "held"), [(2.0, False), (4.0, True)])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_number_stops_at_a_bound_and_costs_its_set_where_it_is_more_than_three_standard_errors_beyond(
    beyond, held, side
):
    """Columns of length 10 beside noise of 1: a standard error of a tenth."""
    s = np.zeros((200, 2))
    s[:100, 0] = s[100:, 1] = 1.0
    r = side * s @ [0.1 * beyond, 0.5]
    low, high = ([-9.0, -9.0], [0.0, 9.0]) if side > 0 else ([0.0, -9.0], [9.0, 9.0])
    made = with_bounds(r, s, "ab", low, high)
    theta = made.solution((0, 1)).theta
    assert theta[0] == 0.0
    assert theta[1] == pytest.approx(0.5 * side, rel=0.01)
    # A set of which nothing is left free is none.
    assert np.isfinite(made.scores([(0,)])[0]) != held


def test_what_is_left_beside_a_number_at_its_bound_is_fitted_without_it():
    """Two columns that go together: held at 0, the first leaves all of what it would have taken to the second."""
    s = RNG.standard_normal((400, 2))
    s[:, 1] = 0.6 * s[:, 0] + 0.8 * s[:, 1]
    r = s @ [-1.0, 1.0] + 0.1 * RNG.standard_normal(400)
    made = with_bounds(r, s, "ab", [0.2, -9.0], [9.0, 9.0])
    left = r - 0.2 * s[:, 0]
    alone = (s[:, 1] @ left) / (s[:, 1] @ s[:, 1] + SLAB**-2.0)
    assert made.solution((0, 1)).theta == pytest.approx([0.2, alone])
    held = made.scores([(0, 1)])[0]
    slab = np.eye(400) + SLAB**2 * np.outer(s[:, 1], s[:, 1])
    none = made.scores([()])[0]
    assert held - none == pytest.approx(log_density(left, slab) - log_density(r, np.eye(400)), abs=1e-5)


def test_sets_of_all_widths_are_scored_at_once_with_what_is_held_at_a_bound():
    """The second number is held at 0: a set with it is worth its price less, and by itself says nothing."""
    s = RNG.standard_normal((60, 3))
    r = s @ [1.0, -1.0, 0.5] + RNG.standard_normal(60)
    made = with_bounds(r, s, "abc", [0.0] * 3, [9.0] * 3)
    sets = {(): [], (0,): [0], (1,): None, (0, 1): [0], (2, 0): [0, 2], (0, 1, 2): [0, 2]}
    found = made.scores(list(sets))
    for score, (chosen, free) in zip(found, sets.items(), strict=True):
        if free is None:
            assert score == -np.inf
            continue
        covariance = np.eye(60) + SLAB**2 * s[:, free] @ s[:, free].T
        price = sum(made.choices[i].price for i in chosen)
        expected = log_density(r, covariance) - log_density(r, np.eye(60)) - price
        assert score - found[0] == pytest.approx(expected, abs=1e-6)


def test_a_number_at_its_bound_may_make_a_set_more_probable_than_it_is_without_bounds():
    """A number that the data tell well costs more nats, being free, than a bound near it."""
    s = np.diag(np.sqrt([1e8, 10.0, 10.0, 10.0]))
    r = np.array([1.0004e8, 12.0, 0.0, 0.0]) / np.diag(s)
    held, free = (with_bounds(r, s, "abcd", [-9.0] * 4, [x, 9.0, 9.0, 9.0]) for x in (1.0, 9.0))
    more = held.scores([(0, 1)])[0] - free.scores([(0, 1)])[0]
    # Held, it leaves more to noise, and spares the nats of a number that is not known beforehand.
    fall = 0.5 * (1.0004e8**2 / (1e8 + SLAB**-2.0)) - (1.0004e8 - 0.5e8)
    assert more == pytest.approx(0.5 * np.log(1e8 * SLAB**2 + 1.0) - fall, abs=1e-6)
    assert held.search(2, range(4), exhaustive=1, beam=1).chosen == (0, 1)


def test_columns_that_are_the_same_to_the_last_digit_make_no_set():
    s = np.full((4, 2), 0.5e9)
    made = scorer(s[:, 0] + [1.0, -1.0, 2.0, 0.5], s, "ab")
    both, one = made.scores([(0, 1), (0,)])
    assert both == -np.inf
    assert np.isfinite(one)
    assert len(made.search(2, range(2)).chosen) == 1


@pytest.mark.parametrize("folds", [4, 1])
def test_what_flights_differ_by_counts_where_there_are_several(folds):
    s = RNG.standard_normal((80, 1))
    r = s[:, 0] + RNG.standard_normal(80)
    sums = sums_of(r, s, folds)
    made = Scorer(
        sums, [Choice("a", (0,), 0.0)], (), np.zeros((1, 1)), np.full(1, -9.0), np.full(1, 9.0), None, np.ones(1)
    )
    precision = sum(1.0 / (1.0 + 1.0 / (x @ x)) if folds > 1 else x @ x for x in np.array_split(s[:, 0], folds))
    assert made.covariance((0,))[1][0, 0] == pytest.approx(1.0 / (precision + SLAB**-2.0))


def test_numbers_that_are_known_together_stay_near_where_they_are_beside_the_effect():
    """The first number takes the effect's error; known to 0.1 it may go further than that by two deviations."""
    s = RNG.standard_normal((400, 3))
    s[:, 2] = s[:, 0]
    r = s @ [0.0, 0.0, 3.0] + 0.1 * RNG.standard_normal(400)
    prior = np.zeros((3, 3))
    prior[:2, :2] = [[0.01, 0.002], [0.002, 0.01]]
    made = with_bounds(r, s, "abc", [-9.0] * 3, [9.0] * 3, prior=prior)
    assert made.correlated
    beside = made.beside((), np.zeros((4, 3)), [2])
    known = np.linalg.inv(prior[:2, :2])
    for theta in beside:
        off = np.sqrt(theta[:2] @ known @ theta[:2])
        assert 0.8 < off <= 2.0 + 0.3
        assert theta[2] == 0.0
    assert np.abs(made.solution(()).each[:, 0]).min() > 0.5


def test_a_days_numbers_are_those_of_the_posterior_but_for_a_way_that_no_day_goes():
    """Two numbers known to 0.5 and 0.05 together, the second 0.5 off; beside them one that is chosen."""
    s = RNG.standard_normal((400, 3))
    prior = np.zeros((3, 3))
    prior[:2, :2] = [[0.25, 0.01], [0.01, 0.0025]]

    def of(off, chosen=(2,)):
        r = s @ [0.4, off, 1.5] + 0.01 * RNG.standard_normal(400)
        made = with_bounds(r, s, "abc", [-9.0] * 3, [9.0] * 3, prior=prior, given=np.full(3, 0.1))
        return made.of_a_day(chosen) - 0.1, r

    near, r = of(0.05)
    known = np.zeros((3, 3))
    known[:2, :2], known[2, 2] = np.linalg.inv(prior[:2, :2]), SLAB**-2.0
    np.testing.assert_allclose(near, np.linalg.solve(s.T @ s + known, s.T @ r), atol=1e-9)
    far, _ = of(0.5)
    distance = np.sqrt(far[:2] @ np.linalg.solve(prior[:2, :2], far[:2]))
    assert 3.0 - 1e-9 < distance <= np.hypot(3.0, 3.0)
    assert far[1] < 0.2 < far[0]
    # Of nothing that is chosen the known numbers alone are told; what is known and chosen has both.
    assert of(0.05, ())[0][2] == 0.0
    both, r = of(0.05, (0, 2))
    wide = np.zeros((3, 3))
    wide[:2, :2], wide[2, 2] = np.linalg.inv(prior[:2, :2] + np.diag([SLAB**2, 0.0])), SLAB**-2.0
    np.testing.assert_allclose(both, np.linalg.solve(s.T @ s + wide, s.T @ r), atol=1e-9)


def test_a_day_is_no_further_off_in_all_its_ways_together_than_days_are():
    """Forty numbers that flights tell as well as one another: one of them 20 deviations off is left for the most."""
    s = np.linalg.qr(RNG.standard_normal((400, 40)))[0] * 100.0
    prior = 0.01 * np.eye(40)
    prior[0, 1] = prior[1, 0] = 1e-4  # known together
    off = np.zeros(40)
    off[7] = 2.0
    made = with_bounds(s @ off, s, range(40), [-9.0] * 40, [9.0] * 40, prior=prior)
    found = made.of_a_day(())
    assert 0.1 * np.linalg.norm(off) < np.linalg.norm(found) < 0.45 * np.linalg.norm(off)


def test_one_number_does_not_take_what_many_others_are_off_by_to_make_up_for_an_effect():
    """Twenty numbers are one deviation off, which the data tell; the one like the effect goes two further, not more."""
    s = RNG.standard_normal((400, 22))
    s[:, 21] = s[:, 0]
    r = s[:, 1:21].sum(axis=1) * 0.1 + 3.0 * s[:, 21] + 0.3 * RNG.standard_normal(400)
    prior = np.zeros((22, 22))
    prior[:21, :21] = 0.01 * np.eye(21)
    prior[0, 1] = prior[1, 0] = 1e-4
    made = with_bounds(r, s, "abcdefghijklmnopqrstuv", [-9.0] * 22, [9.0] * 22, prior=prior)
    beside = made.beside((), np.zeros((4, 22)), [21])
    assert np.abs(beside[:, 0]).max() < 0.21
    assert np.abs(beside[:, 0]).min() > 0.15
    assert beside[:, 1:21].mean() == pytest.approx(0.1, abs=0.02)


def test_beside_an_effect_that_does_nothing_numbers_are_what_they_are_without_it():
    s = RNG.standard_normal((40, 3))
    s[:, 2] *= 1e-9
    r = s @ [-0.3, 0.2, 0.0] + RNG.standard_normal(40)
    prior = np.zeros((3, 3))
    prior[:2, :2] = [[0.1, 0.02], [0.02, 0.1]]
    made = with_bounds(r, s, "abc", [-9.0] * 3, [9.0] * 3, prior=prior)
    np.testing.assert_allclose(made.beside((), np.zeros((4, 3)), [2]), made.solution(()).each)


def test_exact_data_do_not_move_what_is_known_of_numbers_further():
    """Of what the data tell a million times better than it is known, as far as of anything else."""
    s = 3e4 * RNG.standard_normal((400, 3))
    s[:, 2] = s[:, 0]
    r = 3.0 * s[:, 2] + 0.1 * RNG.standard_normal(400)
    prior = np.zeros((3, 3))
    prior[:2, :2] = [[0.01, 0.002], [0.002, 0.01]]
    made = with_bounds(r, s, "abc", [-9.0] * 3, [9.0] * 3, prior=prior)
    assert 0.15 < np.abs(made.beside((), np.zeros((4, 3)), [2])[:, 0]).max() < 0.21


def test_a_number_of_the_file_stops_at_its_own_lowest_and_the_others_make_up_for_it():
    """A lag that the file holds may be shorter by a tenth, and one that is chosen is none that is shorter."""
    s = RNG.standard_normal((400, 2))
    s[:, 1] = 0.6 * s[:, 0] + 0.8 * s[:, 1]
    r = s @ [-1.0, 1.0] + 0.1 * RNG.standard_normal(400)
    made = with_bounds(r, s, "ab", [0.0, -9.0], [9.0, 9.0], prior=np.diag([4.0, 0.0]), lowest=np.array([-0.1, -9.0]))
    for chosen, first in (((1,), -0.1), ((0, 1), 0.0)):
        left = r - first * s[:, 0]
        alone = (s[:, 1] @ left) / (s[:, 1] @ s[:, 1] + SLAB**-2.0)
        assert made.solution(chosen).theta == pytest.approx([first, alone])
        assert made.solution(chosen).each[:, 0] == pytest.approx(first)
