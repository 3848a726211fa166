"""What predicts stays in the set; what does not leaves it, and what it stood for is taken in."""

import numpy as np
from linear_fits import ROWS, linear_fit

from infotraj.diagnosis.judge.needed import needed
from infotraj.diagnosis.select.predicting import TELLS

NAMES = ["linear_drag", "quadratic_drag", "rotor_drag"]


def fit(sizes, chosen, mixed=0.0, names=NAMES):
    """A residual of three columns times sizes, and noise of 1. mixed: how much of the first the second column holds."""

    def rows(rng, _):
        x = np.zeros((ROWS, 4))
        x[:, 1:] = rng.standard_normal((ROWS, 3))
        x[:, 2] = mixed * x[:, 1] + np.sqrt(1.0 - mixed**2) * x[:, 2]
        x[:, 0] = x[:, 1:] @ sizes + rng.standard_normal(ROWS)
        return x

    return linear_fit(names, rows, chosen)


def names(judged):
    return [j.member.candidate.name for j in judged]


def test_what_is_sure_and_predicts_little_leaves_the_set():
    search, whole = fit([1.0, 0.3, 0.0], ["linear_drag", "quadratic_drag"])
    told, stay, gone = needed(search, whole, np.random.default_rng(0))
    assert told.labels == ("linear_drag",)
    assert names(stay) == ["linear_drag"]
    assert names(gone) == ["quadratic_drag"]
    assert gone[0].evidence.probability > 0.999
    # Its variance is 0.09 beside a noise of 1.
    assert abs(gone[0].evidence.gain - 0.5 * np.log(1.09)) < 0.02
    assert gone[0].evidence.gain < TELLS <= stay[0].evidence.gain


def test_effects_that_all_predict_stay():
    search, whole = fit([1.0, 1.0, 1.0], NAMES)
    told, stay, gone = needed(search, whole, np.random.default_rng(0))
    assert told is whole
    assert names(stay) == NAMES
    assert not gone


def test_what_a_spurious_effect_stood_for_is_taken_in():
    """The set that was found holds a column that resembles the true one a little, and one that does nothing."""
    search, whole = fit([1.0, 0.0, 0.0], ["quadratic_drag", "rotor_drag"], mixed=0.5)
    told, stay, gone = needed(search, whole, np.random.default_rng(0))
    assert set(names(gone)) == {"quadratic_drag", "rotor_drag"}
    assert told.labels == ("linear_drag",)
    assert stay[0].evidence.gain > TELLS


def test_what_is_not_linear_is_fitted_without_once_nothing_weaker_is_left():
    """The delay is held against a fit without it, and so is the lag, but not before the weak drag has gone."""
    every = ["linear_drag", "actuation_delay", "rotor_lag"]
    search, whole = fit([0.2, 1.0, 1.0], every, names=every)
    _, stay, gone = needed(search, whole, np.random.default_rng(0))
    assert names(gone) == ["linear_drag"]
    assert set(names(stay)) == {"actuation_delay", "rotor_lag"}
    without, *rest = search.asked
    assert without == (("actuation_delay", "rotor_lag"), False)
    assert set(rest) == {(("actuation_delay",), False), (("rotor_lag",), False)}


def test_what_a_derivative_calls_weak_is_fitted_before_it_goes():
    every = ["linear_drag", "actuation_delay", "rotor_lag"]
    search, whole = fit([1.0, 0.2, 1.0], every, names=every)
    _, _, gone = needed(search, whole, np.random.default_rng(0))
    assert names(gone) == ["actuation_delay"]
    assert search.asked[0] == (("linear_drag", "rotor_lag"), False)
