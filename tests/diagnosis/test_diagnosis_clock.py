"""The clock of a noisy IMU: noise of its samples says nothing of when they were taken."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.select.around import linearised
from infotraj.diagnosis.select.prior import Scales
from infotraj.effects import catalogue
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

FILE = Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml"
NOISE = {"gyro": 0.03, "accelerometer": 0.3}
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
