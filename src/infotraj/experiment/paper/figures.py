"""The paper's figures and Table I from the tables and flights of the experiment."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from infotraj.flight import ATTITUDE, Flight, read_flight
from infotraj.plots import correlation, cost, learning_curve, phase, pool, sphere, table_1
from infotraj.rotations import to_euler
from infotraj.trajectories.reference import read_reference

AXES = ("x", "y", "z")


def figure_2(*, table: Path, pdf: Path, png: Path) -> None:
    """Cost against error."""
    correlation.figure_2(pd.read_csv(table), pdf, png)


def figure_3(*, reference: Path, pdf: Path, png: Path, **flown: Path) -> None:
    """The body vector of the task, flown with the largest model of each source (name: flight)."""
    # motion capture is slower than the table's rows, so some hold no pose
    attitudes = {name: read_flight(path).table[list(ATTITUDE)].dropna().to_numpy() for name, path in flown.items()}
    sphere.figure_3(read_reference(reference).attitude, attitudes, pdf, png)


def figure_4(*, table: Path, pdf: Path, png: Path) -> None:
    """Tracking error of the task against the number of points."""
    rows = pd.read_csv(table)
    used = (rows["reference"] == "task") & (rows["source"] != "none")
    learning_curve.figure_4(rows[used], pdf, png)


def figure_5(*, task: Path, modified: Path, pdf: Path, png: Path) -> None:
    """Angle against commanded torque, of the task and of the modified task."""
    phase.figure_5(_phase(read_flight(task)), _phase(read_flight(modified)), pdf, png)


def _phase(flight: Flight) -> pd.DataFrame:
    angles = np.degrees(to_euler(flight.get(*ATTITUDE)))
    torque = flight.get("cmd_tx", "cmd_ty")
    rows = pd.DataFrame({"roll": angles[:, 0], "pitch": angles[:, 1], "tx": torque[:, 0], "ty": torque[:, 1]})
    return rows.dropna()


def reductions(errors: pd.DataFrame, points: int) -> pd.DataFrame:
    """A row a run, source and axis: reduction (%) of the modified task's error against no learning (Table I)."""
    rows = errors[errors["reference"] == "modified"].set_index(["plant", "seed"])
    without = rows[rows["source"] == "none"]
    parts = []
    for source in [name for name in table_1.NAMES if (rows["source"] == name).any()]:
        learned = rows[(rows["source"] == source) & (rows["points"] == points)]
        for axis in AXES:
            reduction = 100.0 * (1.0 - learned[f"error_{axis}"] / without[f"error_{axis}"])
            parts.append(reduction.rename("reduction").reset_index().assign(source=source, axis=axis))
    return pd.concat(parts, ignore_index=True)


def write_table_1(*, table: Path, points: int, csv: Path, markdown: Path, tex: Path, png: Path) -> None:
    """Table I for the models with so many points in all."""
    rows = reductions(pd.read_csv(table), points)
    table_1.table_1(rows, csv=csv, markdown=markdown, tex=tex, png=png)


def figure_costs(*, table: Path, pdf: Path, png: Path) -> None:
    """The cost of all candidates of a round."""
    cost.figure_costs(pd.read_csv(table), pdf, png)


def figure_pool(*, table: Path, pdf: Path, png: Path) -> None:
    """Cost against error over the recorded real flights, and the choice against the alternatives."""
    pool.figure_pool(pd.read_csv(table), pdf, png)
