"""`infotraj check` at the command line: outcomes, exit status, JSON, copies, raw logs."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from check_flights import SPOILED, Q, V, simulated
from click.testing import CliRunner

from infotraj.checking.command import check_command
from infotraj.datasets.location import find_dataset
from infotraj.flight import read_flight
from infotraj.importing.command import import_command
from infotraj.rotations import from_euler, to_euler

FLIGHT = simulated(8, duration=12.0)
QUAD = Path(__file__).parents[2] / "examples" / "quad"
NANOBENCH, CRAZYFLIE = find_dataset("nanobench"), find_dataset("arpl_crazyflie")
with_nanobench = pytest.mark.skipif(NANOBENCH is None, reason="INFOTRAJ_DATA names no folder with nanobench")


def run(*arguments):
    result = CliRunner().invoke(check_command, [str(a) for a in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


def test_a_good_and_a_bad_flight(tmp_path):
    FLIGHT.write(tmp_path / "good.parquet")
    SPOILED["rates in deg/s"][0](FLIGHT).write(tmp_path / "bad.csv")
    result = run(tmp_path / "good.parquet", tmp_path / "bad.csv", "--json", tmp_path / "r.json")
    assert result.exit_code == 3
    assert "good.parquet: passed" in result.stdout
    assert "rate_unit" in result.stdout
    assert f"rejected: {tmp_path / 'bad.csv'} (rate_unit)\n" in result.stderr
    assert result.output.count("--set rate.scale") == 1
    assert f"next: infotraj import {tmp_path / 'bad.csv'} --fix -o NEW.parquet\n" in run(tmp_path / "bad.csv").stderr
    assert "next: infotraj compare MODEL" in result.stderr
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["rejected"] == [str(tmp_path / "bad.csv")]
    good, bad = report["logs"]
    assert (good["outcome"], bad["outcome"]) == ("passed", "rejected")
    assert bad["usable"] == []
    assert set(bad["findings"][0]) == {
        "code", "severity", "what", "accepted", "drops_rows", "where", "channels", "sure", "effect", "remedy",
        "settings", "values",
    }  # fmt: skip
    assert report["coverage"]["wx"]["rms"] == pytest.approx(good["coverage"]["wx"]["rms"])
    assert run(tmp_path / "good.parquet", tmp_path / "bad.csv", "--skip-rejected", "-q").exit_code == 0
    assert not list(tmp_path.glob(".*.part"))


def test_the_next_line_of_a_log_makes_the_folder_that_it_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    FLIGHT.write(tmp_path / "log.parquet")
    said = run("log.parquet", "--set", "battery.scale=1").stderr
    words = re.search(r"^next: infotraj import (.*)$", said, re.M)[1].split()
    assert words == ["log.parquet", "--set", "battery.scale=1", "-o", "flights/"]
    assert CliRunner().invoke(import_command, words, catch_exceptions=False).exit_code == 0
    assert (tmp_path / "flights" / "log.parquet").is_file()


@pytest.mark.parametrize("way", ["--fix", "--set"])
def test_a_quaternion_whose_pitch_has_the_other_sign_is_mended_by_the_command_that_is_told(way, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    roll, pitch, yaw = to_euler(FLIGHT.table[Q].to_numpy()).T
    turned = dict(zip(Q, from_euler(roll, -pitch, yaw).T, strict=True))
    FLIGHT.table.assign(**turned).to_csv("log.csv", index=False)
    told = run("log.csv")
    assert told.exit_code == 3
    assert "attitude_sign" in told.stdout
    said = " ".join(told.stdout.split())
    remedy = r"do: infotraj import (log.csv --fix -o NEW.parquet) \(or (--set [^)]*)\)"
    command, settings = re.search(remedy, said).groups()
    words = shlex.split(command if way == "--fix" else f"log.csv {settings} -o NEW.parquet")
    assert CliRunner().invoke(import_command, words, catch_exceptions=False).exit_code == 0
    assert run("NEW.parquet").exit_code == 0
    np.testing.assert_allclose(read_flight("NEW.parquet").table[Q], FLIGHT.table[Q], atol=1e-6)


def test_copies_in_bytes_and_in_numbers(tmp_path):
    FLIGHT.write(tmp_path / "a.parquet")
    FLIGHT.write(tmp_path / "b.csv")
    (tmp_path / "c.parquet").write_bytes((tmp_path / "a.parquet").read_bytes())
    result = run(tmp_path / "a.parquet", tmp_path / "b.csv", tmp_path / "c.parquet")
    assert result.exit_code == 3
    assert f"holds the same numbers as {tmp_path / 'a.parquet'}" in result.stdout
    assert f"byte-identical to {tmp_path / 'a.parquet'}" in result.stdout


def test_a_csv_whose_time_runs_back_is_reported_not_refused(tmp_path):
    table = FLIGHT.table.copy()
    table.loc[800:, "t"] -= 4.0
    table.to_csv(tmp_path / "back.csv", index=False)
    result = run(tmp_path / "back.csv")
    assert result.exit_code == 3
    assert "time_backwards" in result.stdout


@pytest.mark.parametrize(("unit", "times"), [("ms", 1e3), ("us", 1e6)])
def test_another_unit_of_time_comes_with_the_command_that_mends_it(tmp_path, unit, times):
    log, new = tmp_path / "log.csv", tmp_path / "NEW.parquet"
    table = FLIGHT.table.drop(columns=V)
    table.assign(t=table["t"] * times).to_csv(log, index=False)
    result = run(log)
    assert result.exit_code == 3
    said = re.search(rf"infotraj import (\S+) --fix -o NEW.parquet \(or (--set time.unit={unit})\)", result.stdout)
    if unit == "us":
        said = re.search(r"infotraj import (\S+) (--set time.unit=us) -o NEW.parquet", result.stdout)
    assert "not_excited" not in result.stdout  # speeds that were derived by the wrong time are no slow flight
    done = CliRunner().invoke(import_command, [said[1], *said[2].split(), "-o", str(new)])
    assert done.exit_code == 0, done.output
    assert run(new).exit_code == 0
    assert read_flight(new).t == pytest.approx(FLIGHT.t)


def test_the_unit_of_time_is_said_in_terms_of_the_mapping(tmp_path):
    FLIGHT.table.assign(t=1e6 * FLIGHT.t).to_csv(tmp_path / "log.csv", index=False)
    result = run(tmp_path / "log.csv", "--set", "time.unit=ms")
    assert "(or --set time.unit=us)" in result.stdout


@pytest.mark.parametrize("content", ["", "hello\n", "t,px\n1,2\n", "t,px\n0,0\n1,x\n"])
def test_what_is_no_log_is_rejected_in_one_line(tmp_path, content):
    (tmp_path / "x.csv").write_text(content)
    result = run(tmp_path / "x.csv", "-q")
    assert result.exit_code == 3
    assert "unreadable" in result.stdout
    assert "Traceback" not in result.output


def test_what_only_a_vehicle_shows_is_not_left_to_fix(tmp_path):
    rotors = [f"cmd_rotor_{k}" for k in range(4)]
    log, new = tmp_path / "rpm.csv", tmp_path / "NEW.parquet"
    table = read_flight(QUAD / "flight_0.parquet").table
    table.assign(**table[rotors] * 30 / np.pi).to_csv(log, index=False)
    result = run(log, "--vehicle", QUAD / "vehicle.yaml")
    assert "--fix" not in result.output
    said = re.search(r"do: infotraj import (\S+ --set \S+ -o) NEW.parquet; or correct mass", result.stdout)
    done = CliRunner().invoke(import_command, [*said[1].split(), str(new)])
    assert done.exit_code == 0, done.output
    assert run(new, "--vehicle", QUAD / "vehicle.yaml").exit_code == 0


def test_a_cut_log_names_itself_once_and_what_to_do_works(tmp_path):
    log, new = tmp_path / "log.csv", tmp_path / "NEW.parquet"
    FLIGHT.table.to_csv(log, index=False)
    log.write_text(log.read_text()[:-30])
    result = run(log)
    (finding,) = [line for line in result.stdout.splitlines() if "unreadable: " in line and "REJECT" in line]
    assert re.search(r"unreadable: the last row has \d+ fields, expected \d+$", finding)
    said = re.search(r"do: .*infotraj import (\S+ --allow-damaged -o) NEW.parquet$", result.stdout, re.M)
    assert "--accept" not in result.output
    assert "next:" not in result.stderr
    done = CliRunner().invoke(import_command, [*said[1].split(), str(new)])
    assert done.exit_code == 0, done.output
    assert run(new).exit_code == 0
    (tmp_path / "empty.csv").write_text("")
    assert "REJECT  unreadable: 0 bytes, expected a bag" in run(tmp_path / "empty.csv").stdout


def test_from_and_to(tmp_path):
    FLIGHT.write(tmp_path / "a.parquet")
    run(tmp_path / "a.parquet", "--from", "5", "--to", "11", "--json", tmp_path / "r.json")
    log = json.loads((tmp_path / "r.json").read_text())["logs"][0]
    assert 5 <= log["start"] < 5.1
    assert 10.9 < log["stop"] < 11


@with_nanobench
@pytest.mark.parametrize(
    ("name", "outcome", "reason"),
    [
        ("B2_circle_fast_rep1", "passed", None),
        pytest.param("B2_circle_medium_rep1", "passed", None, marks=pytest.mark.long),
        pytest.param("B6_linear_ramp_rep2", "passed", None, marks=pytest.mark.long),
        ("B6_linear_ramp_rep1", "passed with a warning", "low_flight"),
        ("B7_oval_slow_rep1", "rejected", "no_flight"),
        ("B2_circle_medium_rep3", "cut", "31.28"),
        pytest.param("B9_trefoil_fast_rep5", "cut", "19.20", marks=pytest.mark.long),
    ],
)
def test_nanobench_files_come_out_for_their_reasons(name, outcome, reason):
    result = run(NANOBENCH / f"{name}.parquet", "-q")
    assert f"{name}.parquet: {outcome} (" in result.stdout
    assert reason is None or reason in result.stdout
    assert result.exit_code == (3 if outcome == "rejected" else 0)


@with_nanobench
def test_what_nanobenchs_readme_gets_wrong_is_found():
    result = run(NANOBENCH / "B9_trefoil_fast_rep4.parquet", "--mapping", "nanobench_readme")
    assert result.exit_code == 3
    assert "rate_frame" in result.stdout
    assert "stream vicon_angles (not in the table): the attitude comes from angles in radians" in result.stdout
    assert "imu_clock_varies: stream onboard" in result.stdout


@pytest.mark.skipif(CRAZYFLIE is None, reason="INFOTRAJ_DATA names no folder with arpl_crazyflie")
def test_a_crazyflie_log_without_pose_says_what_it_cannot_answer():
    result = run(CRAZYFLIE / "log16")
    assert result.exit_code == 0
    assert "cannot answer: rollouts" in result.stdout
