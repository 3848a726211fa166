"""The flights that ship: they are small and hold what they say; the command of the README names what is hidden."""

import base64
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from click.testing import CliRunner

from infotraj import __version__
from infotraj.examples.command import examples_command
from infotraj.examples.location import FOLDERS, shipped
from infotraj.examples.packing import pack
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, Flight, read_flight
from infotraj.vehicle import load_vehicle

TOP = Path(__file__).parents[2]
QUAD = TOP / "examples" / "quad"
CHANGED = sorted(QUAD.glob("*.parquet"))
HEALTHY = sorted((QUAD / "healthy").glob("*.parquet"))


def run(*arguments, cwd=TOP):
    done = subprocess.run(
        [sys.executable, "-m", "infotraj.cli", *map(str, arguments)], cwd=cwd, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done


def hidden():
    """What was hidden, from the sealed file."""
    body = "".join((QUAD / "truth.sealed").read_text().splitlines(keepends=True)[3:])
    ((effect),) = yaml.safe_load(base64.b64decode(body))["effects"]
    return effect


def test_the_examples_are_below_a_megabyte_and_the_vehicle_file_is_the_quadrotor_of_the_plant():
    assert sum(p.stat().st_size for p in QUAD.rglob("*") if p.is_file()) < 1_000_000
    assert load_vehicle(QUAD / "vehicle.yaml") == load_vehicle(TOP / "config/vehicles/quadrotor.yaml")


@pytest.mark.long
def test_the_command_of_the_readme_names_what_is_hidden_and_its_number(tmp_path):
    out = tmp_path / "d.json"
    run("diagnose", QUAD / "vehicle.yaml", *CHANGED, "--json", out)
    said, true = json.loads(out.read_text()), hidden()
    assert said["infotraj"] == __version__
    assert said["verdict"]["supported"] == [true["name"]]
    assert not said["verdict"]["unexplained"]
    (row,) = (r for r in said["effects"] if r["name"] == true["name"])
    assert row["verdict"] == "Supported"
    assert row["parameters"]["rotor"] == true["parameters"]["rotor"]
    # not to three standard errors: rounding and 100 Hz have an error of their own, so within 1 % of the loss
    assert row["parameters"]["factor"] == pytest.approx(true["parameters"]["factor"], abs=0.01 * 0.15)


# That the same rotor has changed since these is asked by the tutorial (test_pages.py).
@pytest.mark.long
def test_of_the_healthy_flights_nothing_is_named(tmp_path):
    out = tmp_path / "d.json"
    run("diagnose", QUAD / "vehicle.yaml", *HEALTHY, "--json", out)
    verdict = json.loads(out.read_text())["verdict"]
    assert verdict["supported"] == []
    assert not verdict["unexplained"]


@pytest.mark.long
def test_the_log_of_the_board_becomes_the_flight_that_it_was_made_from(tmp_path):
    """Only its rates need mending: the mapping leaves their unit out, as the tutorial says."""
    out = tmp_path / "f.parquet"
    run("import", QUAD / "log/board.csv", "--mapping", QUAD / "log/board.yaml", "--fix", "-o", out)
    mended, flight = read_flight(out), read_flight(CHANGED[0])
    assert np.allclose(mended.t, flight.t, atol=1e-6)
    for names, size in ((POSITION, 2e-5), (RATE, 1e-4), (SPECIFIC_FORCE, 1e-4)):
        assert np.allclose(mended.get(*names), flight.get(*names), atol=size)
    same = np.sign(np.sum(mended.get(*ATTITUDE) * flight.get(*ATTITUDE), axis=1, keepdims=True))
    assert np.allclose(same * mended.get(*ATTITUDE), flight.get(*ATTITUDE), atol=2e-5)
    assert np.allclose(mended.numbered("cmd_rotor_"), flight.numbered("cmd_rotor_"), rtol=1e-5)


def test_examples_are_copied_whole_and_never_over_what_is_there(tmp_path):
    to = tmp_path / "new"
    done = CliRunner().invoke(examples_command, [str(to)])
    assert done.exit_code == 0, done.output
    for name, folder in FOLDERS.items():
        there = {p.relative_to(TOP / folder): p.read_bytes() for p in (TOP / folder).rglob("*") if p.is_file()}
        assert {p.relative_to(to / name): p.read_bytes() for p in (to / name).rglob("*") if p.is_file()} == there
        assert shipped(name).is_dir()
    (to / "quad" / "vehicle.yaml").write_text("mine")
    again = CliRunner().invoke(examples_command, [str(to)])
    assert again.exit_code != 0
    assert "is there already" in str(again.exception)
    assert (to / "quad" / "vehicle.yaml").read_text() == "mine"


def test_what_a_checkout_lacks_is_copied_beside_what_it_has(tmp_path):
    (tmp_path / "quad").mkdir()
    (tmp_path / "quad" / "mine").write_text("mine")
    done = CliRunner().invoke(examples_command, [str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert "quad: is there already, left as it is" in done.output
    assert [p.name for p in (tmp_path / "quad").iterdir()] == ["mine"]
    assert load_vehicle(tmp_path / "vehicles" / "crazyswarm2.yaml").name


def test_nothing_but_the_packing_knows_the_sealed_file():
    knowing = [p for p in (TOP / "src").rglob("*.py") if "seal" in p.read_text()]
    assert [p.name for p in knowing] == ["packing.py"]


def test_packing_keeps_the_rows_in_which_poses_and_commands_change(tmp_path):
    """200 Hz with poses in every other row, as the plant logs: no pose is lost, and every row has one."""
    t = 0.005 * np.arange(101)
    table = {"t": t, "wx": np.sin(t), "cmd_rotor_0": np.repeat(np.arange(51.0), 2)[:101], "cmd_fz": 8 + t}
    table |= {"px": np.where(np.arange(101) % 2 == 0, t / 3, np.nan)}
    flight = Flight(pd.DataFrame(table), {"vehicle": "quadrotor"})
    flight.write(tmp_path / "flight_0.parquet")
    pack(tmp_path, [tmp_path / "small.parquet"])
    small = read_flight(tmp_path / "small.parquet")
    assert np.allclose(small.t, t[::2])
    assert small.table["px"].notna().all()
    assert np.allclose(small.table["px"], t[::2] / 3, atol=1e-5)
    assert small.table["cmd_rotor_0"].tolist() == list(range(51))
    assert "cmd_fz" not in small.table
