"""Columns that wrap round or change their sign: when, by how much, and which rows are wrong; as they were made."""

import numpy as np
import pytest
from check_flights import simulated

from infotraj.checking.jumps import jumped_columns
from infotraj.flight import Flight

T = np.arange(0.0, 20.0, 0.01)
RISE = 30.0 * np.sin(2 * np.pi * T / 20.0) + 100.0  # passes each level between 70 and 130 slowly, twice
AIR = np.ones(len(T), dtype=bool)


def jumped(column, values, airborne=AIR):
    table = simulated(7, duration=20.0).table.iloc[: len(T)].copy()
    table["t"] = T
    table[[c for c in table if c != "t"]] = 0.0
    table["qw"] = 1.0
    table[column] = values
    return jumped_columns(Flight(table), airborne)


@pytest.mark.parametrize("modulus", [2 * np.pi, 256.0])
def test_a_wrap_is_dated_at_the_first_sample_on_the_other_side(modulus):
    x = RISE * modulus / 100.0 - 0.2 * modulus  # within 0.5 and 1.1 of the modulus: it wraps for a while at the top
    wrapped = x % modulus
    (found,) = jumped("wx", wrapped)
    over = x >= modulus
    edges = np.flatnonzero(np.diff(over.astype(int))) + 1
    assert found.code == "wrapped"
    assert found.column == "wx"
    assert np.array_equal(found.times, T[edges])
    assert abs(found.size / modulus - 1) < 0.01
    assert np.array_equal(found.rows, over)


def test_a_column_that_dwells_near_both_ends_wraps_while_it_passes_the_middle_slowly():
    slow = 0.5 - 0.5 * np.cos(np.pi * (T / 4.0 % 1.0))
    turn = np.pi - np.pi * np.cos(np.pi * slow)  # two fifths of its time away from the ends
    assert 0.35 < ((turn > 0.2 * np.pi) & (turn < 1.8 * np.pi)).mean() < 0.45
    (found,) = jumped("wx", turn)
    assert found.code == "wrapped"
    assert np.allclose(found.times, [4.0, 8.0, 12.0, 16.0])


def test_a_sign_that_changes_is_dated_likewise_and_the_fewer_rows_are_wrong():
    x = RISE.copy()
    x[600:900] *= -1.0
    (found,) = jumped("ay", x)
    assert found.code == "sign_flips"
    assert np.array_equal(found.times, T[[600, 900]])
    assert abs(found.size - np.median(2 * RISE[[600, 900]])) < 1.0
    assert np.array_equal(np.flatnonzero(found.rows), np.arange(600, 900))


def test_among_many_far_jumps_the_few_to_minus_x_or_the_other_end_are_chance():
    """A wheel on grass: jumps of any size, some of them from x to nearly -x."""
    rng = np.random.default_rng(3)
    x = 0.05 * rng.standard_normal(len(T))
    rough = np.arange(1500, 1570)
    x[rough] = rng.uniform(-4.0, 4.0, len(rough))
    far = np.abs(np.diff(x)) > 5.0 * np.percentile(np.abs(np.diff(x)), 95)
    to_minus = np.abs(x[1:] + x[:-1]) < 0.1 * np.abs(np.diff(x))
    assert 2 <= (far & to_minus).sum() < 0.5 * far.sum()
    assert jumped("ay", x) == []


def test_what_comes_back_within_a_few_samples_is_a_spike_and_a_range_of_two_values_does_not_wrap():
    x = RISE.copy()
    x[600:604] *= -1.0
    assert jumped("ay", x) == []
    assert jumped("ay", RISE) == []
    switched = np.where(T % 4.0 < 2.0, 1.0, 0.0) + 1e-3 * np.sin(T)
    assert [f.code for f in jumped("wx", switched)] == []


def test_no_row_of_an_angle_is_wrong_where_it_wraps():
    turn = (0.8 * T) % (2 * np.pi)
    (found,) = jumped("tilt_0", turn)
    assert found.code == "wrapped"
    assert len(found.times) == 2
    assert not found.rows.any()


def test_on_the_ground_nothing_is_asked():
    x = RISE.copy()
    x[600:900] *= -1.0
    assert jumped("ay", x, airborne=(T < 3.0) | (T > 12.0)) == []
