"""`infotraj import` as a command: what it prints, writes and returns; and the documented example."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner
from flights_made import made_flight
from writers_bag import write_bag1

from infotraj.errors import UsageError
from infotraj.flight import read_flight
from infotraj.importing import import_log, load_mapping, shipped
from infotraj.importing.command import import_command

GOOD = made_flight(2.0)
DOCS = Path(__file__).parents[2] / "docs" / "import.md"


def test_explain_prints_and_writes_nothing(tmp_path: Path) -> None:
    path = write_bag1(GOOD, tmp_path / "a.bag")
    result = CliRunner().invoke(import_command, [str(path), "--explain"])
    assert result.exit_code == 0
    assert re.search(r"velocity +/hummingbird/odometry +twist.twist.linear.x .* m/s +body \(ENU/FLU\)", result.stdout)
    assert "- reference_position: needed for tracking" in result.stdout
    assert result.stderr == ""
    assert [p.name for p in tmp_path.iterdir()] == ["a.bag"]


def test_explain_of_an_unknown_layout_lists_what_is_there(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("stunde,hoehe\n0,1\n1,2\n")
    result = CliRunner().invoke(import_command, [str(tmp_path / "a.csv"), "--explain"])
    assert result.exit_code == 3
    assert "columns: stunde, hoehe" in result.stdout
    assert "mapping flight_table does not fit; it requires t" in result.stdout


def test_several_logs_with_rejected_ones(tmp_path: Path) -> None:
    good = write_bag1(GOOD, tmp_path / "good.bag")
    (tmp_path / "bad.bag").write_bytes(b"#ROSBAG V2.0\n")
    (tmp_path / "worse.ulg").write_bytes(b"")
    logs = [str(tmp_path / "bad.bag"), str(good), str(tmp_path / "worse.ulg")]
    out = tmp_path / "out"
    for extra, status in ((["--json", str(tmp_path / "r.json")], 3), (["--skip-rejected"], 0)):
        result = CliRunner().invoke(import_command, [*logs, "-o", str(out), *extra])
        assert result.exit_code == status
        assert sum(line.startswith("rejected: ") for line in result.stderr.splitlines()) == 2
        assert [p.name for p in out.iterdir()] == ["good.parquet"]
        assert f"next: infotraj check {out}/good.parquet" in result.stderr
    report = json.loads((tmp_path / "r.json").read_text())
    assert [Path(r["path"]).name for r in report["rejected"]] == ["bad.bag", "worse.ulg"]
    assert report["flights"][0]["rows"] == len(GOOD.table)
    assert "airborne" not in report["flights"][0]["missing"]


def test_a_folder_for_one_log_ends_in_a_slash_and_never_holds_the_log_itself(tmp_path: Path) -> None:
    GOOD.write(tmp_path / "a.parquet")
    for place, said in ((str(tmp_path / "new"), f"-o {tmp_path / 'new'}/"), (f"{tmp_path}/", "is a log that is read")):
        result = CliRunner().invoke(import_command, [str(tmp_path / "a.parquet"), "-o", place])
        assert isinstance(result.exception, UsageError)
        assert said in str(result.exception)
    assert [p.name for p in tmp_path.iterdir()] == ["a.parquet"]


def test_saved_mapping_gives_the_same_table(tmp_path: Path) -> None:
    path = write_bag1(GOOD, tmp_path / "a.bag")
    saved = tmp_path / "m.yaml"
    first = CliRunner().invoke(
        import_command, [str(path), "-o", str(tmp_path / "a.csv"), "--save-mapping", str(saved), "-q"]
    )
    assert (first.exit_code, first.stdout) == (0, "")
    assert first.stderr == f"next: infotraj check {tmp_path / 'a.csv'}\n"
    again = import_log(path, saved)
    assert again.table.equals(read_flight(tmp_path / "a.csv").table)
    assert again.meta["mapping_sha256"] == read_flight(tmp_path / "a.csv").meta["mapping_sha256"]


def test_shipped_mappings_survive_yaml() -> None:
    for name, mapping in shipped().items():
        assert load_mapping(name) is mapping
        text = yaml.safe_dump(mapping.model_dump(mode="json", exclude_defaults=True))
        assert type(mapping).model_validate(yaml.safe_load(text)) == mapping


def test_documented_units_and_mappings_are_the_known_ones() -> None:
    from infotraj.importing.channels import CHANNELS
    from infotraj.importing.units import UNITS

    text = DOCS.read_text()
    for units in UNITS.values():
        for unit in units:
            assert unit == "1" or re.search(rf"[|,;] {re.escape(unit)}[ ,;|(]", text), unit
    assert all(f"`{name}`" in text for name in shipped())
    assert all(name in text for name in CHANNELS)


def test_documented_example_runs() -> None:
    from infotraj.datasets.location import find_dataset, how_to_get

    if find_dataset("arpl_crazyflie") is None:
        pytest.skip(how_to_get("arpl_crazyflie"))
    code = re.search(r"```python\n(.*?)```", DOCS.read_text(), re.DOTALL)[1]  # type: ignore[index]
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    for comment in re.findall(r"#  ?(crazyflie \[.*|\(30296.*)", code):
        assert comment.strip() in result.stdout


def test_importing_the_package_does_not_load_the_readers() -> None:
    code = "import sys, infotraj.importing, infotraj.importing.command; print({'rosbags', 'pyulog'} & set(sys.modules))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert result.stdout.strip() == "set()"
