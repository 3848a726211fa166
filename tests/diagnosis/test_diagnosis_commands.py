"""`diagnose`, `add` and `history`: the JSON's contract, bad input, an effect of the user's own, other tables."""

import json
import textwrap
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from exact_simulation import fly

from infotraj import rotations
from infotraj.cli import cli
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.judge.verdicts import Finding
from infotraj.diagnosis.report.steps import steps
from infotraj.diagnosis.report.summary import _effect
from infotraj.effects import catalogue
from infotraj.errors import InfotrajError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.recording import read_back
from infotraj.vehicle import load_vehicle

QUADROTOR = Path(__file__).parents[2] / "config" / "vehicles" / "quadrotor.yaml"
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.002, "velocity": 0.01}
DRAG = {"linear_drag": {"d": [0.1, 0.1, 0.1]}}
VERDICTS = {"Supported", "Not separable", "Plausible", "Not needed", "Not testable here"}
KEYS = {
    "name", "verdict", "group", "heldout_change", "ci95", "flights_better", "selected", "rise", "parameters",
    "standard_errors", "probability", "form_error", "gain", "reason", "of_file",
}  # fmt: skip
OWN = '''
"""Drag with the cube of the speed."""
import numpy as np
from infotraj.effects import Effect, Parameter

class CubicDrag(Effect):
    """Body force -k |v|^2 v."""
    name, place = "cubic_drag", "wrench"
    parameters = (Parameter("k", "N s^3/m^3", 0.1, (0.0, 10.0)),)
    needs = needs_to_act = ("velocity",)
    def wrench(self, along):
        v = along.velocity
        force = -self.k * np.sum(v**2, axis=1, keepdims=True) * v
        return np.hstack([force, np.zeros_like(force)])
'''


def run(*arguments):
    result = CliRunner().invoke(cli, [str(a) for a in arguments])
    assert isinstance(result.exception, (type(None), SystemExit, InfotrajError)), result.exception
    return result


def status_of(result):
    return getattr(result.exception, "exit_status", result.exit_code)


@pytest.fixture(scope="module")
def made():
    content = yaml.safe_load(QUADROTOR.read_text())
    return [fly(content, DRAG, seconds=8.0, seed=k, noise=NOISE) for k in range(2)]


@pytest.fixture
def paths(made, tmp_path):
    found = []
    for k, table in enumerate(made):
        found.append(tmp_path / f"{k}.parquet")
        table.to_parquet(found[-1])
    return found


def test_the_json_has_every_key_for_every_effect(paths, tmp_path):
    new = tmp_path / "new.yaml"
    drawn = [tmp_path / f"{k}.rrd" for k in range(2)]
    saved = ("--json", tmp_path / "d.json", "--save-model", new, "--recording", drawn[0])
    result = run("diagnose", QUADROTOR, *paths, *saved)
    assert result.exit_code == 0
    said = json.loads((tmp_path / "d.json").read_text())
    assert said["verdict"]["supported"] == ["linear_drag"]
    assert said["verdict"]["unexplained"] is False
    assert [e["name"] for e in said["effects"]] == list(catalogue())
    for e in said["effects"]:
        assert set(e) == KEYS
        assert e["verdict"] in VERDICTS
        assert e["name"] in e["group"]
        assert e["reason"] or e["verdict"] == "Supported"
    drag = next(e for e in said["effects"] if e["name"] == "linear_drag")
    assert drag["ci95"][0] <= drag["heldout_change"] <= drag["ci95"][1] < 0
    assert drag["flights_better"] == [2, 2]
    assert drag["rise"] > 1
    assert set(drag["parameters"]) == set(drag["standard_errors"]) == {"d"}
    for error in ("before", "after", "floor"):
        assert set(said["error"][error]) == {"fx", "fy", "fz", "tx", "ty", "tz"}
    assert said["error"]["after"]["fx"] < 0.3 * said["error"]["before"]["fx"]

    # What the model has is not missing from it, and where nothing is supported the model stays as it is.
    again, last = tmp_path / "again.json", tmp_path / "last.yaml"
    saved = ("--json", again, "--save-model", last, "--recording", drawn[1])
    assert run("diagnose", new, *paths, *saved).exit_code == 0
    said = json.loads(again.read_text())
    assert said["verdict"]["supported"] == []
    assert next(e for e in said["effects"] if e["name"] == "linear_drag")["verdict"] == "Not needed"
    old, kept = (yaml.safe_load(p.read_text()) for p in (new, last))
    assert (old["vehicle"], old["effects"]) == (kept["vehicle"], kept["effects"])

    # A recording holds the new model and the one as given, where they differ.
    first, second = ({k: v for k, v in read_back(p).items() if "/fx/" in k} for p in drawn)
    names = {"predicted": "the new model", "predicted_2": "the model as given"}
    assert {k: first[f"wrench/fx/{k}"]["SeriesLines:names"] for k in names} == {k: [n] for k, n in names.items()}
    new_left, given_left = (np.std(first[f"residual/fx/{k}"]["Scalars:scalars"]) for k in ("residual", "residual_2"))
    assert new_left < 0.3 * given_left
    assert "wrench/fx/predicted_2" not in second


