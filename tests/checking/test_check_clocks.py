"""Lags are found to their stated uncertainty; drifts and impossible orders of cause and effect are named."""

from dataclasses import replace

import numpy as np
import pytest
from check_flights import A, W, _shift, named, simulated
from scipy.stats import norm

from infotraj.checking import check, examine
from infotraj.checking.across import lags_across
from infotraj.checking.clocks import Offset, offset, offset_findings
from infotraj.checking.kinematics import acceleration_width
from infotraj.checking.response import response_findings, response_lag
from infotraj.checking.streams import Stream


def made(rng, lag, noise=0.2, duration=30.0, rate=100.0, drift=0.0):
    """A prediction y at the centres and a stream that is stamped `lag` (+ drift t) late, with coloured noise."""
    f, phase = rng.uniform(0.2, 1.5, (3, 6)), rng.uniform(0, 6.28, (3, 6))

    def signal(t):
        return np.sin(2 * np.pi * f[..., None] * t + phase[..., None]).sum(axis=1).T

    t = np.arange(0, duration, 1 / rate)
    coloured = np.stack([np.convolve(rng.standard_normal(len(t)), np.ones(5) / 5, "same") for _ in range(3)], axis=1)
    stream = Stream(t, signal(t - lag - drift * t) + noise * np.sqrt(5) * coloured, gap=0.05)
    centres = np.arange(1, duration - 1, 0.03)
    inside = np.arange(-0.04, 0.0401, 0.002)
    y = np.mean([signal(centres + s) for s in inside], axis=0)
    return stream, y, centres, np.floor(centres).astype(int)


@pytest.mark.long
def test_offset_is_unbiased_and_its_standard_error_is_right():
    z = []
    for seed in range(60):
        rng = np.random.default_rng([9, seed])
        lag = rng.uniform(-0.08, 0.08)
        found = offset(*made(rng, lag), width=0.08)
        z.append((found.lag - lag) / found.error)
    assert abs(np.mean(z)) < 0.45  # 3.5 standard errors of the mean of 60
    assert 0.75 < np.std(z) < 1.35


def test_drift_is_found_with_its_size():
    found = offset(*made(np.random.default_rng(1), 0.0, drift=1e-3, duration=60.0), width=0.08)
    assert found.drift == pytest.approx(1e-3, abs=4 * found.drift_error)
    assert found.drift_error < 2.5e-4
    assert found.varies < 1e-3


def test_segments_in_which_as_much_moves_are_as_sure_of_their_lag():
    """The errors of a segment's own eight blocks would scatter by a quarter and more, and the smallest would decide."""
    rng = np.random.default_rng(7)
    t = np.arange(0.0, 66.0, 0.01)

    def signal(time):
        return np.stack([np.sin(2 * np.pi * time), np.cos(2 * np.pi * time), np.sin(4 * np.pi * time)], axis=1)

    stream = Stream(t, signal(t - 0.004) + 0.5 * rng.standard_normal((len(t), 3)), gap=0.05)
    centres = np.arange(1.0, 65.0, 0.03)
    y = np.mean([signal(centres + s) for s in np.arange(-0.04, 0.0401, 0.002)], axis=0)
    found = offset(stream, y, centres, np.floor(centres).astype(int), 0.08)
    lags, errors = np.array(found.segments).T[1:]
    assert len(errors) == 8
    assert errors.max() < 1.35 * errors.min()
    assert 0.4 < np.std(lags - 0.004) / errors.mean() < 1.8
    assert found.varies > 0.01


def lagging(lag, error, segments=(), drift=0.0, drift_error=1.0):
    return Offset(lag, error, 0.1, segments, drift, drift_error)


def test_two_segments_differ_as_two_numbers_with_their_errors_do():
    found = lagging(0.0, 1e-3, ((0.0, 0.0, 1e-3), (8.0, 0.03, 1e-2)))
    assert found.varies == pytest.approx(2 * norm.sf(0.03 / np.hypot(1e-3, 1e-2)))
    assert lagging(0.0, 1e-3, ((0.0, 0.0, 1e-3),)).varies == 1.0


@pytest.mark.parametrize(("error", "codes"), [(2.4e-3, ["x_offset"]), (2.6e-3, [])])
def test_a_lag_is_said_beyond_four_of_its_errors(error, codes):
    said = offset_findings(lagging(0.01, error), "a", "b", "x", ("wx", "wy", "wz"), 0.005, 0.02)
    assert [f.code for f in said] == codes


@pytest.mark.parametrize(("error", "codes"), [(2.4e-4, ["x_drift"]), (2.6e-4, [])])
def test_a_drift_is_said_beyond_four_of_its_errors(error, codes):
    segments = ((0.0, 0.0, 1.0), (40.0, 0.0, 1.0))
    said = offset_findings(lagging(0.0, 1e-3, segments, 1e-3, error), "a", "b", "x", ("wx", "wy", "wz"), 0.005, 0.02)
    assert [f.code for f in said] == codes


