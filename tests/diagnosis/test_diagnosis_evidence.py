"""Evidence for an effect by made columns: how far errors fall, on which axes, how sure, and whether its size holds."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from linear_fits import BLOCKS, ROWS, linear_fit

from infotraj.diagnosis.judge import evidence as module
from infotraj.diagnosis.judge.evidence import (
    Evidence,
    any_of,
    evidence,
    form_error,
    gain_beside,
    left_by_set,
    moving,
    overdispersion,
    rise_beside,
    shared,
    translated,
    variance_along,
)

NAMES = ["linear_drag", "quadratic_drag"]
RNG = np.random.default_rng(0)


def fit(size=1.0, noise=1.0, chosen=("linear_drag",), spread=1.0, each=None, common=0.0):
    """Residual: `size` of a column of deviation `spread`, a second one that does nothing, and noise.

    each: the size in every block, in place of one; common: deviation of a size that differs from block to block by
    itself.
    """

    def rows(rng, k):
        x = np.zeros((ROWS, 3))
        x[:, 1:] = rng.standard_normal((ROWS, 2)) * [spread, 1.0]
        own = (size if each is None else each(k)) + common * rng.standard_normal()
        x[:, 0] = own * x[:, 1] + noise * rng.standard_normal(ROWS)
        return x

    return linear_fit(NAMES, rows, list(chosen))[1]


def with_sums(fitted, /, **changed):
    """The same fit with other sums."""
    return replace(fitted, linear=replace(fitted.linear, sums=replace(fitted.linear.sums, **changed)))


def windows(made, each):
    """The same fit where every block lasted so many windows."""
    products: Any = SimpleNamespace(**{**vars(made.linear.sums.made), "windows": np.full((1, BLOCKS), each)})
    return with_sums(made, made=products)


def test_the_error_falls_by_the_share_that_the_effect_has_in_it():
    """A column of variance 4 beside a noise of 1: four fifths of the square go, on every flight and resample."""
    one_flight = with_sums(fit(2.0), flight=np.zeros(BLOCKS, dtype=int))
    found = evidence(one_flight, "linear_drag", RNG)
    assert found.heldout_change == pytest.approx(-0.8, abs=0.02)
    low, high = found.ci95
    assert low < found.heldout_change < high < -0.75
    # Squares of 2000 rows, each to a share of sqrt(2 / 2000): their ratio of 0.2 to one of sqrt(4 / 2000).
    assert high - low == pytest.approx(2 * 1.96 * 0.2 * np.sqrt(4 / (BLOCKS * ROWS)), rel=0.4)
    assert found.flights_better == (BLOCKS, BLOCKS)
    assert found.selected == 1.0
    assert found.probability > 0.999
    assert found.gain == pytest.approx(0.5 * np.log(5.0), abs=0.05)
    assert found.falls == {"fx": pytest.approx(found.gain)}


def test_an_effect_that_is_not_there_is_neither_probable_nor_better():
    found = evidence(fit(0.0), "linear_drag", RNG)
    assert found.probability < 0.2
    assert found.heldout_change == pytest.approx(0.0, abs=0.01)
    assert found.gain == pytest.approx(0.0, abs=0.01)


def test_where_an_error_is_nearly_all_noise_it_falls_in_units_of_its_noise():
    """A hundred times as much noise where bands weigh nothing hides nothing of what the others say."""
    made = fit(2.0)
    sums = made.linear.sums
    believed = sums.believed.copy()
    believed[..., 0, 0] += 100.0 * sums.slow

    def products(noise):
        return SimpleNamespace(**{**vars(sums.made), "believed": believed, "noise": noise * sums.noise})

    found = evidence(with_sums(made, made=products(1.0)), "linear_drag", RNG)
    assert found.gain == pytest.approx(0.5 * np.log(5.0), abs=0.05)
    assert found.falls == {"fx": pytest.approx(found.gain)}
    absent = gain_beside(with_sums(fit(2.0, chosen=()), made=products(1.0)), 0)
    assert absent == pytest.approx(0.5 * np.log(5.0), abs=0.05)
    # Where most of what is left in these units is something else, the error as it is says all.
    assert evidence(with_sums(made, made=products(0.4)), "linear_drag", RNG).gain == pytest.approx(0.02, abs=0.005)


def test_what_one_sensor_has_against_another_falls_as_it_is_alone():
    def rows(rng, _):
        x = rng.standard_normal((2, ROWS, 3))
        x[:, :, 0] += 2.0 * x[:, :, 1]
        return x

    _, whole = linear_fit(NAMES, rows, ["linear_drag"], ("fx", "turn x"))
    believed = whole.linear.sums.believed.copy()
    believed[..., 0, 0] += 100.0 * whole.linear.sums.slow
    products: Any = SimpleNamespace(**{**vars(whole.linear.sums.made), "believed": believed})
    found = evidence(with_sums(whole, made=products), "linear_drag", RNG)
    assert found.falls == pytest.approx({"fx": 0.5 * np.log(5.0), "turn x": 0.5 * np.log(105.0 / 101.0)}, abs=0.05)


def test_what_gets_worse_as_it_is_counts_whatever_falls_in_units_of_noise():
    weighted = np.array([[4.0], [4.0], [1.0]])
    without = module._Left(weighted, np.ones(3), np.ones(3))
    kept = module._Left(np.ones((3, 1)), np.array([1.0, 4.0, 4.0]), np.ones(3))
    np.testing.assert_allclose(module._falls(without, kept), np.log([2.0, 1.0, 0.5]), atol=1e-12)
    np.testing.assert_allclose(module._falls(kept, kept), 0.0, atol=1e-12)


def test_the_rise_is_in_units_of_the_noise_a_window_and_at_least_that_of_what_is_left():
    """A square of 1 a row beside a noise of 4 that is weighed as 1: 50 rows a window, or a quarter of what is left."""
    made = fit(1.0, noise=2.0)
    assert evidence(windows(made, 1.0), "linear_drag", RNG).rise == pytest.approx(ROWS, rel=0.1)
    few = evidence(windows(made, 1e4), "linear_drag", RNG)
    assert few.rise == few.by_axis["fx"] == pytest.approx(0.25, rel=0.1)
    assert few.axis == "fx"
    own = [0]
    assert rise_beside(windows(made, 1.0), (), own) == pytest.approx(ROWS, rel=0.1)
    assert rise_beside(windows(made, 1e4), (), own) == pytest.approx(0.25, rel=0.1)


def test_an_axis_on_which_an_effect_does_nothing_is_none_of_its_falls():
    """The second effect acts on both axes, and takes the place of the first one where that is missing: what it then
    spoils of the other axis is not the first one's doing."""

    def rows(rng, _):
        x = np.zeros((2, ROWS, 3))
        x[0, :, 1] = rng.standard_normal(ROWS)
        x[0, :, 2] = 0.8 * x[0, :, 1] + 0.6 * rng.standard_normal(ROWS)
        x[1, :, 2] = rng.standard_normal(ROWS)
        x[:, :, 0] = x[:, :, 1] + 0.5 * x[:, :, 2] + rng.standard_normal((2, ROWS))
        return x

    _, whole = linear_fit(NAMES, rows, NAMES, ("fx", "fy"))
    found = evidence(whole, "linear_drag", RNG)
    assert set(found.falls) == {"fx"}
    assert found.by_axis["fy"] == 0.0
    assert found.gain == pytest.approx(found.falls["fx"])
    assert set(evidence(whole, "quadratic_drag", RNG).falls) == {"fx", "fy"}
    assert found.axis == "fx"


