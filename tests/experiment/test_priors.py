"""With and without the prior that knows physics: every arm is flown, and the page says what was found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from infotraj.experiment.common.config import Deviations, ExperimentConfig, FigureEight, Selection, read
from infotraj.experiment.paper import flying, references
from infotraj.experiment.paper.priors import NONE, PHYSICS, compare_priors
from infotraj.experiment.paper.priors_summary import comparisons, of_errors, summarise_priors

ARMS = [(NONE, NONE), (NONE, PHYSICS), (PHYSICS, PHYSICS)]


def a_table() -> pd.DataFrame:
    """Two plants of three runs: physics halves the error of the task's flight, and changes nothing of other flights."""
    rows = []
    for plant in ("a", "b"):
        for seed in range(3):
            key: dict[str, object] = {"plant": plant, "seed": seed}
            rows += [
                {**key, "flown": p, "learned": p, "source": "first", "points": 20, "reference": "task", "error": 0.4}
                for p in (NONE, PHYSICS)
            ]
            for flown, learned in ARMS:
                for source, error in (("task", 0.2), ("random", 0.3), ("informative", 0.15)):
                    factor = 0.5 if source == "task" and learned == PHYSICS else 1.0
                    for points, reference in ((40, "task"), (100, "task"), (100, "modified")):
                        told = {"points": points, "reference": reference, "error": factor * error + 0.01 * seed}
                        rows.append({**key, "flown": flown, "learned": learned, "source": source, **told})
    return pd.DataFrame(rows)


def test_differences_are_paired_and_gains_are_of_the_same_run():
    found = {name: interval for name, _, _, interval in comparisons(a_table())}
    task = found["the task's flight, same points: physics minus none"]
    assert (task.mean, task.low, task.high, task.runs) == pytest.approx((-0.1, -0.1, -0.1, 6))
    assert found["a random candidate, own flights: physics minus none"].mean == pytest.approx(0.0)
    assert found["first flight alone: physics minus none"].mean == pytest.approx(0.0)
    expected = np.mean([100.0 * (1.0 - (0.15 + x) / (0.2 + x)) for x in (0.0, 0.01, 0.02)])
    assert found["none: gain over the task's flight, the run's choice"].mean == pytest.approx(expected)
    assert found["physics: the run's choice minus the task's flight"].mean == pytest.approx(0.05)


def test_the_page(tmp_path):
    for plant, part in a_table().groupby("plant"):
        part.to_csv(tmp_path / f"{plant}.csv", index=False)
    outputs = {"table": tmp_path / "all.csv", "markdown": tmp_path / "all.md"}
    summarise_priors(tables=[tmp_path / "a.csv", tmp_path / "b.csv"], **outputs)
    page = outputs["markdown"].read_text()
    assert page.startswith("Runs: a 3, b 3.")
    assert "| none | physics | the task's flight |  | 0.110 (0.12) | 0.110 (0.12) | 0.110 (0.12) |" in page
    assert "| the task's flight, same points: physics minus none | -0.100 | -0.100 to -0.100 |" in page
    assert len(pd.read_csv(outputs["table"])) == len(a_table())
    assert of_errors(a_table()).count("\n") >= 12


def test_the_committed_study_is_of_plants_that_are_there():
    config = read("config/studies/priors.yaml")
    assert all(Path(f"config/plants/{plant}.yaml").exists() for plant in config.plants)
    assert config.learning.prior == "none", "the study sets both priors itself"


@pytest.mark.long
def test_every_arm_is_flown_with_as_many_points(tmp_path):
    config = ExperimentConfig(
        task=FigureEight(period=3.0, cycles=1),
        modified=FigureEight(amplitude_deg=30.0, period=3.0, cycles=1),
        added_points=(5,),
        prior_points=8,
        deviations=Deviations(max_angle_deg=10.0),
        selection=Selection(candidates=2, draws=1, task_draws=1, region_points=20),
    )
    paths = {name: tmp_path / f"{name}.csv" for name in ("task", "modified", "pitch")}
    references.write(config, **paths)
    flight = tmp_path / "first.parquet"
    flying.fly_reference(config, "omav_a", 0, "prior", reference=paths["task"], model=None, flight=flight)
    compare_priors(
        config, "omav_a", 0, task=paths["task"], modified=paths["modified"], flight=flight, table=tmp_path / "t.csv"
    )
    rows = pd.read_csv(tmp_path / "t.csv")
    assert len(rows) == 2 + len(ARMS) * 3 * 2
    assert set(rows["points"]) == {8, 13}
    assert np.isfinite(rows["error"]).all()
    task = rows[(rows["reference"] == "task") & (rows["source"] == "random")].set_index(["flown", "learned"])["error"]
    assert task[NONE, NONE] != task[NONE, PHYSICS]