def test_no_lag_from_streams_that_do_not_belong_together():
    rng = np.random.default_rng(2)
    stream, *_ = made(rng, 0.0)
    _, y, centres, block = made(rng, 0.0)
    assert offset(stream, y, centres, block, width=0.08) is None


@pytest.mark.parametrize("late", [0.02, -0.03])
def test_a_late_imu_is_found_to_a_few_milliseconds(late):
    (finding,) = [f for f in check(_shift(simulated(5, duration=15.0), W + A, late)) if f.code == "imu_clock_offset"]
    assert finding.severity == "warning"
    assert finding.values["lag"] == pytest.approx(late, abs=4 * finding.values["standard_error"] + 1e-3)
    assert finding.values["standard_error"] < 0.003


def test_a_response_before_its_command_is_impossible():
    flight = simulated(6, duration=15.0)
    late = _shift(flight, [f"cmd_rotor_{k}" for k in range(4)], 0.12)
    assert "response_before_command" not in named(examine(flight))
    assert "response_before_command" in named(examine(late))


def test_a_mean_over_a_window_is_exact_for_straight_lines_and_never_crosses_a_gap():
    t = np.concatenate([np.arange(0, 1, 0.013), np.arange(2, 3, 0.013)])
    line = Stream(t, np.stack([3 * t + 1, -t], axis=1), gap=0.1)
    centre = np.array([0.5, 0.51, 1.02, 2.5])
    mean = line.mean(centre, 0.1)
    np.testing.assert_allclose(mean[[0, 1, 3]], np.stack([3 * centre + 1, -centre], axis=1)[[0, 1, 3]], atol=1e-12)
    assert np.isnan(mean[2]).all()
    assert np.isnan(line.at(np.array([1.5, 5.0]))).all()


def test_lags_that_differ_between_logs_are_one_finding():
    one = examine(simulated(5, duration=12.0))
    logs = [replace(one, lags={"onboard.rate": (lag, 0.003), "rate": (0.0, 0.001)}) for lag in (-0.02, 0.01, 0.04, 0.0)]
    (finding,) = lags_across(logs)
    assert finding.severity == "note"
    assert "-20 to 40 ms over 4 logs" in finding.what
    assert lags_across([replace(one, lags={"rate": (0.01, 0.003)})] * 4) == []


@pytest.mark.parametrize("late", [0.0, 0.1])
def test_thrust_that_falls_with_the_speed_is_no_late_command(late):
    """Inflow: dv/dt = c - k v. The force then turns before its command does, by a quarter of a second if slow."""
    t = np.arange(0.0, 40.0, 0.005)
    c = sum(np.sin(2 * np.pi * f * t + p) for f, p in ((0.35, 0.0), (0.6, 1.0), (0.85, 2.5), (1.3, 4.0)))
    v = np.zeros_like(t)
    for k in range(len(t) - 1):
        v[k + 1] = v[k] + 0.005 * (c[k] - 2.5 * v[k])
    force = c - 2.5 * v + 0.02 * np.random.default_rng(1).standard_normal(len(t))
    command, felt = (Stream(when, x[:, None], gap=0.05) for when, x in ((t + late, c), (t, force)))
    centres = np.arange(1.0, 39.0, 0.08)
    block, air = np.floor(centres).astype(int), np.interp(centres, t, v)[:, None]
    assert response_lag(command, felt, centres, block, 0.08).lag < -late - 0.05
    assert response_lag(command, felt, centres, block, 0.08, air).lag == pytest.approx(-late, abs=0.01)


def test_a_response_that_is_too_late_leaves_the_rotors_their_usual_time():
    (found,) = response_findings(Offset(0.4, 0.01, 0.1, (), 0.0, 0.0), 0.01, "rotor_command")
    assert (found.code, found.settings) == ("response_too_late", ("rotor_command.shift=0.350",))


@pytest.mark.parametrize(("noise", "wanted"), [(1e-4, 0.08), (2e-3, None), (0.1, 0.32)])
def test_the_second_difference_of_the_position_is_as_wide_as_its_noise_asks(noise, wanted):
    """Of white noise its deviation over h is sqrt(1 + 4 + 1) / h^2 times that of a sample: 0.15 m/s^2 are let in."""
    t = np.arange(0.0, 60.0, 0.01)
    rng = np.random.default_rng(3)
    position = Stream(t, np.sin(t)[:, None] + noise * rng.standard_normal((len(t), 3)), gap=0.05)
    width = acceleration_width(position, 0.08)
    assert width == pytest.approx(wanted or np.sqrt(np.sqrt(6.0) * noise / 0.15), rel=0.02)


@pytest.mark.parametrize(
    ("lags", "code"),
    [((-0.09, -0.07, -0.08), "response_before_command"), ((-0.2, 0.01, -0.05), "response_lag")],
)
def test_a_response_is_before_its_command_only_where_it_is_so_in_every_part_of_the_flight(lags, code):
    segments = tuple((8.0 * k, lag, 0.005) for k, lag in enumerate(lags))
    (found,) = response_findings(Offset(-0.08, 0.005, 0.1, segments, 0.0, 0.0), 0.01, "rotor_command")
    assert found.code == code
