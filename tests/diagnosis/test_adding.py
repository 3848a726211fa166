"""What `add` puts into a model: what was asked for, as these flights have it, and what corrects the file."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from infotraj.cli import cli
from infotraj.diagnosis.adding import add
from infotraj.diagnosis.gates import refusal
from infotraj.errors import UsageError
from infotraj.flight import read_flight
from infotraj.models import Model
from infotraj.models.file import read_model
from infotraj.vehicle import load_vehicle

EXAMPLE = Path(__file__).parents[2] / "examples" / "quad"
FLIGHTS = [EXAMPLE / f"flight_{k}.parquet" for k in range(2)]
WRONG = 1.05  # times the mass


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """A model made by the command from a file whose mass is 5 % too large, and what it printed and wrote as JSON."""
    folder = tmp_path_factory.mktemp("added")
    content = yaml.safe_load((EXAMPLE / "vehicle.yaml").read_text())
    content["mass"] *= WRONG
    (folder / "heavy.yaml").write_text(yaml.safe_dump(content))
    model, numbers = folder / "new.yaml", folder / "new.json"
    arguments = [
        "add",
        folder / "heavy.yaml",
        "rotor_effectiveness:3",
        "--fit",
        *FLIGHTS,
        "-o",
        model,
        "--json",
        numbers,
    ]
    result = CliRunner().invoke(cli, [str(a) for a in arguments])
    assert result.exit_code == 0, result.output
    return content["mass"], model, json.loads(numbers.read_text()), result.output


def test_a_wrong_mass_is_corrected_in_the_model_and_said(saved):
    mass, model, said, printed = saved
    assert [e["name"] for e in said["effects"]] == ["rotor_effectiveness"]
    (fix,) = said["corrected"]
    assert fix["name"] == "mass_offset"
    assert fix["parameters"]["dm"] == pytest.approx(mass / WRONG - mass, rel=0.02)
    assert said["effects"][0]["parameters"]["factor"] == pytest.approx(0.856, abs=0.002)
    # The factor is no surer than the mass that it is told beside.
    assert said["effects"][0]["standard_errors"]["factor"] > 1e-3
    assert "mass_offset" in printed
    assert "it corrects the file" in printed
    kept, _ = read_model(model)
    assert [e.name for e in kept.effects] == ["rotor_effectiveness", "mass_offset"]
    assert "the file corrected by mass_offset" in yaml.safe_load(model.read_text())["provenance"]["note"]


def test_the_corrected_model_predicts_a_flight_that_was_not_fitted_to_its_floor(saved):
    _, path, _, _ = saved
    model, _ = read_model(path)
    error = refusal.errors(model, [read_flight(EXAMPLE / "flight_2.parquet")], None, None)
    assert np.all(error.rmse < 1.2 * error.floor)


def test_a_right_file_is_left_as_it_is_and_what_was_asked_for_stays_though_it_is_not_needed():
    vehicle = load_vehicle(EXAMPLE / "vehicle.yaml")
    made = add(Model(vehicle), ["rotor_effectiveness:3", "hub_moment"], [read_flight(p) for p in FLIGHTS])
    assert made.beside == ()
    assert [e.name for e in made.model.effects] == ["rotor_effectiveness", "hub_moment"]
    assert made.as_dict()["corrected"] == []
    assert "is worse with the new model" not in made.as_text()
    worse = replace(made, after=replace(made.after, rmse=made.before.rmse * [1.0, 1.9, 1.0, 1.0, 1.0, 1.0]))
    assert "\nfy is worse with the new model: " in worse.as_text()


@pytest.mark.parametrize("name", ["inertia_products", "rotor_torque:0"])
def test_a_number_of_the_file_cannot_be_asked_for(name):
    with pytest.raises(UsageError, match=f"{name} is a number of the vehicle file, which is corrected along"):
        add(Model(load_vehicle(EXAMPLE / "vehicle.yaml")), [name], [read_flight(FLIGHTS[0])])
