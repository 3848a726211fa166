"""The user's word: what is accepted is shown and in no one's way; and all commands take and refuse the same flights."""

import ast
import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from exact_simulation import fly

from infotraj.checking import admission, examine
from infotraj.checking.acceptance import accepting
from infotraj.checking.admission import admitted, checked
from infotraj.checking.codes import CHECKED, CODES, REFUSED
from infotraj.checking.command import check_command
from infotraj.comparing.command import compare_command
from infotraj.diagnosis.report.command import add_command, diagnose_command
from infotraj.errors import InfotrajError, InputError, UsageError
from infotraj.flight import Flight
from infotraj.locating.command import locate_command
from infotraj.models.file import read_model
from infotraj.vehicle import load_vehicle

ROOT = Path(__file__).parents[2]
VEHICLE = ROOT / "config" / "vehicles" / "quadrotor.yaml"
CONTENT = yaml.safe_load(VEHICLE.read_text())
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.002, "velocity": 0.01}
QUIET = {"compare": compare_command, "locate": locate_command, "diagnose": diagnose_command}


@pytest.fixture(scope="module")
def table():
    return fly(CONTENT, {"linear_drag": {"d": [0.1, 0.1, 0.1]}}, seconds=7.0, seed=0, noise=NOISE)


@pytest.fixture(scope="module")
def other():
    return fly(CONTENT, {"linear_drag": {"d": [0.1, 0.1, 0.1]}}, seconds=7.0, seed=1, noise=NOISE)


def in_degrees(table):
    """A flight that `check` rejects."""
    return table.assign(**{c: np.degrees(table[c]) for c in ("wx", "wy", "wz")})


def run(command, *arguments):
    done = CliRunner().invoke(command, [str(a) for a in arguments], standalone_mode=False)
    assert done.exception is None or isinstance(done.exception, (SystemExit, InfotrajError)), done.exception
    return done


def written(path, table, **meta):
    Flight(table, meta).write(path)
    return path


def test_the_registry_holds_the_codes_of_the_documentation_and_no_others():
    documented = {
        "check.md": re.search(r"## Findings\n(.*?)\n\n", (ROOT / "docs" / "check.md").read_text(), re.S)[1],
        "diagnosis.md": re.search(r"\| premise \|.*?\n\n", (ROOT / "docs" / "diagnosis.md").read_text(), re.S)[0],
    }
    rows = [row.split("|")[1] for row in documented["check.md"].splitlines()[2:]]
    found = []
    for row in rows:
        # "imu_clock_offset, velocity_clock_offset; _varies; _drift": endings stand for each of the names.
        names, *endings = [part.strip() for part in row.split(";")]
        first = None
        for name in (n.strip() for n in names.split(",")):
            first = first or name.rsplit("_", 1)[0]
            found.append(first + name if name.startswith("_") else name)
        found += [n.rsplit("_", 1)[0] + ending for ending in endings if ending.startswith("_")
                  for n in (x.strip() for x in names.split(","))]  # fmt: skip
        found += [ending for ending in endings if not ending.startswith("_")]
    assert sorted(found) == sorted(CHECKED)
    codes = set(re.findall(r"`([a-z_]+)`", documented["diagnosis.md"])) & set(CODES)
    assert codes == {*REFUSED, "response_before_command"}


def literals(node):
    """The strings that an argument may be, where it is written out."""
    if isinstance(node, ast.IfExp):
        return literals(node.body) | literals(node.orelse)
    return {node.value} if isinstance(node, ast.Constant) else set()


def test_every_code_that_is_written_out_in_the_sources_is_in_the_registry():
    found = set()
    for path in [*(ROOT / "src/infotraj/checking").glob("*.py"), *(ROOT / "src/infotraj/diagnosis").rglob("*.py")]:
        for node in ast.walk(ast.parse(path.read_text())):
            # The diagnosis has findings of its own, on effects.
            if not (isinstance(node, ast.Call) and node.args):
                continue
            called = getattr(node.func, "id", "")
            if called == "Doubt" or (called == "Finding" and path.parent.name == "checking"):
                found |= literals(node.args[0])
    assert {"dead_stream", "hovers", "copy", "nothing_measured"} <= found
    assert found <= set(CODES)


