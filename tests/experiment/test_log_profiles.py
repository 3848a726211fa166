import numpy as np
import pytest

from infotraj import rotations
from infotraj.experiment.corpus.flights import exact_flight
from infotraj.experiment.rough import PROFILES
from infotraj.experiment.rough.actuators import dead_rotor_sensor
from infotraj.experiment.rough.filters import lagged
from infotraj.experiment.rough.gauss_markov import gauss_markov, smooth_gauss_markov
from infotraj.experiment.rough.vibration import shaken
from infotraj.flight import Flight

FLOWN = exact_flight(2, 2, (200.0,), seconds=14.0)
FLIGHT, VEHICLE = FLOWN.flight, FLOWN.vehicle
FAST = exact_flight(2, 2, (500.0,), seconds=14.0).flight


def logged(profile, seed=0, flight=FLIGHT):
    return PROFILES[profile].log(flight, VEHICLE, np.random.default_rng(seed))


@pytest.mark.parametrize("process", [gauss_markov, smooth_gauss_markov])
def test_a_slow_error_has_its_size(process):
    x = process(400_000, 0.01, 0.5, np.random.default_rng(1))
    assert x.std(axis=0) == pytest.approx(1.0, rel=0.05)


def test_slow_errors_forget_in_their_time_and_smooth_ones_have_a_slope():
    rng = np.random.default_rng(2)
    rough, smooth = gauss_markov(400_000, 0.01, 0.5, rng), smooth_gauss_markov(400_000, 0.01, 0.5, rng)
    assert np.mean(rough[50:] * rough[:-50]) == pytest.approx(np.exp(-1), abs=0.05)
    # second order with both poles at 1 / time: the slope's standard deviation is 1 / time
    assert (np.diff(smooth, axis=0) / 0.01).std() == pytest.approx(1 / 0.5, rel=0.05)


def test_a_lag_delays_a_slow_wave_by_its_time_constant():
    t = FLIGHT.t
    wave = Flight(FLIGHT.table.assign(ax=np.sin(2 * t), ay=0.0, az=9.81), {})
    seen = lagged(wave, ("ax", "ay", "az"), 0.008)
    late = np.sin(2 * t - np.arctan(2 * 0.008)) / np.hypot(1.0, 2 * 0.008)
    assert np.abs(seen.get("ax")[:, 0] - late)[400:].max() < 1e-4
    assert seen.get("az") == pytest.approx(9.81)


@pytest.mark.parametrize(("lag", "share"), [(0.0, 1.0), (0.008, 0.25)])
def test_vibration_lies_at_the_rotors_aliased_frequency_and_shrinks_behind_a_filter(lag, share):
    t = np.arange(0, 20, 0.005)
    steady = FLIGHT.table.iloc[: len(t)].assign(t=t[: len(FLIGHT.table)])
    speed = 2 * np.pi * 130.0  # 130 Hz in rows at 200 Hz comes out at 70 Hz
    for k in range(4):
        steady[f"rotor_{k}"] = speed
    steady[["ax", "ay", "az"]] = 0.0
    made = shaken(Flight(steady), np.random.default_rng(3), lag).get("ax", "ay", "az")
    power = (np.abs(np.fft.rfft(made, axis=0)) ** 2).sum(axis=1)
    frequency = np.fft.rfftfreq(len(made), 0.005)
    assert frequency[np.argmax(power)] == pytest.approx(70.0, abs=0.2)
    size = np.sqrt(np.mean(made**2))
    assert 0.95 * share / np.hypot(1.0, lag * speed) < size < 5.0 / np.hypot(1.0, lag * speed)


