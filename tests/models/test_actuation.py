"""Actuators between two commands: a servo that turns at its greatest rate first, then with its lag."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from infotraj.models.actuation import tilts_at
from infotraj.models.recorded import Samples


def test_a_servo_at_its_greatest_rate_has_that_time_less_for_its_lag():
    """A step of 1 rad, 4 rad/s at most, 50 ms: it is 0.2 rad short after 0.2 s, and that gap decays from there on."""
    step = Samples(np.array([0.0, 0.1]), np.array([[0.0], [1.0]]))
    law = SimpleNamespace(
        delay=0.0, tilt_time_constant=np.array([0.05]), tilt_max_rate=np.array([4.0]), tilt_play=np.zeros(1)
    )
    tilt, rate = tilts_at(SimpleNamespace(tilt_commanded=True, tilt=step), law, np.array([0.0, 0.2, 0.3, 0.4]))
    left = 0.2 * np.exp(-0.1 / 0.05)
    assert tilt[:, 0] == pytest.approx([0.0, 0.4, 0.8, 1.0 - left])
    assert rate[1:, 0] == pytest.approx([4.0, 4.0, left / 0.05])
