"""Named quantities along an exact flight, what the vehicle did before, and features for a Gaussian process."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from exact_simulation import fly
from scipy.spatial.transform import Rotation

from infotraj.diagnosis.judge.features import BIN, LAGS, bins, memory, named, pasts, random_features, speeding, turning
from infotraj.diagnosis.measure.residual import flight_samples
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.models.recorded import Samples
from infotraj.vehicle import load_vehicle

FILE = Path(__file__).parents[2] / "config/vehicles/omav.yaml"
ROWS = np.arange(260, 500, 7)  # more than the longest lag after the start


@pytest.fixture(scope="module")
def flown():
    """An exact flight that begins at 50 s, its samples, what the model predicts, and attitudes in its rows."""
    model = Model(load_vehicle(FILE))
    table = fly(yaml.safe_load(FILE.read_text()), {}, seconds=2.6, seed=2, start=50.0)
    samples = flight_samples(model, Flight(table))
    turned = Rotation.from_quat(table[["qx", "qy", "qz", "qw"]].to_numpy())
    return table, samples, model.predict(samples.prepared), turned


def test_quantities_are_those_of_the_motion_in_body_axes(flown):
    table, samples, prediction, turned = flown
    found = named(samples, prediction, table["t"].to_numpy()[ROWS])
    body = turned[ROWS].inv().apply(table[["vx", "vy", "vz"]].to_numpy()[ROWS])
    matrix, rate = turned[ROWS].as_matrix(), table[["wx", "wy", "wz"]].to_numpy()[ROWS]
    expected = {
        "t": table["t"].to_numpy()[ROWS] - 50.0,
        "px": table["px"].to_numpy()[ROWS],
        "vy body": body[:, 1],
        "|vx|vx body": np.abs(body[:, 0]) * body[:, 0],
        "|v|": np.linalg.norm(body, axis=1),
        "R13": matrix[:, 0, 2],
        "R21": matrix[:, 1, 0],
        "wz": rate[:, 2],
        "wxwz": rate[:, 0] * rate[:, 2],
        "predicted fz": table["az"].to_numpy()[ROWS],
    }
    for name, values in expected.items():
        np.testing.assert_allclose(found[name], values, atol=0.05 if name == "predicted fz" else 1e-6, err_msg=name)
    commands = table[[f"cmd_rotor_{i}" for i in range(12)]].to_numpy()[ROWS]
    np.testing.assert_allclose(found["mean rotor command"], commands.mean(axis=1), rtol=0.02)
    np.testing.assert_allclose(found["sin tilt 2"] ** 2 + found["cos tilt 2"] ** 2, 1.0, atol=1e-9)
    np.testing.assert_allclose(found["sin tilt 2"], np.sin(table["cmd_tilt_2"].to_numpy()[ROWS]), atol=0.05)


def test_what_the_vehicle_pushed_before_is_seen_from_where_it_is_now(flown):
    table, samples, prediction, turned = flown
    found = memory(samples, prediction, table["t"].to_numpy()[ROWS]).reshape(len(ROWS), len(LAGS), 3)
    for k, lag in enumerate(LAGS):
        before = ROWS - round(lag / 0.005)
        world = turned[before].apply(table[["ax", "ay", "az"]].to_numpy()[before])
        np.testing.assert_allclose(found[:, k], turned[ROWS].inv().apply(world), atol=0.05)


def test_how_the_vehicle_was_to_turn_before_is_seen_in_its_own_axes(flown):
    table, _, prediction, _ = flown
    found = turning(prediction, table["t"].to_numpy()[ROWS]).reshape(len(ROWS), len(LAGS), 3)
    for k, lag in enumerate(LAGS):
        np.testing.assert_allclose(found[:, k], prediction.angular_acceleration[ROWS - round(lag / 0.005)], atol=1e-6)


def rotors(speed, t, count=1):
    recorded, vehicle = SimpleNamespace(t=t, rotor=Samples(t, speed)), SimpleNamespace(rotors=(None,) * count)
    return SimpleNamespace(prepared=SimpleNamespace(recorded=recorded, vehicle=vehicle))


def test_a_rotor_that_slows_down_and_one_that_speeds_up_are_told_apart_and_a_steady_one_says_nothing():
    t = np.arange(0.0, 8.0, 0.005)
    swing = np.sin(np.pi * t)
    found = speeding(rotors(np.stack([500.0 + 50.0 * swing, 500.0 - 50.0 * swing, 0 * t + 300.0], axis=1), t), t[400:])
    found = found.reshape(-1, 2, 3)
    grows = np.cos(np.pi * t[400:])
    plain = np.abs(grows) > 0.7
    for of_lag in found.swapaxes(0, 1):
        assert np.all((np.sign(of_lag[:, 0]) == np.sign(grows))[plain])
        assert np.all((np.sign(of_lag[:, 1]) == -np.sign(grows))[plain])
        assert np.abs(of_lag[:, 0]).max() < 1.3  # 1 times the square of the speed, which is 1.2 at its largest
        assert np.abs(of_lag[:, 2]).max() < 1e-3


def test_which_way_a_rotor_goes_is_held_against_lags_of_a_tenth_and_three_tenths_of_a_second():
    """A speed that grows evenly is ahead of a lag by its slope times the time constant."""
    t = np.arange(0.0, 4.0, 0.002)
    speed = np.where(t < 2.0, 100.0, 100.0 + 10.0 * (t - 2.0))
    found = speeding(rotors(speed[:, None], t), np.array([1.0, 3.5]))
    late = [np.where(t < 2.0, 0.0, 10.0 * lag * (1.0 - np.exp(-(t - 2.0) / lag))) for lag in (0.1, 0.3)]
    expected = [np.interp(3.5, t, speed**2 / np.mean(speed**2) * np.tanh(2.0 * x / x.std())) for x in late]
    np.testing.assert_allclose(found, [[0.0, 0.0], expected], atol=2e-3)


def test_a_commanded_wrench_has_no_rotors_that_could_speed_up():
    t = np.arange(0.0, 2.0, 0.01)
    assert speeding(rotors(np.ones((len(t), 6)), t, 0), t[::5]).shape == (40, 0)


def test_what_was_before_comes_in_three_groups(flown):
    table, samples, prediction, _ = flown
    time = table["t"].to_numpy()[ROWS] + BIN / 4
    force, turn, speed = pasts(samples, prediction, time)
    np.testing.assert_array_equal(force, memory(samples, prediction, time))
    np.testing.assert_array_equal(turn, turning(prediction, time))
    np.testing.assert_array_equal(speed, speeding(samples, time))
    assert speed.shape == (len(ROWS), 2 * 12)


def test_samples_are_gathered_over_50_ms_and_not_across_a_gap():
    t = 10.005 + 0.01 * np.arange(20)
    run = (np.arange(20) >= 12).astype(int)
    samples = SimpleNamespace(times=lambda channel: t, flight=SimpleNamespace(t=np.array([10.0])))
    found = bins(samples, SimpleNamespace(run=run))
    assert found.size.tolist() == [5, 5, 2, 3, 5]
    assert found.of_sample.tolist() == np.repeat(np.arange(5), [5, 5, 2, 3, 5]).tolist()
    assert found.time == pytest.approx([10.025, 10.075, 10.11, 10.135, 10.175])


def test_random_features_have_the_covariance_of_a_squared_exponential():
    """Over many draws the mean product of two points' features is half of exp(-|x - y|^2 / 2 l^2 d)."""
    x = np.random.default_rng(0).standard_normal((6, 3))
    made = np.concatenate([random_features(x, np.random.default_rng(k), 0.7) for k in range(60)], axis=1)
    distance = np.sum((x[:, None] - x[None]) ** 2, axis=2)
    expected = np.exp(-distance / (2.0 * 0.7**2 * 3))
    np.testing.assert_allclose(2.0 * made @ made.T / made.shape[1], expected, atol=0.06)