def test_an_accepted_finding_is_shown_and_rejects_nothing(table, tmp_path):
    path = written(tmp_path / "a.parquet", in_degrees(table))
    refused = run(check_command, path)
    assert refused.exception.code == 3
    assert "REJECT  rate_unit" in refused.stdout
    assert re.search(r"in the way of an answer: rate_unit$", refused.stdout, re.M)
    done = run(check_command, path, "--accept", "rate_unit", "--json", tmp_path / "r.json")
    assert done.exception is None
    assert "accepted REJECT  rate_unit" in done.stdout
    assert done.stdout.rstrip().endswith("in the way of an answer: nothing")
    (log,) = json.loads((tmp_path / "r.json").read_text())["logs"]
    (finding,) = [f for f in log["findings"] if f["code"] == "rate_unit"]
    assert (finding["accepted"], finding["severity"], log["outcome"] != "rejected") == (True, "reject", True)
    assert log["usable"]


def test_an_unknown_code_is_usage_and_names_the_nearest(table, tmp_path):
    path = written(tmp_path / "a.parquet", table)
    for command in (check_command, compare_command, locate_command, diagnose_command):
        arguments = (path,) if command is check_command else (VEHICLE, path)
        done = run(command, *arguments, "--accept", "rate_units")
        assert isinstance(done.exception, UsageError)
        assert "rate_unit" in str(done.exception).split("expected")[1]
    assert isinstance(run(check_command, path, "--accept", "unreadable").exception, UsageError)


def test_a_code_that_did_not_occur_is_a_line_and_no_error(table, tmp_path):
    path = written(tmp_path / "a.parquet", table)
    for command, arguments in ((check_command, (path,)), (compare_command, (VEHICLE, path))):
        done = run(command, *arguments, "--accept", "rate_unit,gaps", "--accept", "copy")
        assert done.exception is None
        assert "--accept rate_unit: no such finding here" in done.stderr
        assert "--accept copy: no such finding here" in done.stderr


def test_a_flight_s_metadata_may_accept_too(table, tmp_path):
    path = written(tmp_path / "a.csv", in_degrees(table), accept=["rate_unit"])
    assert "accept" in (tmp_path / "a.meta.yaml").read_text()
    assert "accepted REJECT  rate_unit" in run(check_command, path).stdout
    done = run(compare_command, VEHICLE, path, "--json", tmp_path / "c.json")
    assert done.exception is None
    (entry,) = json.loads((tmp_path / "c.json").read_text())["accepted"]
    assert (entry["code"], entry["path"]) == ("rate_unit", str(path))
    wrong = written(tmp_path / "b.csv", in_degrees(table), accept="rate_unit")
    done = run(compare_command, VEHICLE, wrong)
    assert isinstance(done.exception, InputError)
    assert "accept 'rate_unit' in the metadata; expected a list of codes" in str(done.exception)


@pytest.mark.long
def test_all_commands_reject_the_same_flight_with_the_same_line(table, other, tmp_path):
    bad, good = written(tmp_path / "bad.parquet", in_degrees(table)), written(tmp_path / "good.parquet", other)
    calls = {
        "check": (check_command, ("--vehicle", VEHICLE, bad)),
        **{name: (command, (VEHICLE, bad)) for name, command in QUIET.items()},
        "add": (add_command, (VEHICLE, "linear_drag", "--fit", bad, "-o", tmp_path / "m.yaml")),
    }
    said = {}
    for name, (command, arguments) in calls.items():
        done = run(command, *arguments)
        assert getattr(done.exception, "exit_status", getattr(done.exception, "code", None)) == 3
        if name == "check":
            assert f"rejected: {bad} (rate_unit)\n" in done.stderr
        else:
            assert "rejected" not in done.stderr  # the only flight: one line, which the command ends with
            said[name] = str(done.exception)
    (line,) = set(said.values())
    assert line.startswith(f"{bad}: angular velocity")
    assert line.endswith("; or overrule it: --accept rate_unit.")
    assert f"infotraj import {bad} --fix -o NEW.parquet (or --set rate.scale=" in line
    assert not (tmp_path / "m.yaml").exists()
    done = run(compare_command, VEHICLE, bad, good, "--skip-rejected", "--json", tmp_path / "c.json")
    assert done.exception is None
    assert [f["path"] for f in json.loads((tmp_path / "c.json").read_text())["flights"]] == [str(good)]


