"""Actuators between two commands: a servo that turns at its greatest rate first, then with its lag."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from infotraj.models.actuation import actuation, tilts_at
from infotraj.models.recorded import Samples


def test_a_servo_at_its_greatest_rate_has_that_time_less_for_its_lag():
    """A step of 1 rad, 4 rad/s at most, 50 ms: it is 0.2 rad short after 0.2 s, and that gap decays from there on."""
    step = Samples(np.array([0.0, 0.1]), np.array([[0.0], [1.0]]))
    law = SimpleNamespace(
        delay=0.0, late=0.0, tilt_time_constant=np.array([0.05]), tilt_max_rate=np.array([4.0]), tilt_play=np.zeros(1)
    )
    tilt, rate = tilts_at(SimpleNamespace(tilt_commanded=True, tilt=step), law, np.array([0.0, 0.2, 0.3, 0.4]))
    left = 0.2 * np.exp(-0.1 / 0.05)
    assert tilt[:, 0] == pytest.approx([0.0, 0.4, 0.8, 1.0 - left])
    assert rate[1:, 0] == pytest.approx([4.0, 4.0, left / 0.05])


def step_of(value, tau, play=0.0, max_rate=np.inf, delay=0.0):
    """A servo at rest, whose command jumps to `value` after 0.1 s: its angle and slope from then on, every 10 ms."""
    command = Samples(np.array([0.0, 0.1]), np.array([[0.0], [value]]))
    law = SimpleNamespace(
        delay=delay,
        late=0.0,
        tilt_time_constant=np.array([tau]),
        tilt_max_rate=np.array([max_rate]),
        tilt_play=np.array([play]),
    )
    t = np.linspace(0.0, 1.0, 101)
    out, slope = tilts_at(SimpleNamespace(tilt_commanded=True, tilt=command), law, t)
    return t - 0.1, out[:, 0], slope[:, 0]


@pytest.mark.parametrize("value", [1.0, -2.0])
def test_a_lag_approaches_its_command_and_its_slope_is_that_of_the_approach(value):
    since, out, slope = step_of(value, 0.08)
    after = since > 1e-6
    np.testing.assert_allclose(out[after], value * (1.0 - np.exp(-since[after] / 0.08)), atol=1e-9)
    np.testing.assert_allclose(slope[after], value / 0.08 * np.exp(-since[after] / 0.08), atol=1e-9)
    assert not out[~after].any()
    # Later by a delay, and by nothing else.
    np.testing.assert_allclose(step_of(value, 0.08, delay=0.05)[1][5:], out[:-5], atol=1e-9)


@pytest.mark.parametrize("value", [1.0, -1.0])
def test_a_limited_servo_turns_either_way_at_its_rate(value):
    since, out, slope = step_of(value, 0.05, max_rate=4.0)
    turning = (since > 1e-6) & (since < 0.19)
    np.testing.assert_allclose(out[turning], 4.0 * value * since[turning], atol=1e-9)
    np.testing.assert_allclose(slope[turning], 4.0 * value, atol=1e-9)


def test_an_arm_stays_where_it_is_until_its_servo_has_crossed_the_play():
    since, out, slope = step_of(1.0, 0.08, play=0.2)
    servo = np.where(since > 1e-6, 1.0 - np.exp(-np.maximum(since, 0.0) / 0.08), 0.0)
    np.testing.assert_allclose(out, np.maximum(servo - 0.2, 0.0), atol=1e-9)
    assert not slope[servo < 0.199].any()
    moving = servo > 0.201
    np.testing.assert_allclose(slope[moving], (1.0 - servo[moving]) / 0.08, atol=1e-9)


def test_without_a_lag_a_servo_is_at_its_command_at_once():
    since, out, slope = step_of(1.0, 0.0)
    np.testing.assert_allclose(out, since > 1e-6, atol=1e-9)
    assert not slope.any()


def test_a_tilt_is_that_of_its_servo_and_its_bias():
    commands = Samples(np.array([0.0, 0.1]), np.zeros((2, 1)))
    none = np.zeros(1)
    law = SimpleNamespace(
        delay=0.0, late=0.0, telemetry=0.0, rotor_time_constant=none, tilt_time_constant=none,
        tilt_max_rate=none + np.inf, tilt_play=none, tilt_bias=np.array([0.3]),
    )  # fmt: skip
    recorded = SimpleNamespace(rotor_commanded=True, rotor=commands, tilt_commanded=True, tilt=commands)
    assert actuation(recorded, law, np.linspace(0.0, 1.0, 5)).tilt[:, 0] == pytest.approx(np.full(5, 0.3))
