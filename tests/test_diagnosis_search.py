"""The search: numbers held at bounds, tolerances beside it, axes that say nothing, noise that wanders."""

from types import SimpleNamespace

import numpy as np
import pytest

from infotraj.diagnosis.constancy import MOST, inconstancy
from infotraj.diagnosis.null import null_gains
from infotraj.diagnosis.silent import _explained
from infotraj.diagnosis.standins import newcomer
from infotraj.diagnosis.subsets import SubsetSearch
from infotraj.diagnosis.sums import Sums, held_out
from infotraj.diagnosis.whitened import moving_mean


def sums_of(columns, residual, blocks=8, folds=8):
    """Sums of one axis over `blocks` blocks of equal length, in `folds` folds."""
    parts = np.array_split(np.arange(len(residual)), blocks)
    gram = np.array([[columns[i].T @ columns[i] for i in parts]])
    right = np.array([[columns[i].T @ residual[i] for i in parts]])
    square = np.array([[residual[i] @ residual[i] for i in parts]])
    fold = np.arange(blocks) * folds // blocks
    return Sums(gram, right, square, np.ones((1, blocks)), ("fx",), fold, fold)


def candidates_of(count, low=-10.0, high=10.0):
    """One candidate a column, absent at 0, of usual size 1."""
    choices = tuple(
        SimpleNamespace(
            columns=(i,),
            candidate=SimpleNamespace(label=f"c{i}", name=f"c{i}"),
            now=np.zeros(1),
            scale=np.ones(1),
            low=np.array([low]),
            high=np.array([high]),
        )
        for i in range(count)
    )
    empty = np.zeros(0)
    return SimpleNamespace(of_members=(), now=empty, scale=empty, low=empty, high=empty, choices=choices)


def test_a_number_is_held_at_its_bound():
    rng = np.random.default_rng(0)
    columns = rng.standard_normal((800, 2))
    residual = 3.0 * columns[:, 0] + 0.5 * columns[:, 1] + 0.1 * rng.standard_normal(800)
    subsets = SubsetSearch(sums_of(columns, residual), candidates_of(2, high=1.0))
    both = subsets.score([(0, 1)])[0]
    assert both.theta == pytest.approx([1.0, 0.5], abs=0.2)
    assert list(both.free) == [False, True]
    assert np.isfinite(both.gain)
    assert both.gain > subsets.score([(1,)])[0].gain


@pytest.mark.parametrize(("true", "gains"), [(1.0, False), (8.0, True)])
def test_a_candidate_gains_what_its_tolerance_does_not_explain(true, gains):
    rng = np.random.default_rng(1)
    columns = 100.0 * rng.standard_normal((800, 1))
    residual = 0.01 * true * columns[:, 0] + rng.standard_normal(800)
    subsets = SubsetSearch(sums_of(columns, residual), candidates_of(1), ([0], np.array([0.01])))
    gain = subsets.score([(0,)])[0].gain - subsets.score([()])[0].gain
    # In units of the noise: the square of the number over its tolerance, however many samples there are.
    assert gain == pytest.approx(true**2, abs=0.25 * true**2 + 1.0)
    assert (gain > 15.0) == gains


