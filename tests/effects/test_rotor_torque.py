"""A rotor that is elsewhere: its correction predicts what the vehicle file with its true place does."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.effects import effect_class
from infotraj.effects.rotor_torque import RotorTorque
from infotraj.flight import Flight, read_flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

TOP = Path(__file__).parents[2]
MOVED = np.array([0.02, -0.01, 0.0])  # m
AIR = {"axial_inflow": 2e-4, "rotor_drag": 1e-4}


def moved(vehicle, rotor, by):
    rotors = list(vehicle.rotors)
    place = tuple(np.add(rotors[rotor].position, by))
    rotors[rotor] = rotors[rotor].model_copy(update={"position": place})
    return vehicle.model_copy(update={"rotors": tuple(rotors)})


@pytest.fixture(scope="module")
def flight():
    return read_flight(TOP / "examples/quad/flight_0.parquet")


def turned(model, flight):
    found = model.predict(flight)
    return np.concatenate([found.specific_force, found.angular_acceleration], axis=1)


@pytest.mark.parametrize("name", AIR)
def test_what_meets_the_air_at_a_rotor_meets_it_where_the_rotor_is(name, flight):
    vehicle = load_vehicle(TOP / "examples/quad/vehicle.yaml")
    effect = effect_class(name)(k=AIR[name])
    true = turned(Model(moved(vehicle, 1, MOVED), [effect]), flight)
    corrected = turned(Model(vehicle, [effect, RotorTorque(rotor=1, r=np.cross(MOVED, [0.0, 0.0, 1.0]))]), flight)
    # The torque of a rotor's own drag about its place is another number, of the middle of the rotors.
    np.testing.assert_allclose(corrected[:, :3], true[:, :3], atol=1e-10)
    if name != "rotor_drag":
        np.testing.assert_allclose(corrected, true, atol=1e-10)
    # Without the correction the force is another, so that this can fail.
    assert np.max(np.abs(turned(Model(vehicle, [effect]), flight) - true)[:, :3]) > 1e-3


def test_a_rotor_that_is_elsewhere_changes_no_model_in_which_nothing_damps_turns_by_the_air(flight):
    vehicle = load_vehicle(TOP / "examples/quad/vehicle.yaml")
    elsewhere = RotorTorque(rotor=1, r=np.cross(MOVED, [0.0, 0.0, 1.0]))
    assert Model(vehicle, [elsewhere]).air_law().moved == ()
    inflow = effect_class("axial_inflow")(k=2e-4)
    ((rotor, r),) = Model(vehicle, [elsewhere, inflow]).air_law().moved
    assert (rotor, r.tolist()) == (1, elsewhere.r.tolist())


def test_on_an_arm_that_tilts_the_rotor_that_is_elsewhere_tilts_with_it():
    path = TOP / "config/vehicles/omav.yaml"
    vehicle, inflow = load_vehicle(path), effect_class("axial_inflow")(k=2e-4)
    table = fly(yaml.safe_load(path.read_text()), {}, seconds=3.0, seed=0, noise={})
    flight = Flight(table, {})
    rotor = next(i for i, r in enumerate(vehicle.rotors) if r.tilt is not None)
    tilt = vehicle.rotors[rotor].tilt
    assert tilt is not None
    arm = [i for i, r in enumerate(vehicle.rotors) if r.tilt == tilt]
    by = np.cross(vehicle.rotors[rotor].axis, vehicle.tilts[tilt].axis) * 0.01
    elsewhere = vehicle
    for i in arm:
        elsewhere = moved(elsewhere, i, by)
    r = np.cross(by, vehicle.rotors[rotor].axis)
    corrected = turned(Model(vehicle, [inflow, RotorTorque(rotor=rotor, r=r)]), flight)
    np.testing.assert_allclose(corrected, turned(Model(elsewhere, [inflow]), flight), atol=1e-9)
