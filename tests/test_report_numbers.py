"""Numbers of the page: reduced and packed series lose no peak, and text has the digits that mean something."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from infotraj.report.formats import change, interval, numbers, prefixed, significant
from infotraj.report.series import packed, reduced, unpacked
from infotraj.report.squeezing import squeezed, step, unsqueezed


@given(st.integers(2, 3000), st.integers(4, 400), st.integers(0, 2**31))
def test_reducing_keeps_the_lowest_and_the_highest_value_of_every_bucket(rows, most, seed):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.005, 0.02, rows))
    values = rng.standard_t(2, (rows, 2))
    values[rng.random(rows) < 0.1, 1] = np.nan
    at, shown = reduced(t, values, most)
    assert len(at) <= max(most, 2)
    assert np.all(np.diff(at) > 0)
    if rows <= most:
        assert shown is values
        return
    edges = np.linspace(t[0], t[-1], len(at) // 2 + 1)
    slot = np.minimum(((t - t[0]) / (edges[1] - edges[0])).astype(int), len(at) // 2 - 1)
    for c in range(2):
        for bucket in range(len(at) // 2):
            inside = values[slot == bucket, c]
            inside = inside[np.isfinite(inside)]
            pair = shown[2 * bucket : 2 * bucket + 2, c]
            if not len(inside):
                assert np.isnan(pair).all()
                continue
            assert (pair.min(), pair.max()) == (inside.min(), inside.max())
            assert (pair[0] <= pair[1]) == (np.argmin(inside) <= np.argmax(inside))


def test_packed_numbers_come_back_with_what_is_missing():
    values = np.array([1.5, np.nan, -3e-7, 1e6])
    np.testing.assert_allclose(unpacked(packed(values)), values, rtol=1e-7)


@given(st.integers(1, 400), st.integers(1, 5), st.integers(0, 2**31))
def test_squeezed_columns_come_back_to_half_a_step_with_what_is_missing(rows, columns, seed):
    rng = np.random.default_rng(seed)
    values = np.cumsum(rng.standard_t(2, (columns, rows)), axis=1) * 10.0 ** rng.integers(-6, 6, (columns, 1))
    values[rng.random((columns, rows)) < 0.1] = np.nan
    steps = np.array([step(v, 10.0 ** rng.integers(-30, 2)) for v in values])
    read = unsqueezed(squeezed(values, steps), steps)
    np.testing.assert_array_equal(np.isnan(read), np.isnan(values))
    assert np.nanmax(np.abs(read - values) / steps[:, None], initial=0.0) <= 0.5 + 1e-6


def test_a_step_is_never_finer_than_single_precision_of_the_largest_value():
    assert step(np.array([1.0, np.nan, -4.0]), 0.25) == 0.25
    assert step(np.array([1.0, np.nan, -4.0]), 0.0) == step(np.array([4.0]), np.nan) == 4.0 * 2.0**-20
    assert step(np.array([np.nan]), 0.0) > 0.0


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0123456, "0.0123"), (-2.5e-7, "−2.5 × 10⁻⁷"), (None, "–"), (1234.0, "1.23 × 10³"), (0.0, "0")],
)
def test_numbers_have_the_digits_that_mean_something(value, text):
    assert significant(value) == text


def test_a_change_to_nearly_nothing_keeps_what_is_left():
    assert change(-0.72) == "−72\u00a0%"
    assert change(-0.9997) == "−99.97\u00a0%"
    assert change(0.031) == "+3.1\u00a0%"


def test_a_number_of_an_effect_has_as_many_digits_as_its_error():
    row = {"parameters": {"rotor": 3, "r": [0.01234, -2.0]}, "standard_errors": {"r": [0.00012, 0.5]}}
    assert numbers(row, {"units": {"r": "m", "rotor": "-"}}) == ["rotor 3", "r (0.01234 ± 0.00012, -2.00 ± 0.50) m"]
    assert prefixed("N m", 0.04) == (1e3, "mN m")
    about = {"units": {"r": "m", "rotor": "-"}, "index": ["rotor"]}
    assert numbers(row, about)[0] == "rotor 3 (counted from 0)"


def test_an_interval_that_is_the_value_is_said_in_words():
    assert interval([-0.99998, -0.99998], -0.99998) == "the same over the 95 % interval"
    assert interval([-0.9998, -0.9996], -0.9997) == "95 % interval −99.98\u00a0% to −99.96\u00a0%"
