"""Errors of several flights together, by numbers that can be worked out by hand."""

from dataclasses import replace

import numpy as np
import pytest

from infotraj.comparing.equation_error import EquationError
from infotraj.comparing.statistics import difference, statistics
from infotraj.comparing.summary import remarks


def error_of(measured, floor):
    """An equation error whose prediction is zero, all axes alike."""
    n = len(measured)
    side = np.repeat(np.asarray(measured, dtype=float)[:, None], 6, axis=1)
    some = dict(red=np.ones(6), unit={}, force_from="", window=0.15, reasons={}, left_out={})
    return EquationError(0.1 * np.arange(n), side, np.zeros((n, 6)), np.full(6, floor), **some)


def test_a_flight_counts_as_its_rows_do():
    long, short = error_of(np.full(30, 2.0), 0.1), error_of(np.full(10, 6.0), 0.5)
    found = statistics([long, short])
    assert found.rmse == pytest.approx(np.sqrt((30 * 2.0**2 + 10 * 6.0**2) / 40))
    assert found.bias == pytest.approx((30 * 2.0 + 10 * 6.0) / 40)
    assert found.floor == pytest.approx(np.sqrt((30 * 0.1**2 + 10 * 0.5**2) / 40))
    assert (found.rows == 40).all()


def test_a_floor_that_depends_on_the_model_says_so():
    white = error_of(np.ones(30), 0.1)
    red = replace(white, red=np.full(6, 2.0))
    (said,) = remarks(statistics([red]), [red])
    assert said.endswith("the floor there is all that changes within 0.45 s unexplained, less with a better model")
    assert not list(remarks(statistics([white]), [white]))


def test_the_error_of_a_difference_is_what_it_scatters_by_from_drawing_to_drawing():
    rng = np.random.default_rng(0)
    drawn = [
        difference([error_of(rng.normal(0, 1.2, 600), 0.1)], [error_of(rng.normal(0, 1, 600), 0.1)]) for _ in range(200)
    ]
    scatter = np.std([d.mean[0] for d in drawn])
    assert np.mean([d.mean[0] for d in drawn]) == pytest.approx(0.44, abs=3 * scatter / np.sqrt(200))
    assert np.mean([d.standard_error[0] for d in drawn]) == pytest.approx(scatter, rel=0.15)
