"""Every effect that can show, alone and at usual size, in flights of the exact simulation: named, with its numbers.

The exact simulation (`exact_simulation`) shares no code with the library. What cannot show is listed with its reason in
docs/effects.md: on an omav whose pairs share one command, moment_scale and gyroscopic. Six that do not
ask what rotors do are tried on the quadrotor alone: quadratic_drag, angular_damping, steady_force, gyro_bias,
imu_misalignment, time_offset.
"""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.diagnosis import diagnose
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

VEHICLES = Path(__file__).parents[2] / "config/vehicles"
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.001, "velocity": 0.005}
CASES: dict[str, Any] = {
    "quadrotor": {
        "mass_offset": {"dm": 0.04},
        "inertia_error": {"dxx": 0.0008, "dyy": -0.0006, "dzz": 0.0015},
        "com_offset": {"r": [0.003, -0.002, 0.004]},
        "thrust_scale": {"factor": 0.9},
        "rotor_effectiveness": {"rotor": 2, "factor": 0.85},
        "moment_scale": {"factor": 1.3},
        "axial_inflow": {"k": 7e-5},
        "ground_effect": {"k": 0.1},
        "battery_sag": {"rate": 0.003},
        "rotor_lag": {"extra_time_constant": 0.03},
        "actuation_delay": {"delay": 0.015},
        "rotor_drag": {"k": 3e-5},
        "linear_drag": {"d": [0.1, 0.1, 0.15]},
        "quadratic_drag": {"d": [0.03, 0.03, 0.05]},
        "angular_damping": {"d": [0.007, 0.007, 0.009]},
        "gyroscopic": {"rotor_inertia": 3e-5},
        "steady_force": {"f": [0.2, -0.1, 0.1]},
        "steady_torque": {"t": [0.01, -0.008, 0.005]},
        "gyro_bias": {"b": [0.03, -0.02, 0.02]},
        "accelerometer_bias": {"b": [0.2, -0.1, 0.1]},
        "imu_misalignment": {"rotvec": [0.02, -0.015, 0.02]},
        "time_offset": {"dt": 0.01},
        "translational_lift": {"k": 4e-3},
        "thrust_exponent": {"n": 1.8},
    },
    "omav": {
        "mass_offset": {"dm": 0.2},
        "inertia_error": {"dxx": 0.01, "dyy": -0.008, "dzz": 0.02},
        "com_offset": {"r": [0.008, -0.005, 0.01]},
        "thrust_scale": {"factor": 1.1},
        "rotor_effectiveness": {"rotor": 3, "factor": 0.8},
        "coaxial_loss": {"fraction": 0.15},
        "axial_inflow": {"k": 2e-4},
        "ground_effect": {"k": 0.2},
        "battery_sag": {"rate": 0.004},
        "rotor_interference": {"k": 0.06},
        "rotor_lag": {"extra_time_constant": 0.03},
        "servo_lag": {"extra_time_constant": 0.04},
        "servo_rate_limit": {"max_rate": 4.5},
        "servo_backlash": {"half_width": 0.015},
        "servo_bias": {"bias": [0.0175, -0.01, 0.015, 0.02, -0.0175, 0.009]},
        "actuation_delay": {"delay": 0.015},
        "rotor_drag": {"k": 7e-5},
        "linear_drag": {"d": [0.5, 0.5, 0.7]},
        "steady_torque": {"t": [0.15, -0.1, 0.1]},
        "suspended_load": {"mass": 0.4, "length": 0.6},
        "thrust_exponent": {"n": 2.2},
    },
}
# One of a thrust, of a clock and of the air: what the default run looks at.
SHORT = {("quadrotor", "rotor_effectiveness"), ("quadrotor", "linear_drag")}
# Lower rotors in equal pairs: the pair as a whole is weaker, as by a thrust scale; what the torque says is small.
ALIKE = {("omav", "coaxial_loss"): {"coaxial_loss", "thrust_scale"}}


def flights(name, effects, count=3, seconds=8.0):
    content = yaml.safe_load((VEHICLES / f"{name}.yaml").read_text())
    made = []
    for seed in range(count):
        table = fly(content, effects, seconds=seconds, seed=seed, noise=NOISE)
        table.loc[np.arange(len(table)) % 2 != 0, ["px", "py", "pz", "qw", "qx", "qy", "qz"]] = np.nan
        made.append(Flight(table))
    return made


