"""How what corrects the file is saved, read again and said."""

from pathlib import Path

import numpy as np
import pytest

from infotraj.effects import effect_class, labels_in_words
from infotraj.effects.rotor_torque import RotorTorque
from infotraj.errors import UsageError
from infotraj.models import Model
from infotraj.models.file import read_model, save_model
from infotraj.vehicle import load_vehicle

VEHICLE = Path(__file__).parents[2] / "examples" / "quad" / "vehicle.yaml"


def test_a_number_of_the_file_that_is_no_effect_of_the_catalogue_is_read_again(tmp_path):
    place = RotorTorque(rotor=2, r=np.array([1e-3, -2e-3, 5e-4]))
    save_model(Model(load_vehicle(VEHICLE), [place]), tmp_path / "model.yaml")
    (kept,) = read_model(tmp_path / "model.yaml")[0].effects
    assert kept.label == "rotor_torque 2"
    assert kept.r == pytest.approx(place.r)
    with pytest.raises(UsageError):
        effect_class("rotor_torques")


def test_each_name_is_said_once_with_its_rotors():
    labels = ("rotor_torque 3", "mass_offset", "rotor_effectiveness 10", "rotor_torque 0", "rotor_effectiveness 9")
    assert labels_in_words(labels) == "rotor_torque (0 3), mass_offset, rotor_effectiveness (9 10)"