def test_all_instances_of_an_effect_are_written_and_no_key_where_it_has_one():
    rotors = ({"rotor": 3, "factor": 0.8}, {"rotor": 1, "factor": 0.9})
    errors = ({"factor": 0.01}, {"factor": 0.02})
    name = "rotor_effectiveness"
    weak = Finding(name, "Supported", (name,), None, rotors[0], errors[0], instances=rotors, instance_errors=errors)
    assert _effect(weak, None)["instances"] == [*rotors]
    assert [f.standard_errors for f in weak.each] == [*errors]
    assert "instances" not in _effect(replace(weak, instances=(), instance_errors=()), None)


@pytest.mark.long
def test_the_part_that_was_fitted_is_recorded_and_shown(paths, tmp_path):
    new, more, numbers = tmp_path / "new.yaml", tmp_path / "more.yaml", tmp_path / "h.json"
    assert run("add", QUADROTOR, "linear_drag", "--fit", *paths, "-o", new, "--from", 1, "--to", 6.5).exit_code == 0
    (first, second) = yaml.safe_load(new.read_text())["provenance"]["flights"]
    assert (first["from"], first["to"], second["from"], second["to"]) == (1.0, 6.5, 1.0, 6.5)
    said = run("history", new, "--json", numbers).stdout
    assert "   fitted and judged from 1 s to 6.5 s\n" in said
    assert json.loads(numbers.read_text())["versions"][-1]["provenance"]["flights"][1]["to"] == 6.5

    # Of flights that are too long together, what was used of each; of whole flights nothing.
    assert run("diagnose", new, *paths, "--save-model", more, "--from", 1, "--seconds", 8).exit_code == 0
    for flight in yaml.safe_load(more.read_text())["provenance"]["flights"]:
        assert flight["from"] >= 1.0
        assert flight["to"] - flight["from"] == pytest.approx(4.0)
    whole = tmp_path / "whole.yaml"
    assert run("add", QUADROTOR, "linear_drag", "--fit", *paths, "-o", whole).exit_code == 0
    assert [set(f) for f in yaml.safe_load(whole.read_text())["provenance"]["flights"]] == 2 * [{"path", "sha256"}]
    assert "fitted and judged" not in run("history", whole).stdout


@pytest.mark.parametrize(("parent", "state"), [(None, "missing"), ("vehicle: [1, 2\n", "unreadable")])
def test_a_history_whose_first_models_cannot_be_read_tells_the_others(tmp_path, parent, state):
    old, new = tmp_path / "old.yaml", tmp_path / "new.yaml"
    if parent is not None:
        old.write_text(parent)
    came = {"note": "added linear_drag", "parent": {"path": str(old), "sha256": "0" * 64}}
    drag = {"name": "linear_drag", "parameters": {"d": [0.1, 0.1, 0.1]}}
    new.write_text(yaml.safe_dump({"vehicle": str(QUADROTOR), "effects": [drag], "provenance": came}))
    said = run("history", new)
    assert status_of(said) == 0
    assert f"0  {old} ({state})\n1  {new}: linear_drag\n   added linear_drag" in said.output
    drag["parameters"]["d"][1] = float("nan")
    new.write_text(yaml.safe_dump({"vehicle": str(QUADROTOR), "effects": [drag]}))
    assert status_of(run("history", new)) == 3


def test_a_vehicle_file_without_mass_and_inertia_is_not_said_of_the_flight(paths, tmp_path):
    content = yaml.safe_load(QUADROTOR.read_text())
    less = {k: v for k, v in content.items() if k not in ("mass", "inertia")}
    (tmp_path / "v.yaml").write_text(yaml.safe_dump(less))
    for command in (["diagnose"], ["locate"], ["add", "linear_drag", "-o", tmp_path / "m.yaml", "--fit"]):
        result = run(command[0], tmp_path / "v.yaml", *command[1:], paths[0])
        assert status_of(result) == 3
        wanted = "expected a vehicle file with mass and inertia. Add what it lacks to the file."
        assert str(result.exception).endswith(wanted)


