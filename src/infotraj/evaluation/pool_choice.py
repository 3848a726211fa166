"""What choosing by cost from a pool of flights gained: against the median candidate and against a random one."""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import stats

from infotraj.errors import InputError, problem
from infotraj.rotations import Array

NEEDED = ("task", "prior", "candidate", "seed", "cost", "error", "chosen")
_DRAWS = 10_000


def choices(table: pd.DataFrame) -> pd.DataFrame:
    """One row a task, prior and seed: errors (m/s^2) of the chosen, median, random (mean) and best candidate.

    rank: of the chosen among the `candidates`, 1 is best; correlation: Spearman's, of cost with error.
    InputError where a column is missing or a choice is not exactly one candidate.
    """
    missing = [name for name in NEEDED if name not in table]
    if missing:
        raise InputError(problem(f"pool table without {', '.join(missing)}", ", ".join(NEEDED), "Evaluate the pool."))
    rows = []
    for (task, prior, seed), group in table.groupby(["task", "prior", "seed"], sort=False):
        chosen = group.loc[group["chosen"] == 1, "error"]
        if len(chosen) != 1:
            raise InputError(
                problem(f"{len(chosen)} chosen for {task} from {prior}, seed {seed}", "1", "Evaluate the pool again.")
            )
        error = group["error"]
        rows.append(
            {
                "task": task,
                "prior": prior,
                "seed": seed,
                "chosen": chosen.iloc[0],
                "median": error.median(),
                "random": error.mean(),
                "best": error.min(),
                "rank": int((error < chosen.iloc[0]).sum()) + 1,
                "candidates": len(group),
                "correlation": stats.spearmanr(group["cost"], error).statistic,
            }
        )
    return pd.DataFrame(rows)


def choose_again(table: pd.DataFrame, keep: np.ndarray) -> pd.DataFrame:
    """The table with the rows `keep` (n,) alone, and the candidate of least cost among them chosen."""
    table = table[keep].reset_index(drop=True)
    least = table.groupby(["task", "prior", "seed"])["cost"].idxmin()
    return table.assign(chosen=table.index.isin(least).astype(int))


def by_task(chosen: pd.DataFrame) -> pd.DataFrame:
    """Means over priors and seeds of the rows of `choices`, one row a task."""
    numbers = ["chosen", "median", "random", "best", "rank", "candidates", "correlation"]
    means = chosen.groupby("task")[numbers].mean().reset_index()
    for other in ("median", "random"):
        means[f"below_{other}"] = means["chosen"] - means[other]
    return means


def overall(chosen: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """One row for each alternative (median, random): mean difference chosen minus alternative and 95 % intervals.

    difference, low, high: paired, percentile bootstrap over tasks, since the priors and seeds of one task are not
    independent (Cameron, Gelbach, Miller 2008). low_t, high_t: Student's, over the tasks' means. low_both, high_both:
    tasks and priors both resampled (Owen 2007), for the priors repeat over the tasks. relative: difference over the
    alternative's mean. tasks_better of tasks: where the mean difference is below 0.
    """
    rows = []
    for other in ("median", "random"):
        difference = chosen.assign(difference=chosen["chosen"] - chosen[other])
        grid = difference.pivot_table(index="task", columns="prior", values="difference", aggfunc="mean").to_numpy()
        means = np.nanmean(grid, axis=1)
        task_draws = rng.integers(len(means), size=(_DRAWS, len(means)))
        low, high = _interval(means[task_draws].mean(axis=1))
        low_both, high_both = _interval(_both_ways(grid, task_draws, rng))
        low_t, high_t = means.mean() + np.array([-1, 1]) * stats.t.ppf(0.975, len(means) - 1) * stats.sem(means)
        rows.append(
            {
                "against": other,
                "difference": means.mean(),
                "low": low,
                "high": high,
                "low_t": low_t,
                "high_t": high_t,
                "low_both": low_both,
                "high_both": high_both,
                "relative": means.mean() / chosen.groupby("task")[other].mean().mean(),
                "tasks_better": int((means < 0).sum()),
                "tasks": len(means),
            }
        )
    return pd.DataFrame(rows)


def _both_ways(grid: Array, task_draws: np.ndarray, rng: np.random.Generator) -> Array:
    """Mean of the grid (tasks, priors) for each draw of tasks with a draw of priors of its own."""
    priors = rng.integers(grid.shape[1], size=(len(task_draws), grid.shape[1]))
    return np.array([np.nanmean(grid[np.ix_(a, b)]) for a, b in zip(task_draws, priors, strict=True)])


def _interval(draws: Array) -> tuple[float, float]:
    low, high = np.percentile(draws, [2.5, 97.5])
    return float(low), float(high)
