"""Each claim of the paper, and of the pool scenario, with the paper's number, ours with its interval, and whether ours
holds. The limits are those of the paper; nothing is rounded in our favour."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from infotraj.evaluation.intervals import bootstrap_mean
from infotraj.experiment.figures import AXES, reductions
from infotraj.experiment.tables import write_table
from infotraj.plots.claims import claims_table
from infotraj.plots.correlation import TASK, rank_correlations
from infotraj.plots.learning_curve import PAPER_GAIN, paired_gains
from infotraj.plots.table_1 import PAPER

LEAST_CORRELATION = 0.6  # what is asked of the cost as a predictor; the paper says "clear correspondence"


def write_claims(
    *, tracking: Path, correlation: Path, pool: Path | None, points: int, table: Path, markdown: Path, png: Path
) -> None:
    """Writes the claims as CSV, Markdown and a picture.

    points: those of the largest models (Table I); pool: the pool's summary, None without the data.
    """
    errors = pd.read_csv(tracking)
    rows = [*_learning_curve(errors), *_table_1(errors, points), *_correlation(pd.read_csv(correlation))]
    if pool is not None:
        rows += _pool(pd.read_csv(pool))
    claims = pd.DataFrame(rows)
    write_table(claims, table)
    claims_table(claims, markdown, png)


def _claim(claim: str, paper: object, ours: float, low: float, high: float, holds: bool) -> dict[str, Any]:
    return {"claim": claim, "paper": paper, "ours": ours, "low": low, "high": high, "holds": bool(holds)}


def _learning_curve(errors: pd.DataFrame) -> list[dict[str, Any]]:
    task = errors[errors["reference"] == "task"]
    rows = []
    for value, what in (("error", "error"), ("error_std", "spread of the error")):
        wide = task.pivot_table(index=["points", "plant", "seed"], columns="source", values=value)
        difference = (wide["informative"] - wide["task"]).dropna()
        for points, part in difference.groupby(level="points"):
            found = bootstrap_mean(part.to_numpy(), part.index.get_level_values("plant"))
            name = f"Fig. 4: {what}, informative minus non-informative, {points} points [rad/s^2]"
            rows.append(_claim(name, "below 0", found.mean, found.low, found.high, found.high < 0))
    gains = paired_gains(task).groupby(["plant", "seed"])["gain"].mean()
    found = bootstrap_mean(gains.to_numpy(), gains.index.get_level_values("plant"))
    name = "Fig. 4: average gain over the data sizes [%]"
    return [*rows, _claim(name, PAPER_GAIN, found.mean, found.low, found.high, found.mean >= PAPER_GAIN)]


def _table_1(errors: pd.DataFrame, points: int) -> list[dict[str, Any]]:
    rows = []
    reduced = reductions(errors, points).groupby(["source", "axis"])
    for source, name in (("task", "non-informative"), ("informative", "informative")):
        for axis in AXES:
            part = reduced.get_group((source, axis))
            found = bootstrap_mean(part["reduction"].to_numpy(), part["plant"])
            paper = PAPER[source][axis]
            title = f"Table I: reduction about {axis}, {name} [%]"
            rows.append(_claim(title, paper, found.mean, found.low, found.high, found.mean >= paper))
    return rows


def _correlation(table: pd.DataFrame) -> list[dict[str, Any]]:
    ranks = np.concatenate([rank_correlations(part).to_numpy() for _, part in table.groupby("plant")])
    draws = np.median(np.random.default_rng(0).choice(ranks, (10_000, len(ranks))), axis=1)
    low, high = np.percentile(draws, [2.5, 97.5])
    median = float(np.median(ranks))
    name = "Fig. 2: rank correlation of cost and error, median over runs"
    rows = [_claim(name, f"clear; at least {LEAST_CORRELATION}", median, low, high, median >= LEAST_CORRELATION)]
    better = []
    for (plant, _), run in table.groupby(["plant", "seed"]):
        own = run.loc[run["candidate"] == TASK, "error"].iloc[0]
        better.append((plant, 100.0 * (run.loc[run["candidate"] != TASK, "error"].min() < own)))
    found = bootstrap_mean([value for _, value in better], [plant for plant, _ in better])
    name = "Fig. 2: runs where some candidate teaches more than the task itself [%]"
    return [*rows, _claim(name, "1 of 1", found.mean, found.low, found.high, found.low > 50.0)]


def _pool(summary: pd.DataFrame) -> list[dict[str, Any]]:
    overall = summary[summary["task"] == "all"].iloc[0]
    rows = []
    for other in ("median", "random"):
        low, high = overall[f"low_{other}"], overall[f"high_{other}"]
        name = f"Real flights: error of the chosen flight minus {other} choice [m/s^2]"
        rows.append(_claim(name, "none", overall[f"below_{other}"], low, high, high < 0))
    return rows
