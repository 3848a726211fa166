"""What each cost's choice was worth over all runs, and how the run's own cost fares at every data size."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import sem, spearmanr, t

from infotraj.errors import InputError, problem
from infotraj.evaluation.intervals import Interval
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.paper.costs import LITERAL, OURS
from infotraj.experiment.paper.selecting import TASK
from infotraj.plots.typeset import markdown as as_markdown
from infotraj.writing import write_text

RUN = ["plant", "seed"]


def choices(hindsight: pd.DataFrame, costs: pd.DataFrame) -> pd.DataFrame:
    """A row a run, cost and data size (0: their mean): what its choice was worth.

    chosen, mean, best, task: errors (rad/s^2) of the chosen, mean and best candidate and of the task's own flight;
    rank: Spearman's correlation of cost and error over the candidates; task_first: 1 where the task's own flight costs
    less than every candidate, NaN where it was not scored.

    hindsight: rows of `experiment.hindsight`, costs: of `experiment.costs`. InputError where a run has no costs.
    """
    together = hindsight.groupby([*RUN, "candidate"], as_index=False)["error"].mean().assign(points=0)
    rows = []
    for (plant, seed, points), flown in pd.concat([hindsight, together]).groupby([*RUN, "points"]):
        error = flown.set_index("candidate")["error"]
        task, candidates = error[TASK], error.drop(TASK).sort_index()
        own = costs[(costs["plant"] == plant) & (costs["seed"] == seed)]
        if own.empty:
            raise InputError(problem(f"{plant}, seed {seed}: no costs", "those of every run", "Make them again."))
        for (group, name), part in own.groupby(["group", "cost"], sort=False):
            value = part.set_index("candidate")["value"].loc[candidates.index]
            rows.append(
                {
                    "plant": plant,
                    "seed": seed,
                    "points": points,
                    "group": group,
                    "cost": name,
                    "chosen": candidates[value.idxmin()],
                    "mean": candidates.mean(),
                    "best": candidates.min(),
                    "task": task,
                    "rank": spearmanr(value, candidates).statistic,
                    "task_first": _task_first(part),
                }
            )
    return pd.DataFrame(rows)


def summarise(
    *, hindsight: Sequence[str | Path], costs: Sequence[str | Path], table: str | Path, markdown: str | Path
) -> None:
    """Writes `choices` of all runs (CSV) and both tables of the page (Markdown)."""
    flown = pd.concat([pd.read_csv(path) for path in hindsight], ignore_index=True)
    found = choices(flown, pd.concat([pd.read_csv(path) for path in costs], ignore_index=True))
    write_table(found, table)
    runs = ", ".join(f"{plant} {count}" for plant, count in flown.groupby("plant")["seed"].nunique().items())
    count = flown.loc[flown["candidate"] != TASK, "candidate"].nunique()
    sizes = ", ".join(str(points) for points in sorted(flown["points"].unique()))
    lines = [
        f"Runs: {runs}. {count} candidates a run, each flown, learned from and closed into the loop: {sizes} points.",
        "",
        "Costs against the closed-loop error, mean over the data sizes; +-: standard error over the runs.",
        "",
        of_costs(found),
        "At every data size: errors in rad/s^2, Student's 95 % intervals over the runs.",
        "",
        of_sizes(found),
    ]
    write_text("\n".join(lines), markdown)


def of_costs(found: pd.DataFrame) -> str:
    """Markdown, a row a cost: median rank correlation, and the chosen against the mean candidate."""
    found = found[found["points"] == 0]
    rows = []
    for (_, name), part in found.groupby(["group", "cost"], sort=False):
        ranks = part["rank"]
        spread = f"{ranks.median():+.2f} ({ranks.quantile(0.25):+.2f} to {ranks.quantile(0.75):+.2f})"
        again = f"{100.0 * part['task_first'].mean():.0f} %" if part["task_first"].notna().all() else ""
        rows.append([name, spread, _against_mean(part, "chosen"), again])
    one = found[found["cost"] == OURS]
    rows.append(["hindsight: the best of all (bound)", "", _against_mean(one, "best"), ""])
    rows.append(["the task's own flight", "", _against_mean(one, "task"), ""])
    header = [
        "who chooses",
        "rank correlation, median (quartiles)",
        "chosen against the mean candidate",
        "would fly the task again",
    ]
    return as_markdown(header, rows)


def of_sizes(found: pd.DataFrame) -> str:
    """Markdown, a row a cost, plant (and all) and data size, for the run's cost and the paper's."""
    rows = []
    for name in (OURS, LITERAL):
        part = found[found["cost"] == name]
        for plant in ["all", *dict.fromkeys(part["plant"])]:
            of_plant = part if plant == "all" else part[part["plant"] == plant]
            for points, at in of_plant.groupby("points"):
                gains = [_student(100.0 * (1.0 - at[who] / at["task"])) for who in ("chosen", "mean", "best")]
                rows.append(
                    [
                        name,
                        plant,
                        "mean" if points == 0 else str(points),
                        _text(_student(at["chosen"] - at["mean"]), 4),
                        _text(_student(at["best"] - at["mean"]), 4),
                        f"{100.0 * (at['mean'] - at['chosen']).sum() / (at['mean'] - at['best']).sum():.0f} %",
                        *(_text(gain, 1) for gain in gains),
                        f"{at['rank'].median():+.2f}",
                    ]
                )
    header = [
        "cost",
        "plant",
        "points",
        "chosen minus random",
        "best minus random",
        "share of hindsight",
        "gain over the task's flight [%]",
        "that of random",
        "that of the best",
        "rank correlation, median",
    ]
    return as_markdown(header, rows)


def _task_first(part: pd.DataFrame) -> float:
    value = part.set_index("candidate")["value"]
    return float(value.idxmin() == TASK) if TASK in value.index else np.nan


def _against_mean(part: pd.DataFrame, who: str) -> str:
    relative = 100.0 * (part[who] / part["mean"] - 1.0)
    return f"{relative.mean():+.1f} +- {sem(relative) if len(relative) > 1 else np.nan:.1f} %"


def _student(values: pd.Series) -> Interval:
    """Student's 95 % interval of the mean: a plant has too few runs here for a bootstrap; NaN limits for one run."""
    count, mean = len(values), float(values.mean())
    half = t.ppf(0.975, count - 1) * sem(values) if count > 1 else np.nan
    return Interval(mean, mean - half, mean + half, count)


def _text(found: Interval, digits: int) -> str:
    return f"{found.mean:.{digits}f} [{found.low:.{digits}f}, {found.high:.{digits}f}]"
