"""The slope that undoes an IMU's filter: what lies behind a gap does not count."""

from __future__ import annotations

import numpy as np

from infotraj.models.recorded import Samples
from infotraj.models.sensor_lag import slope


def test_samples_behind_a_gap_of_four_steps_do_not_bend_the_slope_before_it():
    t = 0.01 * np.arange(60)
    t[30:] += 0.03
    values = t - 2.0 * t**2  # three samples at an edge are enough for it
    values[30:] += 7.0
    found = slope(Samples(t, values[:, None]))[:, 0]
    np.testing.assert_allclose(found, 1.0 - 4.0 * t, atol=1e-9)