def test_an_autopilots_state_is_off_slowly_and_its_commands_are_held():
    seen = logged("autopilot")
    off = seen.get("px", "py", "pz") - FLIGHT.get("px", "py", "pz")
    assert 0.008 < off.std() < 0.06
    assert np.abs(np.diff(off, axis=0)).max() < 0.002
    angle = rotations.angle_between(seen.get("qw", "qx", "qy", "qz"), FLIGHT.get("qw", "qx", "qy", "qz"))
    assert 0.1 < np.degrees(np.sqrt(np.mean(angle**2) / 3)) < 0.8
    changed = np.mean(np.diff(seen.get("cmd_rotor_0")[400:, 0]) != 0)
    assert changed == pytest.approx(0.5, abs=0.02) or changed == pytest.approx(0.25, abs=0.02)


def test_motion_capture_holds_poses_alone_with_spikes_gaps_and_jitter():
    seen = logged("motion_capture")
    assert not any(seen.has(name) for name in ("ax", "vx", "wx"))
    lost = np.isnan(seen.get("px")[:, 0])
    assert 0.1 <= lost.sum() * 0.005 < 3.2
    steps = np.diff(seen.t)
    assert steps.min() > 0.0
    assert 0.05 * 0.005 < steps.std() < 0.2 * 0.005
    rpm = seen.get("rotor_1")[:, 0] * 60 / (2 * np.pi)
    assert np.abs(rpm / 10 - np.round(rpm / 10)).max() < 1e-6
    # 8 ms late: it fits the pose before better than the pose at its stamp
    good = ~lost & (FLIGHT.t > 5)
    x, true = seen.get("px")[good, 0], FLIGHT.get("px")[:, 0]
    off = [np.median(np.abs(x - np.interp(FLIGHT.t[good] - late, FLIGHT.t, true))) for late in (0.0, 0.008)]
    assert off[1] < 0.3 * off[0]


def test_held_poses_repeat_five_rows_of_500_hz():
    seen = PROFILES["held"].log(FAST, VEHICLE, np.random.default_rng(0))
    changes = np.flatnonzero(np.any(np.diff(seen.get("px", "py", "pz"), axis=0) != 0, axis=1))
    assert set(np.diff(changes)) == {5}
    assert np.mean(np.diff(seen.get("wx")[:, 0]) == 0) < 0.01
    assert set(np.diff(np.flatnonzero(np.diff(seen.get("battery")[:, 0]) != 0)) % 50) == {0}


def test_a_nanodrones_accelerometer_is_poor_and_its_error_lasts():
    off = logged("nanodrone").get("ax") - FLIGHT.get("ax")
    off = off[:, 0] - off.mean()
    assert 0.2 < off.std() < 1.2


def test_signed_speeds_turn_with_the_spin_and_a_wrench_replaces_them():
    seen = logged("signed_speeds")
    spin = [r.spin for r in VEHICLE.rotors]
    assert (np.sign(seen.numbered("rotor_").mean(axis=0)) == spin).all()
    wrench = logged("wrench")
    assert not any(wrench.has(name) for name in ("cmd_rotor_0", "rotor_0"))
    thrust = sum(r.thrust_coefficient * FLIGHT.get(f"cmd_rotor_{k}")[:, 0] ** 2 for k, r in enumerate(VEHICLE.rotors))
    assert wrench.get("cmd_fz")[:, 0] == pytest.approx(thrust)


def test_a_dead_sensor_reads_zero_in_one_column():
    for seed in range(4):
        seen, name = dead_rotor_sensor(FLIGHT, np.random.default_rng(seed))
        assert 0.4 < np.mean(seen.get(name) == 0.0) < 1.0
        others = [c for c in FLIGHT.table if c != name]
        assert seen.table[others].equals(FLIGHT.table[others])


@pytest.mark.parametrize("profile", PROFILES)
def test_a_profile_leaves_its_flight_alone_and_is_the_same_for_a_seed(profile):
    flight = FAST if profile == "held" else FLIGHT
    before = flight.table.copy()
    once, again, other = (logged(profile, seed, flight) for seed in (5, 5, 6))
    assert flight.table.equals(before)
    assert once.table.equals(again.table)
    assert profile in ("signed_speeds", "wrench") or not once.table.equals(other.table)
