"""The slope that undoes an IMU's filter: what lies behind a gap does not count."""

from __future__ import annotations

import numpy as np
import pytest

from infotraj.models.recorded import Samples
from infotraj.models.sensor_lag import slope
from infotraj.models.timeline import timeline


def test_samples_behind_a_gap_of_four_steps_do_not_bend_the_slope_before_it():
    t = 0.01 * np.arange(60)
    t[30:] += 0.03
    values = t - 2.0 * t**2  # three samples at an edge are enough for it
    values[30:] += 7.0
    found = slope(Samples(t, values[:, None]))[:, 0]
    np.testing.assert_allclose(found, 1.0 - 4.0 * t, atol=1e-9)


@pytest.mark.parametrize("jumps", [[], [0.013, 0.031]])
@pytest.mark.parametrize("coarse", [False, True])
def test_a_filter_that_is_hardly_one_shows_what_is_there_and_comes_late_by_no_more_than_it_is(coarse, jumps):
    """How a prediction changes with a filter is asked from none on: half a step of delay would pass for it."""
    rows, lag = 0.005 * np.arange(20), 1e-5
    line = timeline(rows, np.array(jumps), lag, coarse)
    held = line.forcing(np.sin(60.0 * line.time)[:, None])[:-1, 0]
    late = np.sin(60.0 * (rows[1:] - lag))
    np.testing.assert_allclose(held, late, atol=3e-4)
