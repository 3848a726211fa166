"""The point of the body at which its motion was measured: predicted, and told where the file has it wrong."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj import rotations
from infotraj.comparing.rollouts import parse_horizons, rollouts
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.effects import catalogue
from infotraj.effects.sensor_place import SensorPlace
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import parse_vehicle

CONTENT = yaml.safe_load((Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml").read_text())
PLACE = np.array([0.05, -0.02, 0.03])
IMU = ["ax", "ay", "az"]
NOISE = {"gyro": 0.002, "accelerometer": 0.03, "position": 0.0002, "attitude": 0.0005, "velocity": 0.003}


def at_place(table, of_body=PLACE):
    """The flight as a motion capture sees it whose markers' middle is there: no accelerometer, and no velocity."""
    attitude = rotations.matrix(table[["qw", "qx", "qy", "qz"]].to_numpy())
    moved = table[["px", "py", "pz"]].to_numpy() + np.einsum("nij,j->ni", attitude, of_body)
    out = table.drop(columns=[*IMU, "vx", "vy", "vz", *(f"rotor_{i}" for i in range(4))])
    return Flight(out.assign(px=moved[:, 0], py=moved[:, 1], pz=moved[:, 2]), {})


@pytest.mark.parametrize("more", [{}, {"gyroscopic": {"rotor_inertia": 3e-5}, "com_offset": {"r": [0.004, 0, 0.005]}}])
def test_the_force_there_is_that_of_its_path(more):
    """Second differences of the path of a point of the body, from poses 0.5 ms apart, against the prediction."""
    step = 5e-4
    table = fly(CONTENT, more, seconds=2.0, row=step, substep=step / 2)
    known = catalogue()
    model = Model(parse_vehicle({**CONTENT, "measured_at": PLACE.tolist()}), [known[k](**v) for k, v in more.items()])
    attitude = rotations.matrix(table[["qw", "qx", "qy", "qz"]].to_numpy())
    place = table[["px", "py", "pz"]].to_numpy() + np.einsum("nij,j->ni", attitude, PLACE)
    acceleration = (place[2:] - 2 * place[1:-1] + place[:-2]) / step**2 + [0.0, 0.0, 9.81]
    # Commands jump at the rows: what two steps hold together is the mean of both.
    asked = model.predict(Flight(table, {})).specific_force_mean
    asked = np.einsum("nij,nj->ni", attitude[:-1], asked[:-1])
    predicted = (asked[1:] + asked[:-1]) / 2
    without = Model(parse_vehicle(CONTENT), model.effects).predict(Flight(table, {})).specific_force_mean
    without = np.einsum("nij,nj->ni", attitude[:-1], without[:-1])
    error, all_of_it = acceleration - predicted, acceleration - (without[1:] + without[:-1]) / 2
    late = slice(1200, None)
    assert np.std(error[late]) < 0.05 * np.std(all_of_it[late])


@pytest.mark.long
def test_markers_beside_the_origin_are_told_and_no_effect_is_named():
    flights = [at_place(fly(CONTENT, {}, seconds=7.0, seed=k, noise=NOISE)) for k in (1, 2)]
    found = diagnose(Model(parse_vehicle(CONTENT)), flights)
    assert found.supported == ()
    told = {n.name: n for n in found.file}
    for axis, true in zip("xyz", PLACE, strict=True):
        assert told[f"measured_at.{axis}"].value == pytest.approx(true, abs=0.003)
    corrected = Model(parse_vehicle({**CONTENT, "measured_at": PLACE.tolist()}))
    again = diagnose(corrected, flights)
    assert not [n.name for n in again.file if n.name.startswith("measured_at")]


def test_a_rollout_begins_and_ends_at_the_origin():
    """With the right place in the file an exact log of the markers rolls out as that of the origin does."""
    table = fly(CONTENT, {}, seconds=3.0)
    origin = Model(parse_vehicle(CONTENT))
    marked = Model(parse_vehicle({**CONTENT, "measured_at": PLACE.tolist()}))
    with_velocity = at_place(table).table
    rate = table[["wx", "wy", "wz"]].to_numpy()
    attitude = rotations.matrix(table[["qw", "qx", "qy", "qz"]].to_numpy())
    there = table[["vx", "vy", "vz"]].to_numpy() + np.einsum("nij,nj->ni", attitude, np.cross(rate, PLACE))
    flight = Flight(with_velocity.assign(vx=there[:, 0], vy=there[:, 1], vz=there[:, 2]), {})
    far = parse_horizons("0.5s")
    right, wrong = (np.nanmean(rollouts(m, flight, far).errors[:, 0, 0]) for m in (marked, origin))
    assert right < 1e-4
    assert wrong > 5e-3


def test_an_accelerometer_stands_where_the_file_has_its_origin():
    flight = Flight(fly(CONTENT, {}, seconds=2.0), {})
    assert "accelerometer" in SensorPlace.cannot_show(parse_vehicle(CONTENT), flight)
    assert SensorPlace.cannot_show(parse_vehicle(CONTENT), at_place(flight.table)) is None
