"""A rotor that is elsewhere: its corrections predict what the vehicle file with its true place does."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.effects import effect_class
from infotraj.effects.rotor_height import RotorHeight
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
@pytest.mark.parametrize("height", [0.0, 0.012])
def test_what_meets_the_air_at_a_rotor_meets_it_where_the_rotor_is(name, height, flight):
    vehicle = load_vehicle(TOP / "examples/quad/vehicle.yaml")
    effect = effect_class(name)(k=AIR[name])
    by = np.add(MOVED, (0.0, 0.0, height))
    true = turned(Model(moved(vehicle, 1, by), [effect]), flight)
    across = RotorTorque(rotor=1, r=np.cross(by, [0.0, 0.0, 1.0]))
    corrected = turned(Model(vehicle, [effect, across, RotorHeight(rotor=1, h=height)]), flight)
    np.testing.assert_allclose(corrected, true, atol=1e-10)
    # Without the corrections the force is another, and with drag at the rotors also without the height: it can fail.
    assert np.max(np.abs(turned(Model(vehicle, [effect]), flight) - true)[:, :3]) > 1e-3
    if height and name == "rotor_drag":
        assert np.max(np.abs(turned(Model(vehicle, [effect, across]), flight) - true)[:, 3:]) > 1e-3


def test_a_rotor_that_is_elsewhere_changes_no_model_in_which_nothing_damps_turns_by_the_air(flight):
    vehicle = load_vehicle(TOP / "examples/quad/vehicle.yaml")
    elsewhere = RotorTorque(rotor=1, r=np.cross(MOVED, [0.0, 0.0, 1.0]))
    assert Model(vehicle, [elsewhere]).air_law.moved == ()
    inflow = effect_class("axial_inflow")(k=2e-4)
    (move,) = Model(vehicle, [elsewhere, inflow]).air_law.moved
    assert (move.rotor, move.torque.tolist(), move.height) == (1, elsewhere.r.tolist(), 0.0)


def test_a_rotor_that_points_up_and_is_higher_is_told_as_its_place_along_z():
    vehicle = load_vehicle(TOP / "examples/quad/vehicle.yaml")
    z = vehicle.rotors[1].position[2]
    assert RotorHeight.in_the_file(vehicle, 0, 1) == ("rotor_1.position.z", z, 1.0)
    omav = load_vehicle(TOP / "config/vehicles/omav.yaml")
    assert RotorHeight.in_the_file(omav, 0, 2) == ("rotor_2.position along its axis, more by", 0.0, 1.0)


@pytest.mark.parametrize("name", AIR)
def test_on_an_arm_that_tilts_the_rotor_that_is_elsewhere_tilts_with_it(name):
    path = TOP / "config/vehicles/omav.yaml"
    vehicle, met = load_vehicle(path), effect_class(name)(k=AIR[name])
    table = fly(yaml.safe_load(path.read_text()), {}, seconds=3.0, seed=0, noise={})
    flight = Flight(table, {})
    rotor = next(i for i, r in enumerate(vehicle.rotors) if r.tilt is not None)
    tilt = vehicle.rotors[rotor].tilt
    assert tilt is not None
    arm = [i for i, r in enumerate(vehicle.rotors) if r.tilt == tilt]
    axis = np.array(vehicle.rotors[rotor].axis)
    by = np.cross(axis, vehicle.tilts[tilt].axis) * 0.01 + 0.015 * axis
    elsewhere = vehicle
    for i in arm:
        elsewhere = moved(elsewhere, i, by)
    file = [RotorTorque(rotor=rotor, r=np.cross(by, axis)), RotorHeight(rotor=rotor, h=0.015)]
    corrected = turned(Model(vehicle, [met, *file]), flight)
    np.testing.assert_allclose(corrected, turned(Model(elsewhere, [met]), flight), atol=1e-9)
