"""Errors of several flights together, by numbers that can be worked out by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from infotraj.comparing.comparison import Compared
from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.comparing.statistics import difference, statistics, worst_flight
from infotraj.comparing.summary import _against, at_floor, remarks
from infotraj.comparing.thresholds import passed


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


def two_sided(measured, predicted, floor=0.1):
    return replace(error_of(measured, floor), predicted=np.repeat(np.asarray(predicted)[:, None], 6, axis=1))


def test_a_prediction_explains_what_its_error_leaves_of_the_variance():
    wave = np.sin(0.1 * np.arange(1000)) + 3.0
    found = statistics([two_sided(wave, 3.0 + 0.5 * (wave - 3.0))])
    assert found.explained == pytest.approx(np.full(6, 0.75), abs=1e-5)
    assert found.spread == pytest.approx(np.full(6, wave.std()))
    assert found.worse_than_none == []


@pytest.mark.parametrize(("share", "worse"), [(-0.2, False), (-0.3, True)])
def test_a_prediction_is_worse_than_none_where_its_error_varies_by_half_more_than_what_was_measured(share, worse):
    """An error of (1 - share) times the wave: its variance is 1.44 or 1.69 times; a bias of any size is forgiven."""
    wave = np.sin(0.1 * np.arange(1000))
    found = statistics([two_sided(wave, share * wave + 7.0)])
    assert bool(found.worse_than_none) == worse


def test_a_difference_is_of_the_first_less_the_second_over_the_second():
    rng = np.random.default_rng(0)
    noise = rng.standard_normal(1200)
    found = difference([error_of(2.0 * noise, 0.1)], [error_of(noise, 0.1)])
    assert found.mean == pytest.approx(np.full(6, 3.0), abs=0.1)
    # 0.1 s a row and 2 s a block.
    assert found.blocks == 60
    assert not found.few
    assert difference([error_of(noise[:200], 0.1)], [error_of(noise[:200], 0.1)]).few


def test_the_worst_flight_is_that_whose_error_is_farthest_above_its_floor():
    errors = [error_of(np.full(30, 1.0), 0.5), error_of(np.full(30, 0.8), 0.1), error_of(np.full(30, 2.0), 1.0)]
    assert worst_flight(errors) == 1


@pytest.mark.parametrize(("limit", "above"), [(1.9, True), (2.1, False)])
def test_a_threshold_is_passed_by_the_worst_axis_of_its_kind(limit, above):
    made = error_of(np.full(30, 2.0), 0.1)
    made.measured[:, 0] = 1.0
    made = replace(made, unit={"force": "N", "torque": "N m"})
    said = passed(Compared("m", None, (made,), ()), {"force": limit})
    assert [line.split()[0] for line in said] == (["fy"] if above else [])


def test_an_error_is_at_its_floor_within_a_half_on_every_axis_that_can_be_said():
    near, far = error_of(np.full(30, 1.4), 1.0), error_of(np.full(30, 1.4), 1.0)
    far.measured[:, 4] = 1.6
    assert at_floor(statistics([near]))
    assert not at_floor(statistics([far]))
    silent = replace(near, measured=np.full((30, 6), np.nan))
    assert not at_floor(statistics([silent]))


@pytest.mark.parametrize(("errors", "sure"), [(1.9, False), (2.1, True)])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_change_beyond_two_of_its_standard_errors_has_a_star(errors, sure, sign):
    apart = SimpleNamespace(
        mean=np.array([sign * errors * 0.1, *5 * [np.nan]]), standard_error=np.full(6, 0.1), blocks=5, few=True
    )
    models = [SimpleNamespace(name="one"), SimpleNamespace(name="other")]
    said = _against(SimpleNamespace(models=models, differences=lambda: [apart])).splitlines()[1]
    assert f"{AXES[0]} {sign * errors * 10:+.1f} +- 10.0" in said
    assert ("*" in said) is sure
    assert "5 blocks" in said
