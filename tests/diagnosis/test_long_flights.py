"""Of long flights a part is used, and what it is, is said."""

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from infotraj.cli import cli
from infotraj.diagnosis.report.parts import parts
from infotraj.flight import Flight


def flight(seconds, lively, rate=20.0, name="long.parquet"):
    """It hovers, but for where it is lively (s): there it turns to and fro. One second of it lands hard."""
    t = np.arange(0.0, seconds, 1.0 / rate)
    moves = (t >= lively[0]) & (t < lively[1])
    turn = np.where(moves, np.sin(2.0 * t), 0.0)
    turn[(t >= seconds - 1.0)] = 8.0 * np.sin(20.0 * t[t >= seconds - 1.0])
    still = np.zeros_like(t)
    return Flight(pd.DataFrame({"t": t, "wx": turn, "wy": still, "wz": still}), {"source": f"logs/{name}"})


def test_flights_that_are_short_together_are_used_whole():
    made = [flight(100.0, (10.0, 30.0)), flight(120.0, (10.0, 30.0))]
    used, said = parts(made, 220.0)
    assert used == made
    assert said == []


def test_of_a_long_flight_the_part_is_used_that_moves_most():
    (used,), (said,) = parts([flight(300.0, (200.0, 260.0))], 60.0)
    assert used.t[0] == pytest.approx(200.0, abs=1.0)
    assert used.t[-1] - used.t[0] == pytest.approx(60.0, abs=0.1)
    assert said.startswith("long.parquet: 60 of 300 s are used, from 200.0 s on")
    assert "--seconds" in said


def test_a_short_flight_is_used_whole_and_leaves_its_rest_to_the_long_one():
    made = [flight(20.0, (5.0, 10.0), name="short.parquet"), flight(300.0, (100.0, 200.0))]
    (short, long), said = parts(made, 100.0)
    assert short is made[0]
    assert long.t[-1] - long.t[0] == pytest.approx(80.0, abs=0.1)
    assert [line.split(":")[0] for line in said] == ["long.parquet"]


def test_the_part_lies_in_what_is_asked_about():
    (used,), _ = parts([flight(300.0, (200.0, 260.0))], 30.0, start=20.0, stop=120.0)
    assert used.t[0] >= 20.0
    assert used.t[-1] <= 120.0


def test_a_flight_without_any_motion_column_is_cut_where_it_begins():
    t = np.arange(0.0, 50.0, 0.1)
    made = Flight(pd.DataFrame({"t": t, "wx": np.full_like(t, np.nan), "wy": 0.0, "wz": 0.0}))
    (used,), _ = parts([made], 10.0)
    assert used.t[0] == 0.0


def test_the_commands_have_the_option():
    for command in ("diagnose", "report"):
        assert "--seconds" in CliRunner().invoke(cli, [command, "--help"]).output