def test_bad_input_is_one_line_and_leaves_nothing(paths, made, tmp_path):
    bad = made[0].copy()
    bad.loc[5, "t"] = np.nan
    bad.to_csv(tmp_path / "time.csv", index=False)
    made[0].iloc[:200].to_csv(tmp_path / "short.csv", index=False)
    made[0].drop(columns=[c for c in made[0] if "rotor" in c]).to_csv(tmp_path / "bare.csv", index=False)
    (tmp_path / "broken.yaml").write_text("vehicle: [1, 2\n")
    (tmp_path / "key.yaml").write_text(f"vehicle: {QUADROTOR}\nfoo: 1\n")
    (tmp_path / "name.yaml").write_text(f"vehicle: {QUADROTOR}\neffects: [{{name: none_such}}]\n")
    out = tmp_path / "out.yaml"
    before = QUADROTOR.read_bytes()
    for status, *arguments in (
        (3, "diagnose", QUADROTOR, tmp_path / "no.csv"),
        (3, "diagnose", QUADROTOR, tmp_path / "time.csv"),
        (3, "diagnose", QUADROTOR, tmp_path / "short.csv"),
        (3, "diagnose", QUADROTOR, tmp_path / "bare.csv"),
        (3, "diagnose", tmp_path / "no.yaml", paths[0]),
        (3, "diagnose", tmp_path / "broken.yaml", paths[0]),
        (3, "diagnose", tmp_path / "key.yaml", paths[0]),
        (3, "diagnose", tmp_path / "name.yaml", paths[0]),
        (2, "diagnose", QUADROTOR, paths[0], "--from", 5, "--to", 3),
        (3, "diagnose", QUADROTOR, paths[0], "--from", 50),
        (3, "diagnose", QUADROTOR, paths[0], "--effects-from", tmp_path / "no.py"),
        (2, "diagnose", QUADROTOR, paths[0], "--save-model", QUADROTOR),
        (2, "add", QUADROTOR, "none_such", "--fit", paths[0], "-o", out),
        (3, "add", QUADROTOR, "servo_lag", "--fit", paths[0], "-o", out),
        (2, "add", QUADROTOR, "rotor_effectiveness:9", "--fit", paths[0], "-o", out),
        (3, "add", QUADROTOR, "linear_drag", "--fit", tmp_path / "no.csv", "-o", out),
        (3, "history", tmp_path / "no.yaml"),
    ):
        files = set(tmp_path.iterdir())
        result = run(*arguments)
        assert status_of(result) == status, (arguments, result.output)
        assert isinstance(result.exception, InfotrajError)
        assert "\n" not in str(result.exception)
        assert set(tmp_path.iterdir()) == files
    assert QUADROTOR.read_bytes() == before


@pytest.mark.long
def test_an_effect_of_the_users_own_is_supported_where_it_is_hidden(made, tmp_path, monkeypatch):
    (tmp_path / "own.py").write_text(textwrap.dedent(OWN))
    vehicle = load_vehicle(QUADROTOR)
    tables = []
    for table in made:
        # The drag that these flights have is turned into a cubic one: the specific force is all that it changes here.
        table = table.copy()
        q = table[["qw", "qx", "qy", "qz"]].to_numpy()

        v = rotations.to_body(rotations.normalize(q), table[["vx", "vy", "vz"]].to_numpy())
        change = (0.1 * v - 0.08 * np.sum(v**2, axis=1, keepdims=True) * v) / vehicle.mass
        table[["ax", "ay", "az"]] += change
        tables.append(table.drop(columns=["px", "py", "pz"]))
    flights = [Flight(t, {"source": f"flight {k}"}) for k, t in enumerate(tables)]
    monkeypatch.setenv("INFOTRAJ_EFFECTS", str(tmp_path / "own.py"))
    found = diagnose(Model(vehicle), flights)
    finding = found.finding("cubic_drag")
    assert finding.verdict == "Supported"
    assert finding.parameters["k"] == pytest.approx(0.08, rel=0.05)
    assert [f.name for f in found.findings] == [*catalogue()]


def test_flights_with_different_channels_and_lengths(made):
    pose = ["px", "py", "pz", "vx", "vy", "vz", "qw", "qx", "qy", "qz"]
    camera = made[1].drop(columns=["ax", "ay", "az", "wx", "wy", "wz", "px", "py", "pz"]).iloc[:1000]
    flights = [Flight(t, {}) for t in (made[0], made[1].drop(columns=pose), camera)]
    found = diagnose(Model(load_vehicle(QUADROTOR)), flights)
    assert set(found.supported) <= {"linear_drag"}


def test_motion_capture_alone_can_show_a_mass(made):
    pose = ["px", "py", "pz", "qw", "qx", "qy", "qz"]
    columns = ["t", *pose, *(c for c in made[0] if c.startswith("cmd_"))]
    found = diagnose(Model(load_vehicle(QUADROTOR)), [Flight(t[columns].copy(), {}) for t in made])
    assert found.supported == ("linear_drag",)
    assert found.finding("mass_offset").verdict == "Not needed"
    assert found.finding("gyro_bias").verdict == "Not testable here"


@pytest.mark.long
def test_the_waterfall_draws_the_numbers_of_the_model_that_is_given(made):
    """Also where they are not those that a fit beside the file as it is would give: here half of them."""
    found = diagnose(Model(load_vehicle(QUADROTOR)), [Flight(t) for t in made])
    final = found.final
    half = replace(final.solution, theta=0.5 * final.solution.theta, each=0.5 * final.solution.each)
    whole, part = steps(found).rmse, steps(replace(found, final=replace(final, solution=half))).rmse
    assert whole[1, 0] < 0.5 * whole[0, 0]
    assert 0.4 * whole[0, 0] < part[1, 0] < 0.8 * whole[0, 0]