def test_what_moves_an_axis_by_less_than_a_thousandth_does_not_act_there():
    """Of the mean square a row, whatever the number of rows."""
    assert evidence(fit(0.1), "linear_drag", RNG).falls
    assert not evidence(fit(0.01), "linear_drag", RNG).falls


def test_one_more_effect_gains_what_its_column_takes_off():
    assert gain_beside(fit(1.0, chosen=()), 0) == pytest.approx(0.5 * np.log(2.0), abs=0.04)


def test_what_a_set_leaves_is_the_logarithm_of_the_root_mean_square():
    whole = fit(2.0, noise=3.0)
    assert left_by_set(whole) == pytest.approx([np.log(3.0)], abs=0.03)
    assert left_by_set(whole, ()) == pytest.approx([0.5 * np.log(9.0 + 4.0)], abs=0.03)


def test_axes_that_are_left_out_or_say_nothing_of_forces_are_not_judged():
    axes = ("fx", "vy", "turn x", "tz")
    observation = SimpleNamespace(ignored=frozenset({"tz"}))
    linear = SimpleNamespace(observation=observation, sums=SimpleNamespace(axes=axes))
    assert moving(SimpleNamespace(linear=linear)).tolist() == [True, True, False, False]


def some_probability(scores):
    """A fit that knows no more than the log probability of sets: the sum of what each choice has of it."""
    asked = []

    def log_probability(sets):
        asked.extend(sets)
        return np.array([sum(scores[i] for i in s) for s in sets])

    return SimpleNamespace(log_probability=log_probability), asked


