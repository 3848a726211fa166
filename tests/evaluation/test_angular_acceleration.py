"""Errors of the angular acceleration are summed up as Fig. 4 does: over time and over the axes."""

import numpy as np
import pytest

from infotraj.evaluation.angular_acceleration import AxisErrors


def test_the_spread_is_over_time_of_the_mean_over_the_axes():
    errors = AxisErrors(np.array([0.0, 1.0]), np.array([[1.0, 2.0, 3.0], [3.0, 4.0, 5.0]]))
    assert errors.by_axis == pytest.approx([2.0, 3.0, 4.0])
    assert errors.mean == 3.0
    assert errors.spread == 1.0
