"""The slope that undoes an IMU's filter: what lies behind a gap does not count."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from infotraj.models.recorded import Samples
from infotraj.models.sensor_lag import as_sensed, slope
from infotraj.models.timeline import timeline


def test_samples_behind_a_gap_of_four_steps_do_not_bend_the_slope_before_it():
    t = 0.01 * np.arange(60)
    t[30:] += 0.03
    values = t - 2.0 * t**2  # three samples at an edge are enough for it
    values[30:] += 7.0
    found = slope(Samples(t, values[:, None]))[:, 0]
    np.testing.assert_allclose(found, 1.0 - 4.0 * t, atol=1e-9)


def test_a_filtered_ramp_is_late_by_the_time_constant_at_rows_and_in_the_mean_of_a_step():
    t, lag = 0.005 * np.arange(200), 0.02
    line = timeline(t, np.array([]), lag)
    ramp = np.repeat(line.time[:, None], 3, axis=1)
    rows = [line.at_rows(ramp), line.means(ramp)] * 2 + [line.forcing(ramp)] * 2
    measured = SimpleNamespace(derived=False)
    recorded: Any = SimpleNamespace(t=t, specific_force=measured, rate=measured)
    force, force_mean, _, turn_mean = as_sensed(recorded, rows, lag)
    settled = slice(100, 199)
    np.testing.assert_allclose(force[settled, 0], t[settled] - lag, atol=1e-9)
    np.testing.assert_allclose(force_mean[settled, 0], t[settled] + 0.0025 - lag, atol=1e-9)
    np.testing.assert_allclose(turn_mean, force_mean)