@pytest.mark.parametrize("wider", [1.0, 2.0])
def test_any_of_two_others_may_be_absent(wider):
    made, _ = some_probability([1.0, -2.0, 0.7])
    sets = np.array([0.7, 1.7, -1.3, -0.3])
    assert any_of(made, (0, 1), (2,), wider) == pytest.approx(np.log(np.sum(np.exp(sets / wider))))


def test_of_many_others_those_stay_that_are_missed_most():
    made, asked = some_probability([0.1 * k for k in range(12)])
    any_of(made, tuple(range(12)), (), 1.0)
    sets = [set(s) for s in asked if len(s) != 11] or [set()]
    assert all({8, 9, 10, 11} <= s for s in sets)
    assert any(0 not in s and 7 not in s for s in sets)


def claims(*falls):
    """Evidence by label, of which the errors of axes fall by so much."""
    return {str(k): Evidence(0.0, (0.0, 0.0), (0, 0), 0.0, 0.0, "fx", falls=f) for k, f in enumerate(falls)}


def gains(whole, *falls):
    return [e.gain for e in shared(whole, claims(*falls)).values()]


def two_axes(rng, _):
    """On fx both columns act, on fz the second alone; the squared error is three times the noise on both."""
    x = np.zeros((2, ROWS, 3))
    x[0, :, 1:] = rng.standard_normal((ROWS, 2))
    x[1, :, 2] = np.sqrt(2.0) * rng.standard_normal(ROWS)
    x[:, :, 0] = x[:, :, 1:].sum(axis=2) + rng.standard_normal((2, ROWS))
    return x


def test_together_effects_claim_no_more_than_the_set_takes_off():
    """The set takes ln 3 / 2 off; two that claim that much each have half of it."""
    _, whole = linear_fit(NAMES, lambda rng, k: two_axes(rng, k)[0], NAMES)
    gain = 0.5 * np.log(3.0)
    assert gains(whole, {"fx": gain}, {"fx": gain}) == pytest.approx([0.5 * gain, 0.5 * gain], abs=0.03)
    assert gains(whole, {"fx": gain}, {"fx": -5.0}) == pytest.approx([gain, -5.0], abs=0.06)
    assert gains(whole, {"fx": 0.1}, {"fx": 0.1}) == [0.1, 0.1]
    assert gains(whole, {"fx": -1.0}) == [-1.0]


def test_what_effects_share_of_one_axis_takes_nothing_from_another():
    _, whole = linear_fit(NAMES, lambda rng, k: two_axes(rng, k).reshape(2 * ROWS, 3), NAMES, axes=("fx", "fz"))
    gain = 0.5 * np.log(3.0)
    found = gains(whole, {"fx": gain}, {"fx": gain, "fz": 0.4})
    assert found == pytest.approx([0.5 * gain, 0.5 * gain + 0.4], abs=0.04)


def test_what_others_do_on_axes_where_an_effect_does_nothing_is_no_evidence_for_it():
    """On fx one column may stand for the other; on fz, where the first does nothing, the second would then be wrong."""

    def rows(rng, _):
        x = np.zeros((2, ROWS, 3))
        x[0, :, 1] = rng.standard_normal(ROWS)
        x[0, :, 2] = 3.0 * x[0, :, 1] + 0.1 * rng.standard_normal(ROWS)
        x[1, :, 2] = rng.standard_normal(ROWS)
        x[:, :, 0] = x[:, :, 1:].sum(axis=2) + rng.standard_normal((2, ROWS))
        return x.reshape(2 * ROWS, 3)

    _, whole = linear_fit(NAMES, rows, NAMES, axes=("fx", "fz"))
    found = evidence(whole, "linear_drag", np.random.default_rng(0))
    without = whole.error(whole.scorer.beside((1,), whole.solution.each, [0]))
    kept = whole.error(whole.solution.each)
    assert found.heldout_change == pytest.approx(kept[0].sum() / without[0].sum() - 1.0)
    assert found.heldout_change != pytest.approx(kept.sum() / without.sum() - 1.0, rel=0.2)
    assert found.by_axis["fz"] == 0.0


