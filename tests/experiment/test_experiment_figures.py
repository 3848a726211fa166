"""From the experiment's tables and flights to what the figures, Table I and the claims are drawn from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from infotraj import rotations
from infotraj.experiment.paper import claiming, figures
from infotraj.experiment.real.pool import summarise_pool
from infotraj.flight import ATTITUDE, Flight
from infotraj.plots import phase, sphere

SIZES = (40, 100)


def errors(informative: float, task: float) -> pd.DataFrame:
    """Tables of two plants with six seeds each: the given errors at each size, 1 without learning, a little spread."""
    rng = np.random.default_rng(0)
    rows = []
    for plant in ("a", "b"):
        for seed in range(6):
            cases = [("task", "none", 0, 1.0), ("modified", "none", 0, 1.0), ("task", "prior", 20, 0.6)]
            for source, value in (("task", task), ("random", task), ("paper", task), ("informative", informative)):
                cases += [("task", source, points, value) for points in SIZES] + [("modified", source, 100, value)]
            for reference, source, points, value in cases:
                error = value * rng.uniform(0.99, 1.01)
                row = {"plant": plant, "seed": seed, "reference": reference, "source": source, "points": points}
                axes = {f"error_{axis}": value for axis in "xyz"}
                rows.append({**row, "kind": "tracking", "error": error, "error_std": error / 2, **axes})
    return pd.DataFrame(rows)


def correlated(sign: float) -> pd.DataFrame:
    rows = []
    for plant in ("a", "b"):
        for seed in range(3):
            for k in range(-1, 10):
                cost = 5.0 if k < 0 else float(k)
                error = 1.0 + 0.1 * sign * cost
                rows.append({"plant": plant, "seed": seed, "candidate": k, "cost": cost, "error": error})
    return pd.DataFrame(rows).assign(error_std=0.1)


def claims(tmp_path: Path, tracking: pd.DataFrame, correlation: pd.DataFrame) -> pd.Series:
    tracking.to_csv(tmp_path / "tracking.csv", index=False)
    correlation.to_csv(tmp_path / "correlation.csv", index=False)
    inputs = {"tracking": tmp_path / "tracking.csv", "correlation": tmp_path / "correlation.csv"}
    outputs = {"table": tmp_path / "c.csv", "markdown": tmp_path / "c.md", "png": tmp_path / "c.png"}
    claiming.write_claims(**inputs, pool=None, points=100, **outputs)
    return pd.read_csv(tmp_path / "c.csv").set_index("claim")


def test_reductions_compare_with_the_same_run_without_learning():
    table = figures.reductions(errors(0.3, 0.5), 100)
    assert len(table) == 2 * 6 * 4 * 3
    means = table.groupby("source")["reduction"].mean()
    assert means["informative"] == pytest.approx(70.0)
    assert means["task"] == pytest.approx(50.0)


def test_all_claims_hold_where_the_numbers_say_so(tmp_path):
    found = claims(tmp_path, errors(0.3, 0.5), correlated(1.0))
    control = found.index.str.contains("task's flight, (?:a random|the choice)")
    assert (found.loc[~control, "holds"] == "yes").all()
    assert (found.loc[control, "holds"] == "open").all(), "the controls were made no better than the task"
    gain = "Fig. 4: average gain over the task's flight, informative"
    assert found.loc[f"{gain} [%]", "ours"] == pytest.approx(40.0, abs=1.0)
    assert f"{gain}, a [%]" not in found.index, "the plants agree"
    axis = found.loc["Table I: reduction about y, informative minus the task's flight [points of %]"]
    assert axis["ours"] == pytest.approx(20.0)
    assert float(axis["paper"]) == 16.2
    assert found.filter(like="rank correlation", axis=0)["ours"].item() == pytest.approx(1.0)


def test_no_claim_of_a_gain_holds_where_there_is_none(tmp_path):
    found = claims(tmp_path, errors(0.9, 0.9), correlated(-1.0))
    holds = found["holds"].drop(found.filter(like="teaches more", axis=0).index)
    assert not (holds == "yes").any()
    assert holds.filter(like="rank correlation").item() == "no"
    assert holds["Fig. 4: error, informative minus a random candidate, mean over the sizes [rad/s^2]"] == "open"
    assert found.filter(like="rank correlation", axis=0)["ours"].item() == pytest.approx(-1.0)


def test_plants_that_differ_are_told_apart(tmp_path):
    table = errors(0.3, 0.5)
    worse = (table["plant"] == "b") & (table["source"] == "informative")
    found = claims(tmp_path, table.assign(error=table["error"].where(~worse, 0.6)), correlated(1.0))
    gain = "Fig. 4: average gain over the task's flight, informative"
    assert found.loc[f"{gain}, a [%]", "holds"] == "yes"
    assert found.loc[f"{gain}, b [%]", "holds"] == "no"
    assert found.loc[f"{gain}, b [%]", "ours"] == pytest.approx(-20.0, abs=1.0)


def test_the_papers_cost_is_judged_beside_ours(tmp_path):
    table = correlated(1.0)
    found = claims(tmp_path, errors(0.3, 0.5), table.assign(cost_paper=-table["cost"]))
    assert found.filter(like="correlation of our cost", axis=0)["holds"].item() == "yes"
    assert found.filter(like="correlation of the paper's cost", axis=0)["holds"].item() == "no"


def test_the_pools_claim_stands_beside_that_without_the_tasks_own_trajectory(tmp_path):
    rows = []
    for task in ("B1_a_fast_rep1", "B2_b_fast_rep1"):
        own = task.replace("rep1", "rep2")
        for prior in ("p", "q"):
            for candidate, cost, error in ((own, 1.0, 0.1), ("B3_c_fast_rep1", 2.0, 0.3), ("B4_d_fast_rep1", 3.0, 0.2)):
                rows.append((task, prior, candidate, 0, cost, error, int(candidate == own)))
    columns = ["task", "prior", "candidate", "seed", "cost", "error", "chosen"]
    pd.DataFrame(rows, columns=columns).to_csv(tmp_path / "flights.csv", index=False)
    summarise_pool(table=tmp_path / "flights.csv", summary=tmp_path / "s.csv", markdown=tmp_path / "s.md")
    errors(0.3, 0.5).to_csv(tmp_path / "t.csv", index=False)
    correlated(1.0).to_csv(tmp_path / "k.csv", index=False)
    outputs = {"table": tmp_path / "c.csv", "markdown": tmp_path / "c.md", "png": tmp_path / "c.png"}
    inputs = {"tracking": tmp_path / "t.csv", "correlation": tmp_path / "k.csv", "pool": tmp_path / "s.csv"}
    claiming.write_claims(**inputs, points=100, **outputs)
    found = pd.read_csv(tmp_path / "c.csv").set_index("claim").filter(like="minus random choice", axis=0)
    assert found["holds"].tolist() == ["yes", "no"], "the flight of the same trajectory was all the cost had found"
    assert found["ours"].tolist() == pytest.approx([-0.1, 0.05])


def test_without_a_pool_the_claims_leave_it_out(tmp_path):
    found = claims(tmp_path, errors(0.3, 0.5), correlated(1.0))
    assert not found.index.str.contains("Real flights").any()


def flight(tmp_path: Path) -> Path:
    """A flight whose pose is there in every second row only."""
    t = 0.005 * np.arange(400)
    attitude = rotations.from_euler(0.3 * np.sin(t), 0.2 * np.sin(2 * t), 0 * t)
    attitude[1::2] = np.nan
    table = pd.DataFrame({"t": t, **dict(zip(ATTITUDE, attitude.T, strict=True)), "cmd_tx": np.cos(t), "cmd_ty": t})
    Flight(table).write(tmp_path / "flight.parquet")
    return tmp_path / "flight.parquet"


def test_rows_without_a_pose_do_not_tear_the_curves(tmp_path, monkeypatch):
    seen = {}
    monkeypatch.setattr(sphere, "figure_3", lambda reference, flown, *paths: seen.update(sphere=flown.values()))
    monkeypatch.setattr(figures, "read_reference", lambda path: type("R", (), {"attitude": None}))
    monkeypatch.setattr(phase, "figure_5", lambda *tables: seen.update(phase=tables[:2]))
    path = flight(tmp_path)
    figures.figure_3(reference="r", pdf="p", png="p", informative=path, task=path)
    figures.figure_5(task=path, modified=path, pdf="p", png="p")
    for curve in (*seen["sphere"], *(table.to_numpy() for table in seen["phase"])):
        assert len(curve) == 200
        assert np.isfinite(curve).all()