@pytest.mark.parametrize(
    ("vehicle", "name"),
    [
        pytest.param(v, n, marks=() if (v, n) in SHORT else pytest.mark.long, id=f"{v}-{n}")
        for v, cases in CASES.items()
        for n in cases
    ],
)
def test_an_effect_alone_is_named_with_its_numbers(vehicle, name):
    true = CASES[vehicle][name]
    made = flights(vehicle, {name: true})
    found = diagnose(Model(load_vehicle(VEHICLES / f"{vehicle}.yaml")), made)
    named = {n for s in found.supported for n in found.finding(s).group}
    assert name in named
    assert named <= ALIKE.get((vehicle, name), {name})
    assert len(found.supported) == 1
    assert not found.unexplained.found
    finding = found.finding(name)
    for parameter, value in true.items():
        if parameter == "rotor":
            assert finding.parameters[parameter] == value
            continue
        error = np.abs(np.subtract(finding.parameters[parameter], value))
        departure = np.max(np.abs(np.subtract(value, {"factor": 1.0, "n": 2.0}.get(parameter, 0.0))))
        allowed = 4.0 * np.array(finding.standard_errors[parameter]) + 0.05 * departure
        assert np.all(error < allowed), (finding.parameters, true)


@cache
def of_nothing(vehicle):
    return diagnose(Model(load_vehicle(VEHICLES / f"{vehicle}.yaml")), flights(vehicle, {}))


@pytest.mark.parametrize("vehicle", ["quadrotor", pytest.param("omav", marks=pytest.mark.long)])
def test_nothing_is_named_where_nothing_is_missing(vehicle):
    found = of_nothing(vehicle)
    assert found.supported == ()
    assert not found.unexplained.found


@pytest.mark.long
def test_two_effects_that_shift_in_time_are_named_together():
    true = {"rotor_lag": CASES["quadrotor"]["rotor_lag"], "time_offset": CASES["quadrotor"]["time_offset"]}
    found = diagnose(Model(load_vehicle(VEHICLES / "quadrotor.yaml")), flights("quadrotor", true))
    assert sorted(found.supported) == ["rotor_lag", "time_offset"]
    for name in true:
        (value,) = true[name].values()
        (fitted,) = found.finding(name).parameters.values()
        assert fitted == pytest.approx(value, abs=0.002)


@pytest.mark.long
@pytest.mark.parametrize(
    "true",
    [
        {"linear_drag": {"d": [0.1, 0.12, 0.15]}, "pressure_centre": {"r": [0.02, -0.015, 0.03]}},
        {"quadratic_drag": {"d": [0.08, 0.1, 0.05]}, "wind": {"v": [3.0, -2.0, 0.5]}},
    ],
    ids=lambda true: "+".join(true),
)
def test_what_acts_beside_another_effect_is_named_with_it(true):
    found = diagnose(Model(load_vehicle(VEHICLES / "quadrotor.yaml")), flights("quadrotor", true))
    assert sorted(found.supported) == sorted(true)
    for name, values in true.items():
        for parameter, value in values.items():
            slack = 0.05 * np.max(np.abs(value))
            np.testing.assert_allclose(found.finding(name).parameters[parameter], value, rtol=0.05, atol=slack)


def test_what_acts_beside_another_effect_is_not_asked_for_without_it():
    found = of_nothing("quadrotor")
    for name in ("wind", "pressure_centre"):
        assert found.finding(name).verdict == "Not testable here"
        assert "acts beside" in found.finding(name).reason


@pytest.mark.long
def test_a_lag_of_the_sensors_is_named_with_its_time_constant():
    true = {"sensor_lag": {"time_constant": 0.008}}
    found = diagnose(Model(load_vehicle(VEHICLES / "quadrotor.yaml")), flights("quadrotor", true))
    assert "sensor_lag" in {n for s in found.supported for n in found.finding(s).group}
    said = found.finding("sensor_lag")
    # Clocks may be off by a millisecond, which looks nearly the same; the error holds half of what they take up, too.
    assert said.standard_errors["time_constant"] < 0.0015
    assert said.parameters["time_constant"] == pytest.approx(0.008, abs=3.0 * said.standard_errors["time_constant"])
