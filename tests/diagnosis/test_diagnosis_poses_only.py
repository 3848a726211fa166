"""Motion capture alone: what poses at 100 Hz without an IMU say, and what they leave open."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.diagnosis import diagnose
from infotraj.effects.laws import ImuLaw
from infotraj.flight import RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

VEHICLES = Path(__file__).parents[2] / "config/vehicles"
NOISE = {"gyro": 0.0, "accelerometer": 0.0, "position": 0.001, "attitude": 0.001, "velocity": 0.0}


def poses(name, effects):
    content = yaml.safe_load((VEHICLES / f"{name}.yaml").read_text())
    made = (fly(content, effects, seconds=12.0, seed=seed, noise=NOISE, row=0.01) for seed in range(4))
    return [Flight(f.drop(columns=[*RATE, *SPECIFIC_FORCE, *VELOCITY])) for f in made]


@pytest.mark.long
def test_a_load_is_no_mass():
    true = {"mass": 0.4, "length": 0.6}
    found = diagnose(Model(load_vehicle(VEHICLES / "omav.yaml")), poses("omav", {"suspended_load": true}))
    assert found.supported == ("suspended_load",)
    numbers = found.finding("suspended_load").parameters
    assert abs(numbers["mass"] - true["mass"]) < 0.01
    assert abs(numbers["length"] - true["length"]) < 0.03


@pytest.mark.parametrize("lost", [0, 40], ids=["whole", "frames lost"])
def test_the_path_that_swings_a_load_is_smooth(lost):
    """Positions to 0.5 mm at 100 Hz, twice differenced, are accelerations to 3.5 m/s^2."""
    t = 0.01 * np.arange(1201)
    place = np.stack([0.8 * np.sin(2 * t), 0.6 * np.sin(3 * t), 1 + 0.2 * np.cos(5 * t)], axis=1)
    true = np.stack([-3.2 * np.sin(2 * t), -5.4 * np.sin(3 * t), 9.81 - 5 * np.cos(5 * t)], axis=1)
    noisy = place + 0.0005 * np.random.default_rng(1).standard_normal(place.shape)
    columns = {
        "t": t,
        **dict(zip(("px", "py", "pz"), noisy.T, strict=True)),
        "qw": 1.0,
        "qx": 0.0,
        "qy": 0.0,
        "qz": 0.0,
    }
    table = pd.DataFrame(columns | {f"cmd_rotor_{i}": 1000.0 for i in range(4)})
    kept = np.setdiff1d(np.arange(len(t)), np.random.default_rng(2).integers(50, 1150, lost))
    flight = Flight(table.iloc[kept].reset_index(drop=True))
    prepared = Model(load_vehicle(VEHICLES / "quadrotor.yaml")).prepare(flight)
    path = prepared.origin_path(ImuLaw.ideal())
    inside = slice(30, -30)
    assert np.sqrt(np.mean((path.at(t) - true)[inside] ** 2)) < 0.3
    assert np.abs((path.at(t) - true)[inside].mean(axis=0)).max() < 0.02


@pytest.mark.long
def test_what_needs_an_imu_is_not_testable_and_says_so():
    found = diagnose(Model(load_vehicle(VEHICLES / "quadrotor.yaml")), poses("quadrotor", {}))
    assert found.supported == ()
    for name in ("gyro_bias", "imu_misalignment"):
        assert found.finding(name).verdict == "Not testable here"
        assert "rates" in found.finding(name).reason