def test_data_that_scatter_from_block_to_block_as_the_noise_says_are_no_wider():
    wider, covariance = overdispersion(fit(1.0))
    assert 1.0 <= wider < 1.5
    assert np.sqrt(covariance[0, 0]) == pytest.approx(np.sqrt(wider / (BLOCKS * ROWS)), rel=0.1)


def test_a_size_that_differs_from_block_to_block_makes_its_number_as_much_less_sure():
    """Noise of 1 over 50 rows and a deviation of 0.2: the mean of 40 sizes has a variance three times that of noise."""
    wider, covariance = overdispersion(fit(1.0, common=0.2))
    assert wider == pytest.approx(1.0 + ROWS * 0.2**2, rel=0.4)
    assert np.sqrt(covariance[0, 0]) == pytest.approx(np.sqrt(wider / (BLOCKS * ROWS)), rel=0.05)


def test_what_all_blocks_of_a_flight_say_alike_makes_a_number_as_unsure_as_flights_are():
    """Sizes that differ from flight to flight by 0.5 and more: of five flights the mean's error is that by sqrt(5)."""
    sizes, flight = np.array([0.3, 1.6, 0.9, 1.9, 0.4]), np.repeat(np.arange(5), BLOCKS // 5)
    made = with_sums(fit(each=lambda k: sizes[flight[k]]), flight=flight)
    expected = sizes.std(ddof=1) / np.sqrt(5)
    assert np.sqrt(overdispersion(made)[1][0, 0]) == pytest.approx(expected, rel=0.05)
    two = with_sums(made, flight=np.repeat(np.arange(2), BLOCKS // 2))
    assert np.sqrt(overdispersion(two)[1][0, 0]) < 0.5 * expected


def test_what_two_numbers_say_together_is_no_surer_than_flights_make_it():
    """One flight is more on the one column, another on the other: the sum differs from flight to flight by both."""
    flight = np.repeat(np.arange(5), BLOCKS // 5)
    more = np.array([[0.4, 0.5], [-0.6, -0.4], [0.2, 0.3], [-0.3, -0.6], [0.3, 0.2]])

    def rows(rng, k):
        x = rng.standard_normal((ROWS, 3))
        x[:, 0] += x[:, 1:] @ (1.0 + more[flight[k]])
        return x

    made = with_sums(linear_fit(NAMES, rows, NAMES)[1], flight=flight)
    for weight in (np.array([1.0, 0.0]), np.array([1.0, 1.0])):
        expected = (more @ weight).std(ddof=1) / np.sqrt(5)
        assert np.sqrt(variance_along(made, weight)) == pytest.approx(expected, rel=0.4)
    together = np.ones(2)
    assert variance_along(made, together) > 1.6 * together @ overdispersion(made)[1] @ together


def test_what_a_flight_has_of_its_own_is_told_by_the_flight_and_by_what_flights_differ_by():
    """The mean of a Gaussian posterior: of precision G + 1 / scatter^2."""
    x = RNG.standard_normal((20, 2))
    gram, score, scatter = x.T @ x, np.array([3.0, -5.0]), np.array([0.1, 2.0])
    expected = np.linalg.solve(gram + np.diag(scatter**-2), score)
    assert module._own(gram, score, scatter) == pytest.approx(expected)


def test_a_formula_that_holds_has_no_form_error_even_where_noise_scatters_its_size():
    made = fit(1.0, spread=0.3)
    assert form_error(made, [0], made.solution.theta) < 0.3


def test_the_form_error_is_the_share_by_which_the_size_differs():
    made = fit(each=lambda k: 1.5 if k % 2 else 0.5)
    assert form_error(made, [0], made.solution.theta) == pytest.approx(0.5, abs=0.06)
    wholly = fit(each=lambda k: 2.2 if k % 2 else -0.2)
    assert form_error(wholly, [0], wholly.solution.theta) == pytest.approx(1.2, abs=0.12)


def test_numbers_of_one_fit_stand_in_the_columns_of_another():
    def with_columns(names, each):
        columns = [SimpleNamespace(candidate=SimpleNamespace(label=n), place=0) for n in names]
        return SimpleNamespace(linear=SimpleNamespace(columns=columns), solution=SimpleNamespace(each=np.array(each)))

    whole = with_columns(["a", "b", "c"], [[1.0, 2.0, 3.0]])
    rest = with_columns(["d", "c", "a", "e"], [[7.0, 8.0, 0.0, 9.0]])
    # What the other fit does not move stays where it was.
    assert translated(whole, whole.solution.each, rest).tolist() == [[7.0, 3.0, 0.0, 9.0]]
