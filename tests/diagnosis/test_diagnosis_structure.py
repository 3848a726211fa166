"""What is left that can be predicted: how much, whether chance says as much, and what it goes with."""

import numpy as np
import pytest

from infotraj.diagnosis.judge.features import BIN, smooth
from infotraj.diagnosis.judge.unexplained import (
    _axis,
    _binned_change,
    _formula,
    _least,
    _loudness,
    _plain_rise,
    _Stages,
    _Table,
)
from infotraj.models.recorded import Samples

ROWS, FOLDS = 130, 4
FOLD = np.repeat(np.arange(FOLDS), ROWS)


def random(seed, *shape):
    return np.random.default_rng(seed).standard_normal((ROWS * FOLDS, *shape))


def table(target, features, names=("a", "b", "c"), axes=("fx", "fy", "fz"), measured=None):
    nothing = np.zeros_like(target)
    return _Table(axes, target, nothing if measured is None else measured, features, names, FOLD, [], np.zeros(0))


def test_what_features_say_is_predicted_on_folds_that_were_not_fitted():
    few, many = random(0, 3), random(1, 60)
    y = few @ [1.0, -2.0, 0.0] + 0.3 * random(2)
    share, fitted = _Stages([few], FOLD).held_out(y)
    assert share == pytest.approx(1.0 - 0.09 / 5.09, abs=0.01)
    np.testing.assert_allclose(fitted, y, atol=1.5)
    # What a group of its own says comes on top of it, and sixty that say nothing take nothing away.
    more = y + many[:, :5].sum(axis=1)
    assert _Stages([few, many], FOLD).held_out(more)[0] == pytest.approx(1.0 - 0.09 / 10.09, abs=0.02)
    assert _Stages([few, random(3, 60)], FOLD).held_out(y)[0] > share - 0.01


def test_a_group_that_predicts_less_than_a_fiftieth_has_no_part():
    x, rest = random(0, 1), random(1)
    little, more = (np.sqrt(s) * x[:, 0] + np.sqrt(1.0 - s) * rest for s in (0.01, 0.05))
    assert _Stages([x], FOLD).held_out(little)[0] == 0.0
    assert _Stages([x], FOLD).held_out(more)[0] == pytest.approx(0.05, abs=0.02)


def test_what_goes_with_the_velocity_alone_is_predicted_on_flights_that_differ_in_all_else():
    """A drag that grows with the third power of the speed, of flights each at a place and an attitude of its own."""
    apart = 5.0 * np.random.default_rng(1).standard_normal((FOLDS, 8))[FOLD]
    speed, rest = random(0, 3), apart + random(2, 8)
    names = ("px", "py", "pz", "vx body", "vy body", "vz body", "R13", "R23", "wx", "wy", "wz")
    columns = np.column_stack([rest[:, :3], speed, rest[:, 3:]])
    columns = (columns - columns.mean(axis=0)) / columns.std(axis=0)
    groups = smooth(columns, names, np.random.default_rng(3))
    assert [g.shape for g in groups] == [(len(FOLD), 120)] * 3
    y = speed[:, 0] * (speed**2).sum(axis=1)
    y = y - speed @ np.linalg.lstsq(speed, y, rcond=None)[0]
    assert _Stages(groups, FOLD).held_out(y / y.std())[0] > 0.7
    assert _Stages(groups[:2], FOLD).held_out(y / y.std())[0] < 0.2
    still = smooth(columns[:, 3:6], names[3:6], np.random.default_rng(3))
    assert len(still) == 2


def test_noise_is_not_predicted_and_neither_is_what_holds_in_one_fold_alone():
    x = random(0, 40)
    assert _Stages([x], FOLD).held_out(random(1))[0] < 0.02
    turned = x[:, 0] * np.array([1.0, -1.0, 1.0, -1.0])[FOLD]
    assert _Stages([x[:, :1]], FOLD).held_out(turned)[0] < 0.02


def test_what_a_shifted_residual_gives_is_chance():
    """A period of a thirteenth of a fold is the same after each of twelve shifts; white noise is another."""
    periodic = np.sin(2.0 * np.pi * np.arange(ROWS * FOLDS) / 10.0)
    white = random(5)
    target = np.stack([periodic, white, white], axis=1) + 0.1 * random(6, 3)
    features = np.column_stack([periodic, white, random(7), np.ones(len(white))])
    made = table(target, (features,))
    ridge = _Stages(made.features, FOLD)
    _, (share, chance, *_), _ = _axis(made, ridge, 0)
    assert share > 0.9
    assert chance == pytest.approx(share, abs=0.02)
    _, (share, chance, *_), fitted = _axis(made, ridge, 1)
    assert share > 0.9
    assert chance < 0.05
    np.testing.assert_allclose(fitted, white, atol=0.6)