def one_flight_only(rng, leak):
    """Two columns of which the second shows in the third of four flights; elsewhere it is `leak` of that."""
    columns = rng.standard_normal((1600, 2))
    columns[:, 1] *= np.where(np.arange(1600) // 400 == 2, 1.0, leak)
    # A slow error elsewhere that happens to look like the second column a little.
    wrong = np.where(np.arange(1600) // 400 == 2, 0.0, 30.0 * leak * columns[:, 1])
    return columns, columns @ [1.0, 2.0] + wrong + rng.standard_normal(1600)


@pytest.mark.parametrize("leak", [0.0, 0.01, 0.03])
def test_what_shows_in_one_flight_only_is_confirmed_within_it(leak):
    columns, residual = one_flight_only(np.random.default_rng(4), leak)
    sums = sums_of(columns, residual, blocks=32, folds=4)
    gain = (held_out(sums, [0])[0] - held_out(sums)[0]).sum()
    # In units of the noise: what the column explains in its flight, less what estimating it twice costs.
    assert gain == pytest.approx(4.0 * 400, rel=0.15)
    subsets = SubsetSearch(sums, candidates_of(2))
    assert subsets.score([(0, 1)])[0].gain - subsets.score([(0,)])[0].gain == pytest.approx(gain, rel=1e-3)
    theta = held_out(sums)[1]
    own = theta[sums.fold == 2]
    assert len(np.unique(np.round(own[:, 1], 9))) == 2
    assert own[:, 1] == pytest.approx(2.0, abs=0.5)


def test_what_shows_in_one_flight_only_gains_nothing_by_chance():
    rng = np.random.default_rng(5)
    columns, _ = one_flight_only(rng, 0.01)
    sums = sums_of(columns, rng.standard_normal(1600), blocks=32, folds=4)
    gains = null_gains(sums, candidates_of(2), [(1,)], rng)
    assert gains.mean() < 0.0
    assert (held_out(sums, [0])[0] - held_out(sums)[0]).sum() < np.quantile(gains, 0.99)


def test_a_column_that_shows_nowhere_has_no_part_in_what_shows_in_one_flight_only():
    rng = np.random.default_rng(7)
    one, _ = one_flight_only(rng, 0.01)
    two, _ = one_flight_only(rng, 0.01)
    columns = np.column_stack([one[:, 0], one[:, 1], two[:, 1], np.zeros(1600)])
    sums = sums_of(columns, rng.standard_normal(1600), blocks=32, folds=4)
    assert np.isfinite(null_gains(sums, candidates_of(4), [(0, 1, 2, 3)], rng)).all()
    assert np.isfinite(held_out(sums)[0]).all()


@pytest.mark.parametrize(("amplitude", "holds"), [(0.1, True), (1.0, False)])
def test_an_effect_whose_number_changes_on_the_way_is_found_out(amplitude, holds):
    rng = np.random.default_rng(6)
    columns = rng.standard_normal((3200, 1))
    number = 1.0 + amplitude * np.sin(2 * np.pi * np.arange(3200) / 1600)
    residual = number * columns[:, 0] + rng.standard_normal(3200)
    sums = sums_of(columns, residual, blocks=32, folds=4)
    gram, right, _ = sums.total()
    best = right.sum(axis=0) / gram.sum(axis=0)[:, 0]
    explained = float(best[0] * right.sum())
    share = inconstancy(sums.shifted(best), [0], abs(best[0]), explained)
    assert (share < MOST) == holds
    assert share == pytest.approx(amplitude**2 / 2, abs=0.1)


def test_where_an_effect_hardly_shows_it_is_not_found_to_change():
    rng = np.random.default_rng(8)
    columns = rng.standard_normal((3200, 1))
    columns[800:] *= 0.01
    drift = 0.3 * np.sin(np.arange(3200) / 150.0)
    sums = sums_of(columns, columns[:, 0] + drift + rng.standard_normal(3200), blocks=32, folds=4)
    gram, right, _ = sums.total()
    best = right.sum(axis=0) / gram.sum(axis=0)[:, 0]
    assert inconstancy(sums.shifted(best), [0], abs(best[0]), float(best[0] * right.sum())) < MOST / 2


def test_an_axis_that_no_column_explains_is_silent():
    rng = np.random.default_rng(2)
    measured, columns = rng.standard_normal(500), rng.standard_normal((500, 3))
    unrelated = np.column_stack([measured, measured - 3.0 * rng.standard_normal(500), columns])
    assert _explained(unrelated) < 0.2
    wrong_by_a_column = np.column_stack([measured, 2.0 * columns[:, 0], columns])
    assert _explained(wrong_by_a_column) is None


def test_slow_errors_are_taken_off_before_the_noise_is_estimated():
    t = 0.01 * np.arange(3000)
    rng = np.random.default_rng(3)
    noise = rng.standard_normal((3000, 1))
    slow = 50.0 * np.sin(0.2 * t)[:, None]
    run = (t > 12.0).astype(int)
    left = slow + noise - moving_mean(slow + noise, run, 200)
    assert np.std(left[300:900] - noise[300:900]) < 0.7


def test_what_is_new_in_a_fit_is_found_whatever_the_order_of_its_members():
    rest = [SimpleNamespace(candidate=SimpleNamespace(label=label)) for label in ("battery_sag", "servo_bias")]
    new = SimpleNamespace(candidate=SimpleNamespace(label="thrust_scale"))
    assert newcomer(SimpleNamespace(members=(rest[1], new, rest[0])), rest) is new