@pytest.mark.long
def test_what_was_accepted_is_in_the_provenance_of_every_answer(table, other, tmp_path):
    paths = [written(tmp_path / "a.parquet", table), written(tmp_path / "b.parquet", table)]
    assert "holds the same numbers as" in run(compare_command, VEHICLE, *paths).stderr
    for name, command in QUIET.items():
        out = tmp_path / f"{name}.json"
        more = ("--save-model", tmp_path / "found.yaml") if name == "diagnose" else ()
        done = run(command, VEHICLE, *paths, "--accept", "copy", "--json", out, *more)
        assert done.exception is None, done.stderr
        (entry,) = json.loads(out.read_text())["accepted"]
        assert (entry["code"], entry["path"]) == ("copy", str(paths[1]))
        assert f"accepted copy in {paths[1]}" in done.stdout
    arguments = (VEHICLE, "linear_drag", "--fit", paths[0], "--fit", paths[1], "-o", tmp_path / "added.yaml")
    assert run(add_command, *arguments, "--accept", "copy").exception is None
    for name in ("found.yaml", "added.yaml"):
        _, content = read_model(tmp_path / name)
        assert [a.code for a in content.provenance.accepted] == ["copy"]


def test_an_accepted_cut_drops_no_rows(table):
    stuck = table.copy()
    rows = slice(400, 900)
    stuck.iloc[rows, stuck.columns.get_indexer(["wx", "wy", "wz"])] = table.loc[400, ["wx", "wy", "wz"]].to_numpy()
    vehicle = load_vehicle(VEHICLE)
    flight = Flight(stuck, {"source": "stuck"})
    found = [f for f in examine(flight, vehicle).findings if f.drops]
    codes = sorted({f.code for f in found})
    assert codes
    clean = admitted(flight, examine(flight, vehicle))
    assert np.isnan(clean.get("wx")[450:850]).all()
    taken = accepting(flight, codes)
    check = examine(taken, vehicle)
    assert check.outcome in ("passed", "warning")
    assert not any(f.drops for f in check.findings)
    kept = admitted(taken, check)
    np.testing.assert_array_equal(kept.get("wx"), flight.get("wx"))
    assert {entry["code"] for entry in kept.meta["accepted"]} == set(codes)


def test_only_the_part_that_is_used_is_checked(table, tmp_path):
    spoiled = table.copy()
    late = spoiled["t"] > 5.0
    spoiled.loc[late, ["wx", "wy", "wz"]] = np.random.default_rng(0).normal(0, 900, (late.sum(), 3))
    path = written(tmp_path / "a.parquet", spoiled)
    assert isinstance(run(compare_command, VEHICLE, path).exception, InputError)
    done = run(compare_command, VEHICLE, path, "--to", "5")
    assert done.exception is None, done.stderr
    done = run(compare_command, VEHICLE, path, "--from", "70")
    assert isinstance(done.exception, InputError)
    assert str(done.exception).startswith(f"{path}: 0 rows")


def test_a_check_is_remembered_until_something_that_it_depends_on_changes(table, monkeypatch, tmp_path):
    monkeypatch.setenv("INFOTRAJ_CACHE", str(tmp_path))
    vehicle = load_vehicle(VEHICLE)
    calls = []

    def counted(*asked):
        calls.append(1)
        return examine(*asked)

    monkeypatch.setattr(admission, "examine", counted)
    flight = Flight(in_degrees(table), {"source": "a"})
    first = checked([flight], vehicle)[0]
    again = checked([accepting(flight, ["rate_unit"])], vehicle)[0]
    assert len(calls) == 1
    assert [f.code for f in again.findings if not f.accepted] == [
        f.code for f in first.findings if f.code != "rate_unit"
    ]
    assert (first.outcome, again.outcome == "rejected") == ("rejected", False)
    assert first.usable == []
    assert again.usable
    checked([flight], vehicle.model_copy(update={"mass": 2.0 * vehicle.mass}))
    checked([Flight(flight.table, {**flight.meta, "derived": ["vx"]})], vehicle)
    checked([Flight(flight.table * 1.001, flight.meta)], vehicle)
    assert len(calls) == 4
    for entry in (tmp_path / "checks").iterdir():
        entry.write_bytes(b"damaged")
    checked([flight], vehicle)
    assert len(calls) == 5