def test_what_is_left_goes_with_the_quantities_that_correlate_most_of_either_sign():
    names = ("a", "b", "c", "d")
    x = random(0, 4)
    target = np.repeat((x @ [0.5, -2.0, 0.0, 1.0])[:, None], 3, axis=1) * 0.01
    made = table(target, (np.column_stack([x, np.ones(len(x))]),), names, ("tx", "ty", "tz"))
    axis, (_, _, goes, hint, hint_share), _ = _axis(made, _Stages(made.features, FOLD), 2)
    assert axis == "tz"
    assert [name for name, _ in goes] == ["b", "d", "a"]
    size = np.sqrt(0.25 + 4.0 + 1.0)
    assert [r for _, r in goes] == pytest.approx([-2.0 / size, 1.0 / size, 0.5 / size], abs=0.1)
    assert hint == "tz goes with b + d + a"
    assert hint_share == pytest.approx(1.0, abs=0.01)


def test_a_formula_names_no_term_that_adds_less_than_three_hundredths():
    x = random(0, 3)
    y = x @ [1.0, 0.1, 0.0] + 0.1 * random(1)
    hint, share = _formula(x, ("a", "b", "c"), y, FOLD, "fx")
    assert hint == "fx goes with a"
    assert share == pytest.approx(1.0 - 0.02 / 1.02, abs=0.01)
    assert _formula(x, ("a", "b", "c"), random(2), FOLD, "fx") == (None, 0.0)
    # What goes the other way on every second fold is no formula, though each fold by itself has one.
    turned = x[:, 0] * np.array([1.0, -1.0, 1.0, -1.0])[FOLD]
    assert _formula(x, ("a", "b", "c"), turned, FOLD, "fx") == (None, 0.0)


def test_what_is_loud_is_slow_far_above_its_noise_and_a_share_of_gravity_or_of_the_motion():
    t = BIN * np.arange(ROWS * FOLDS)
    slow, fast = np.sin(2.0 * np.pi * 0.2 * t), 0.01 * random(0)

    def loud(axis, size, noise=1.0, measured=0.0):
        made = table(np.zeros((len(t), 3)), (), axes=(axis,) * 3, measured=np.full((len(t), 3), measured))
        return _loudness(size * slow + noise * fast, made, 0, 9.81)

    root = np.sqrt(0.5)
    assert loud("fx", 1.0) == pytest.approx(root / 0.01, rel=0.1)
    assert loud("fx", 1.0, noise=20.0) is None
    least = 0.03 * 9.81 / root
    assert loud("fx", 1.1 * least) is not None
    assert loud("fx", 0.9 * least) is None
    # A change of velocity over 50 ms, and one of the rates against that which was measured.
    assert loud("vx", 1.1 * least * BIN, 0.1 * BIN) is not None
    assert loud("vx", 0.9 * least * BIN, 0.1 * BIN) is None
    assert loud("tx", 0.3, measured=1.0) is not None
    assert loud("tx", 0.25, measured=1.0) is None
    assert loud("turn x", 1.0) is None


def test_what_is_predicted_counts_by_what_it_leaves_where_it_is_more_than_the_fast_noise():
    """Bands that no model explains weigh nothing: a thrust that is lost in the middle of a flight is left there."""
    rows = np.arange(ROWS * FOLDS)
    lost, noise = np.where(rows % ROWS > ROWS / 2, -1.0, 0.0), random(0)
    assert _plain_rise(lost + 0.1 * noise, 0.8 * lost, 0.75) == pytest.approx(3.0)
    assert _plain_rise(lost + 0.1 * noise, 0.8 * lost, 0.2) == pytest.approx(0.25)
    assert _plain_rise(lost + 0.6 * noise, 0.8 * lost, 0.4) == 0.0
    assert _plain_rise(noise, 0.1 * noise, 0.01) == 0.0


def test_a_rate_that_grows_evenly_has_grown_by_its_slope_over_a_bin():
    t = np.arange(0.0, 3.0, 0.01)
    rate = Samples(t, np.outer(t, [2.0, -1.0, 0.5]))
    np.testing.assert_allclose(_binned_change(rate, np.array([1.0, 1.7])), 2 * [[0.1, -0.05, 0.025]], atol=1e-12)


def test_rows_without_a_group_of_features_are_left_as_they_are():
    assert _Stages([np.zeros((ROWS * FOLDS, 0))], FOLD).held_out(random(0)) == (0.0, pytest.approx(np.zeros(520)))


def test_what_sensors_say_against_one_another_is_spoken_of_where_a_sixth_of_it_would_go():
    assert _least("tx") == _least("fz") == _least("vx") == 0.05
    # A sixth of the error is three tenths of its square.
    assert _least("turn z") == _least("push y") == pytest.approx(1.0 - (5.0 / 6.0) ** 2)
