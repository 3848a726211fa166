"""A window against the rest of its flight, and a place's trend on other flights, by numbers that are known."""

import numpy as np
import pytest

from infotraj.comparing.equation_error import EquationError
from infotraj.locating.healthy import _trend
from infotraj.locating.places import Place, find_places
from infotraj.locating.quantities import Quantity
from infotraj.locating.samples import Samples
from infotraj.locating.windows import worst_windows


def test_a_window_stands_beside_the_rest_of_the_flight_without_it():
    t = 0.01 * np.arange(1000)
    measured = np.where(np.arange(1000) % 2, 1.0, -1.0)[:, None] * np.ones(6)
    measured[:, 1:] *= 0.1
    measured[500:600, 0] *= 20.0
    some = dict(red=np.ones(6), unit={}, force_from="", window=0.15, reasons={}, left_out={})
    (found,) = worst_windows([EquationError(t, measured, np.zeros((1000, 6)), np.ones(6), **some)])
    assert (found.axis, found.start, found.stop) == ("fx", pytest.approx(5.0), pytest.approx(6.0))
    assert found.rms == pytest.approx(20.0)
    assert found.ratio == pytest.approx(20.0)
    assert found.over_floor == pytest.approx(20.0)


@pytest.mark.parametrize(("times", "stands_out"), [(1.4, False), (1.6, True)])
def test_a_window_far_above_the_floor_stands_out_where_it_is_half_again_as_large_as_the_rest(times, stands_out):
    """All of the flight is ten times the floor: what is 1.4 times the rest is of the flight, 1.6 times is not."""
    t = 0.01 * np.arange(1000)
    measured = np.where(np.arange(1000) % 2, 1.0, -1.0)[:, None] * np.ones(6)
    measured[500:600, 0] *= times
    some = dict(red=np.ones(6), unit={}, force_from="", window=0.15, reasons={}, left_out={})
    found = worst_windows([EquationError(t, measured, np.zeros((1000, 6)), np.full(6, 0.1), **some)])
    assert [w.axis for w in found] == ["fx"] * stands_out


def rows_of(residual, *quantities):
    n = len(residual)
    return Samples(
        ("fx",), residual[:, None], np.array([0.1]), "N", np.zeros(n, dtype=int), 0.05 * np.arange(n), 0.05, quantities
    )


def test_a_healthy_flight_has_the_share_of_a_trend_that_it_has_whatever_its_bias():
    rng = np.random.default_rng(0)
    speed = Quantity("speed", "speed", "m/s", rng.uniform(1.0, 5.0, 4000))
    knots = np.linspace(1.0, 5.0, 9)
    trend = (knots, 0.4 * (knots - 1.0))
    place = Place("fx", "N", speed, None, 0.01, 1.0, 0.5, 1.0, 0.1, None, trend)
    rows = rows_of(0.6 * np.interp(speed.values, *trend) + 7.0 + 0.01 * rng.standard_normal(4000), speed)
    assert _trend(rows, place, np.ones(4000, dtype=bool)) == pytest.approx(0.6, abs=0.01)


@pytest.mark.parametrize(("shared", "alike"), [(0.999, ("body tilt",)), (0.75, ())])
def test_a_quantity_is_alike_that_does_as_well_and_not_one_that_merely_goes_with_it(shared, alike):
    rng = np.random.default_rng(1)
    drawn = rng.standard_normal((2, 2000))
    speed = Quantity("speed", "speed", "m/s", drawn[0])
    tilt = Quantity("body tilt", "tilt", "rad", shared * drawn[0] + np.sqrt(1 - shared**2) * drawn[1])
    residual = 0.5 * drawn[0] + 0.1 * rng.standard_normal(2000)
    found = find_places(rows_of(residual, speed, tilt), np.random.default_rng(0), draws=99)
    assert found.places[0].quantity.name == "speed"
    assert found.places[0].alike == alike


def test_the_window_that_stands_furthest_above_its_floor_is_first_in_whatever_unit_its_error_is():
    """Forces of 20 times the floor beside torques of 40 times theirs, which are smaller numbers."""
    t = 0.01 * np.arange(1000)
    measured = np.where(np.arange(1000) % 2, 1.0, -1.0)[:, None] * np.array([1.0, 1.0, 1.0, 0.01, 0.01, 0.01])
    measured[500:600, 0] *= 20.0
    measured[200:300, 3] *= 40.0
    some = dict(red=np.ones(6), unit={}, force_from="", window=0.15, reasons={}, left_out={})
    floor = np.array([1.0, 1.0, 1.0, 0.01, 0.01, 0.01])
    found = worst_windows([EquationError(t, measured, np.zeros((1000, 6)), floor, **some)])
    assert [(w.axis, round(w.over_floor)) for w in found] == [("tx", 40), ("fx", 20)]
