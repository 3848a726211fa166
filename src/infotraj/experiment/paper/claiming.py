"""Each claim of the paper, and of the pool scenario, with the paper's number, ours with its interval, and whether ours
holds: `yes` or `no` where the whole interval says so, else `open`. The limits are those of the paper.

Beside the paper's comparison, with the task's own flight, stand those that it does not make: with a candidate drawn at
random, and with the candidate that the paper's cost chooses word for word. Without them nothing is said of the cost.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from infotraj.evaluation.intervals import Interval, bootstrap_mean
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.paper.figures import AXES, reductions
from infotraj.experiment.real.pool import ALL, OTHER_TRAJECTORIES
from infotraj.plots.claims import claims_table
from infotraj.plots.correlation import TASK, rank_correlations
from infotraj.plots.learning_curve import PAPER_GAIN, paired_gains
from infotraj.plots.table_1 import paper

LEAST_CORRELATION = 0.6  # what is asked of the cost as a predictor; the paper says "clear correspondence"
OTHERS = {"task": "the task's flight", "random": "a random candidate", "paper": "the choice of the paper's cost"}

Claims = Iterator[dict[str, Any]]


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


def _claim(claim: str, paper: object, ours: Interval, *, above: float | None = None, below: float | None = None):
    """A row; it holds where the whole interval lies above, or below, the limit that is given."""
    if above is not None:
        holds = "yes" if ours.low > above else "no" if ours.high < above else "open"
    elif below is not None:
        holds = "yes" if ours.high < below else "no" if ours.low > below else "open"
    else:
        holds = "open"
    return {"claim": claim, "paper": paper, "ours": ours.mean, "low": ours.low, "high": ours.high, "holds": holds}


def _compared(claim: str, unit: str, paper: object, values: pd.Series, **limit: float) -> Claims:
    """The claim about the mean over all plants, then that of each plant where one of them answers differently.

    values: one a run, index plant and seed.
    """
    plants = values.index.get_level_values("plant")
    together = _claim(f"{claim} [{unit}]", paper, bootstrap_mean(values.to_numpy(), plants), **limit)
    yield together
    each = [
        _claim(f"{claim}, {plant} [{unit}]", paper, bootstrap_mean(values[plants == plant].to_numpy()), **limit)
        for plant in plants.unique()
    ]
    if any(row["holds"] != together["holds"] for row in each):
        yield from each


def _learning_curve(errors: pd.DataFrame) -> Claims:
    task = errors[errors["reference"] == "task"]
    for value, what in (("error", "error"), ("error_std", "spread of the error")):
        wide = task.pivot_table(index=["points", "plant", "seed"], columns="source", values=value)
        # The paper speaks of the spread against the task's flight alone.
        for other in [name for name in OTHERS if name in wide and (value == "error" or name == "task")]:
            said = "below 0" if other == "task" else "none"
            difference = (wide["informative"] - wide[other]).dropna()
            name = f"Fig. 4: {what}, informative minus {OTHERS[other]}"
            for points, part in difference.groupby(level="points"):
                found = bootstrap_mean(part.to_numpy(), part.index.get_level_values("plant"))
                yield _claim(f"{name}, {points} points [rad/s^2]", said, found, below=0.0)
            mean = difference.groupby(["plant", "seed"]).mean()
            yield from _compared(f"{name}, mean over the sizes", "rad/s^2", said, mean, below=0.0)
    for source in [name for name in ("informative", "random", "paper") if (task["source"] == name).any()]:
        gains = paired_gains(task, source).groupby(["plant", "seed"])["gain"].mean()
        informative = source == "informative"
        paper, least = (PAPER_GAIN, PAPER_GAIN) if informative else ("none", 0.0)
        name = "informative" if informative else OTHERS[source]
        yield from _compared(f"Fig. 4: average gain over the task's flight, {name}", "%", paper, gains, above=least)


def _table_1(errors: pd.DataFrame, points: int) -> Claims:
    reduced = reductions(errors, points).pivot_table(
        index=["axis", "plant", "seed"], columns="source", values="reduction"
    )
    for other in [name for name in OTHERS if name in reduced]:
        for axis in AXES:
            difference = (reduced["informative"] - reduced[other]).xs(axis, level="axis").dropna()
            said = paper(f"over_{other}", axis)
            name = f"Table I: reduction about {axis}, informative minus {OTHERS[other]}"
            yield from _compared(name, "points of %", "none" if said is None else said, difference, above=0.0)


def _correlation(table: pd.DataFrame) -> Claims:
    for column, cost in (("cost", "our cost"), ("cost_paper", "the paper's cost")):
        if column not in table:
            continue
        parts = [rank_correlations(part.assign(cost=part[column])) for _, part in table.groupby("plant")]
        ranks = np.concatenate([part.to_numpy() for part in parts])
        draws = np.median(np.random.default_rng(0).choice(ranks, (10_000, len(ranks))), axis=1)
        low, high = np.percentile(draws, [2.5, 97.5])
        found = Interval(float(np.median(ranks)), float(low), float(high), len(ranks))
        name = f"Fig. 2: rank correlation of {cost} and error, median over runs"
        yield _claim(name, f"clear; at least {LEAST_CORRELATION}", found, above=LEAST_CORRELATION)
    better = []
    for (plant, _), run in table.groupby(["plant", "seed"]):
        own = run.loc[run["candidate"] == TASK, "error"].iloc[0]
        better.append((plant, 100.0 * (run.loc[run["candidate"] != TASK, "error"].min() < own)))
    found = bootstrap_mean([value for _, value in better], [plant for plant, _ in better])
    name = "Fig. 2: runs where some candidate teaches more than the task itself [%]"
    yield _claim(name, "1 of 1", found, above=50.0)


def _pool(summary: pd.DataFrame) -> Claims:
    for task, where in ((ALL, ""), (OTHER_TRAJECTORIES, ", without flights of the task's own trajectory")):
        for row in summary[summary["task"] == task].to_dict("records"):
            for other in ("median", "random"):
                found = Interval(row[f"below_{other}"], row[f"low_{other}"], row[f"high_{other}"], 0)
                name = f"Real flights: error of the chosen flight minus {other} choice{where} [m/s^2]"
                yield _claim(name, "none", found, below=0.0)
