"""What surrounds a job: its log, the settings it may read, the tables it gathers, the flights it takes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from writers_bag import write_bag2

from infotraj import rotations
from infotraj.errors import InputError
from infotraj.experiment.common.job import Settings
from infotraj.experiment.common.tables import gather, write_table
from infotraj.experiment.paper.receiving import receive
from infotraj.flight import ATTITUDE, COMMANDED_WRENCH, POSITION, RATE, Flight, read_flight
from infotraj.trajectories.tasks import figure_eight


def in_a_job(tmp_path: Path, body: str) -> tuple[int, str, subprocess.CompletedProcess]:
    head = "import os, sys\nfrom infotraj.experiment.common.job import job\n"
    code = f"{head}with job(sys.argv[1], {{'seeds': 4}}) as settings:\n    {body}\n"
    log = tmp_path / "deep" / "job.log"
    done = subprocess.run([sys.executable, "-c", code, str(log)], capture_output=True, text=True)
    return done.returncode, log.read_text(), done


def test_all_output_goes_to_the_log_also_that_of_compiled_code(tmp_path):
    body = "print('one', settings.seeds); print('two', file=sys.stderr, flush=True); os.system('echo three')"
    status, log, done = in_a_job(tmp_path, body)
    assert status == 0
    assert {"one 4", "two", "three"} <= set(log.splitlines())
    assert done.stdout == done.stderr == ""


def test_a_users_error_is_one_line_and_its_exit_status(tmp_path):
    body = "from infotraj.errors import InputError; raise InputError('a.csv: no rows')"
    status, log, _ = in_a_job(tmp_path, body)
    assert status == 3
    assert log == "a.csv: no rows\n"


def test_a_defect_keeps_its_traceback_in_the_log(tmp_path):
    status, log, done = in_a_job(tmp_path, "1 / 0")
    assert status == 1
    assert log.startswith("Traceback")
    assert "ZeroDivisionError" in log
    assert done.stderr == ""


def test_a_job_reads_the_settings_that_its_rule_declares_and_no_other():
    settings = Settings({"seeds": 4, "learning": {"restarts": 1}})
    assert (settings.seeds, settings.learning.restarts) == (4, 1)
    with pytest.raises(AttributeError, match=r"'plants' is not declared; add it to the rule"):
        _ = settings.plants


def test_gathered_tables_keep_every_row_and_must_agree(tmp_path):
    paths = []
    for seed in range(3):
        paths.append(tmp_path / f"{seed}.csv")
        write_table(pd.DataFrame({"seed": [seed], "error": [0.1 * seed]}), paths[-1])
    gather(tables=paths, table=tmp_path / "all.csv")
    assert pd.read_csv(tmp_path / "all.csv")["seed"].tolist() == [0, 1, 2]
    write_table(pd.DataFrame({"seed": [9]}), paths[0])
    with pytest.raises(InputError, match=r"1\.csv: columns"):
        gather(tables=paths, table=tmp_path / "other.csv")
    assert not (tmp_path / "other.csv").exists()


@pytest.fixture
def asked(tmp_path: Path) -> Path:
    figure_eight(0.3, 4.0, 1, 0.01).write(tmp_path / "reference.csv")
    return tmp_path / "reference.csv"


def flown(path: Path, *, seconds: float = 6.0, offset: float = 0.0, without: str | None = None) -> None:
    t = np.arange(0.0, seconds, 0.01)
    columns = dict.fromkeys((*POSITION, *RATE, *COMMANDED_WRENCH), np.zeros(len(t)))
    columns |= dict(zip(ATTITUDE, rotations.from_euler(0 * t, 0 * t, 0 * t).T, strict=True))
    table = pd.DataFrame({"t": t, **columns}).assign(px=offset, pz=1.5)
    Flight(table.drop(columns=[without] if without else [])).write(path)


def take(tmp_path: Path, asked: Path, model: str | None = None) -> Path:
    target = tmp_path / "taken.parquet"
    receive(folder=tmp_path / "flights", name="prior", reference=asked, model=model, flight=target)
    return target


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_delivered_flight_is_taken(tmp_path, asked, suffix):
    flown(tmp_path / "flights" / f"prior{suffix}")
    assert len(read_flight(take(tmp_path, asked)).table) == 600


def test_a_log_is_taken_like_a_table(tmp_path, asked):
    """A ROS 2 bag with pose, rate and actuator commands, and none of our own columns."""
    t = np.arange(0.0, 6.0, 0.01)
    zero = dict.fromkeys((*POSITION, "vx", "vy", "vz", *RATE, "ax", "ay"), np.zeros(len(t)))
    columns = zero | {"qw": np.ones(len(t)), "qx": 0 * t, "qy": 0 * t, "qz": 0 * t, "az": 9.81 + 0 * t}
    columns |= {f"cmd_rotor_{i}": 677.0 + 0 * t for i in range(12)} | {f"cmd_tilt_{i}": 0 * t for i in range(6)}
    (tmp_path / "flights").mkdir()
    write_bag2(Flight(pd.DataFrame({"t": t, **columns}).assign(pz=1.5)), tmp_path / "flights" / "prior")
    taken = read_flight(take(tmp_path, asked))
    assert len(taken.table) >= 595
    np.testing.assert_allclose(taken.get("cmd_rotor_3")[10:-10], 677.0)


def test_a_flight_that_is_not_there_is_asked_for_by_name(tmp_path, asked):
    with pytest.raises(InputError, match=r"reference\.csv: no flight yet; .*flights/prior\.parquet or \.csv") as caught:
        take(tmp_path, asked)
    assert "\n" not in str(caught.value)
    assert "with no learned model" in str(caught.value)


def test_it_is_said_which_model_a_flight_is_to_be_flown_with(tmp_path, asked):
    with pytest.raises(InputError, match=r"Fly the reference with the learned model own/prior\.npz in the controller"):
        take(tmp_path, asked, "own/prior.npz")


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ({"seconds": 3.0}, "lasts 2.99 s; expected the 6.00 s"),
        ({"offset": 5.0}, "5.0 m from"),
        ({"without": "cmd_tx"}, "columns cmd_tx are missing"),
    ],
)
def test_a_wrong_flight_is_refused_in_one_line_and_nothing_is_written(tmp_path, asked, how, says):
    flown(tmp_path / "flights" / "prior.csv", **how)
    with pytest.raises(InputError) as caught:
        take(tmp_path, asked)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "taken.parquet").exists()


def test_two_files_for_one_flight_are_not_guessed_between(tmp_path, asked):
    flown(tmp_path / "flights" / "prior.csv")
    flown(tmp_path / "flights" / "prior.parquet")
    with pytest.raises(InputError, match=r"prior\.csv and .*prior\.parquet; expected one .* remove") as caught:
        take(tmp_path, asked)
    assert "Fly the reference" not in str(caught.value)
