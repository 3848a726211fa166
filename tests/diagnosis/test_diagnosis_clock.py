"""The clock of a noisy IMU: noise of its samples says nothing of when they were taken."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.measure.residual import flight_samples
from infotraj.diagnosis.select.around import linearised
from infotraj.diagnosis.select.prior import Scales
from infotraj.effects import catalogue, effect_class
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

FILE = Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml"
NOISE = {"gyro": 0.03, "accelerometer": 0.3}
MOTION = ["px", "py", "pz", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"]
ROTORS = [f"rotor_{i}" for i in range(4)]
POSES = ["px", "py", "pz", "qw", "qx", "qy", "qz", "vx", "vy", "vz"]


def clock(late):
    """How late (s) the IMU is said to be, and the standard error, by poses every 20 ms of three flights."""
    content = yaml.safe_load(FILE.read_text())
    flights = []
    for seed in (5, 6, 7):
        table = fly(content, {"time_offset": {"dt": late}} if late else {}, seconds=10.0, seed=seed, noise=NOISE)
        table.loc[table.index % 4 != 0, POSES] = np.nan
        flights.append(Flight(table, {}))
    names = ("time_offset", "gyro_bias", "imu_misalignment", "actuation_delay")
    found = [Candidate(c, tuple(p for p in c.parameters if not p.index), ()) for c in (catalogue()[n] for n in names)]
    now = linearised(observe(Model(load_vehicle(FILE)), flights), [], found)
    chosen = now.labelled(["time_offset", "actuation_delay"])
    column = now.choices[chosen[0]].columns[0]
    scorer = now.scorer(Scales(1.0))
    free, covariance = scorer.covariance(chosen)
    scale = now.columns[column].scale
    error = float(np.sqrt(covariance[list(free).index(column), list(free).index(column)]))
    return scorer.solution(chosen).theta[column] * scale, error * scale


@pytest.mark.parametrize("late", [0.0, 0.008])
def test_noise_does_not_shift_the_clock_nor_make_it_surer(late):
    # A secant of 10 ms over samples whose noise is left in has its least error half way, whatever the truth.
    found, error = clock(late)
    assert found == pytest.approx(late, abs=6e-4)
    assert abs(found - late) < 4.0 * error


NOISE_OF_ALL = {"gyro": 0.005, "accelerometer": 0.05, "velocity": 0.005, "attitude": 0.002, "position": 0.002}


def measured_rotors(seed, effects=None, motion=0, rotors=0, without=("cmd_",), noise=None):
    """A flight with measured rotors whose motion or rotors were written so many rows too late, without some columns."""
    table = fly(yaml.safe_load(FILE.read_text()), effects or {}, seconds=10.0, seed=seed, noise=noise)
    table[MOTION] = table[MOTION].shift(motion)
    table[ROTORS] = table[ROTORS].shift(rotors)
    table = table.drop(columns=[c for c in table if c.startswith(without)])
    return Flight(table.iloc[max(motion, rotors) :].reset_index(drop=True), {})


def test_without_an_accelerometer_all_of_the_motion_is_as_late_as_the_model_says():
    flight, error = measured_rotors(5, motion=2, without=("cmd_", "a")), {}
    for dt in (0.0, 0.005, 0.01):
        model = Model(load_vehicle(FILE), [effect_class("time_offset")(dt=dt)])
        error[dt] = left(model, flight)
    assert set(error[0.0]) >= {"velocity", "rate"}
    for channel in ("velocity", "rate"):
        assert error[0.01][channel] < 0.02 * error[0.0][channel]
        assert error[0.005][channel] == pytest.approx(0.5 * error[0.0][channel], rel=0.2)
    # The attitude and the rates were late alike.
    assert error[0.01]["turn"] == pytest.approx(error[0.0]["turn"])


def test_rotors_whose_telemetry_is_late_turn_as_much_earlier_as_the_model_says():
    flight = measured_rotors(5, rotors=2)
    late, right = (
        left(Model(load_vehicle(FILE), [effect_class("telemetry_offset")(dt=x)]), flight) for x in (0.0, 0.01)
    )
    for channel in ("force", "rate"):
        assert right[channel] < 0.02 * late[channel]
    assert right["push"] == pytest.approx(late["push"], rel=0.01)


def left(model, flight):
    """Root mean squares of what a model leaves of a flight, by channel."""
    samples = flight_samples(model, flight)
    names = [c.name for c in samples.channels]
    return {n: np.sqrt(np.mean(r**2)) for n, r in zip(names, samples.residual(model), strict=True)}


def test_motion_that_is_late_beside_measured_rotors_is_named():
    flights = [measured_rotors(s, motion=2, without=("cmd_", "a"), noise=NOISE_OF_ALL) for s in (5, 6, 7)]
    found = diagnose(Model(load_vehicle(FILE)), flights)
    assert found.supported == ("time_offset",)
    assert found.finding("time_offset").parameters["dt"] == pytest.approx(0.01, abs=5e-4)


def test_rotors_whose_telemetry_is_late_are_named_beside_drag():
    # Without a name for it a flight of 10 ms late rotors had gyroscopic and axial_inflow Supported.
    drag = {"rotor_drag": {"k": 5e-5}}
    flights = [measured_rotors(s, drag, rotors=2, noise=NOISE_OF_ALL) for s in (5, 6, 7)]
    found = diagnose(Model(load_vehicle(FILE)), flights)
    assert set(found.supported) == {"rotor_drag", "telemetry_offset"}
    assert found.finding("telemetry_offset").parameters["dt"] == pytest.approx(0.01, abs=5e-4)
    assert found.finding("rotor_drag").parameters["k"] == pytest.approx(5e-5, rel=0.02)


def test_motion_that_is_late_beside_commands_is_not_told_from_commands_that_act_late():
    flight = measured_rotors(5, without=("rotor_", "a"))
    reason = effect_class("time_offset").cannot_show(load_vehicle(FILE), flight)
    assert reason == "the flight has no measured specific force (ax, ay, az)"
