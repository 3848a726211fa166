"""The truth file: strict, and refused in one line."""

from pathlib import Path

import pytest
import yaml

from infotraj.errors import InputError
from infotraj.robots.plant.model import Bodies
from infotraj.robots.plant.truth import Truth, load_truth
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle("config/vehicles/omav.yaml")
CONTENT = yaml.safe_load(Path("config/plants/omav_a.yaml").read_text())


def refused(tmp_path, content, match):
    path = tmp_path / "truth.yaml"
    path.write_text(content if isinstance(content, str) else yaml.safe_dump(content))
    with pytest.raises(InputError, match=match) as failure:
        load_truth(path, OMAV)
    assert "\n" not in str(failure.value)
    assert str(path) in str(failure.value)


def test_unknown_keys_are_refused_at_every_depth(tmp_path):
    refused(tmp_path, {**CONTENT, "colour": "red"}, "colour: unknown key")
    refused(tmp_path, {**CONTENT, "air": {**CONTENT["air"], "smell": 1.0}}, "air.smell: unknown key")


def test_one_number_a_rotor_and_a_tilt(tmp_path):
    rotors = {**CONTENT["rotors"], "thrust_factor": [1.0] * 11}
    refused(tmp_path, {**CONTENT, "rotors": rotors}, "thrust_factor has 11 numbers; expected 12")
    short = {**CONTENT["servos"], "play": [0.0] * 5}
    refused(tmp_path, {**CONTENT, "servos": short}, "servos.play has 5 numbers; expected 6")


def test_another_vehicles_truth_is_refused(tmp_path):
    refused(tmp_path, {**CONTENT, "vehicle": "quadrotor"}, "belongs to vehicle quadrotor")


def test_what_is_not_a_truth_file_is_refused(tmp_path):
    refused(tmp_path, "a: [", "cannot be read as YAML")
    refused(tmp_path, "just text", "truth.yaml")
    with pytest.raises(InputError, match="there is no such file"):
        load_truth(tmp_path / "absent.yaml", OMAV)


def test_arms_heavier_than_the_vehicle_are_refused():
    truth = load_truth("config/plants/omav_a.yaml", OMAV)
    heavy = truth.model_copy(update={"arm": truth.arm.model_copy(update={"mass": 0.6})})
    with pytest.raises(InputError, match="no body is left"):
        Bodies(OMAV, heavy, 1e-3)


def test_the_ideal_plant_needs_a_complete_vehicle():
    with pytest.raises(InputError, match="no mass"):
        Truth.ideal(OMAV.model_copy(update={"mass": None}))
    with pytest.raises(InputError, match="no inertia"):
        Truth.ideal(OMAV.model_copy(update={"inertia": None}))
    mixed = [r.model_copy(update={"time_constant": 0.01 * (i + 1)}) for i, r in enumerate(OMAV.rotors)]
    with pytest.raises(InputError, match="different time constants"):
        Truth.ideal(OMAV.model_copy(update={"rotors": tuple(mixed)}))
