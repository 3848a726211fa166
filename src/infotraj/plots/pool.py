"""The pool of recorded flights: cost against error for every task, and what the choice by cost gained."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from infotraj.evaluation.pool_choice import by_task, choices, overall
from infotraj.plots import style

COLUMNS = ("task", "candidate", "cost", "error", "chosen")
ALTERNATIVES = {"median": (style.VERMILION, "s"), "random": (style.ORANGE, "^")}
LOWEST_SEED = 0  # of the bootstrap in the title, so that the figure is the same at every run


def figure_pool(table: pd.DataFrame, pdf: str | Path, png: str | Path) -> None:
    """Writes cost against error of every candidate for every task, and chosen against median and random choice.

    A row a candidate: task, candidate, cost, error (m/s^2), chosen (0 or 1), and prior and seed where there are
    several. The cost is drawn over the median cost of its task, prior and seed. InputError where a column is missing.
    """
    style.checked(table, COLUMNS, "figure of the pool")
    style.write(lambda: draw_figure_pool(table), pdf, png)


def draw_figure_pool(table: pd.DataFrame) -> Figure:
    """The figure itself; arguments as in `figure_pool`."""
    table = table.assign(**{name: 0 for name in ("prior", "seed") if name not in table})
    chosen = choices(table)
    summary = by_task(chosen).sort_values("chosen", ascending=False).reset_index(drop=True)
    tasks = list(dict.fromkeys(table["task"]))
    across = min(5, len(tasks))
    down = -(-len(tasks) // across)
    figure = style.figure(style.DOUBLE, 1.45 * down + 0.7 + max(2.3, 0.19 * len(tasks)))
    halves: Any = figure.subfigures(2, 1, height_ratios=[1.45 * down + 0.5, max(2.3, 0.19 * len(tasks)) + 0.2])
    upper, lower = halves
    panels = upper.subplots(down, across, squeeze=False).ravel()
    for axes in panels[len(tasks) :]:
        axes.set_visible(False)
    for axes, task in zip(panels, tasks, strict=False):
        _add_task(axes, table[table["task"] == task])
        axes.set_title(str(task), fontsize=7)
    upper.supxlabel("informative cost over its median [-]", fontsize=9)
    upper.supylabel("error on the task [m/s$^2$]", fontsize=9)
    upper.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    _add_summary(lower, summary, overall(chosen, np.random.default_rng(LOWEST_SEED)))
    return figure


def _add_task(axes: Axes, part: pd.DataFrame) -> None:
    relative = part["cost"] / part.groupby(["prior", "seed"])["cost"].transform("median")
    picked = part["chosen"].astype(bool)
    many = part.groupby(["prior", "seed"]).ngroups > 1
    axes.scatter(
        relative[~picked],
        part["error"][~picked],
        s=4 if many else 10,
        color=style.GREY,
        alpha=0.5,
        lw=0,
        label="candidate",
    )
    axes.scatter(
        relative[picked],
        part["error"][picked],
        s=14 if many else 26,
        color=style.BLUE,
        ec="white",
        lw=0.3,
        label="chosen",
        zorder=3,
    )
    axes.axhline(part["error"].median(), color=style.VERMILION, lw=0.8, ls="--", label="median error", zorder=1)
    axes.tick_params(labelsize=6.5)
    axes.locator_params(nbins=4)


def _add_summary(figure: Figure, summary: pd.DataFrame, paired: pd.DataFrame) -> None:
    left, right = figure.subplots(1, 2, width_ratios=[1.5, 1])
    rows = np.arange(len(summary))
    left.hlines(rows, summary["best"], summary["median"], color=style.PALE, lw=1.0, zorder=1)
    left.plot(summary["best"], rows, "|", color=style.GREY, markersize=7, label="best candidate")
    for name, (color, marker) in ALTERNATIVES.items():
        left.plot(summary[name], rows, marker, color=color, markersize=4, label=f"{name} choice")
    left.plot(summary["chosen"], rows, "o", color=style.BLUE, markersize=5, label="chosen by cost")
    left.set_yticks(rows, summary["task"], fontsize=7)
    left.set_ylim(-0.7, len(rows) - 0.3)
    left.set_xlabel("error on the task [m/s$^2$]")
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    right.axhline(0.0, color=style.INK, lw=0.6)
    for x, row in enumerate(paired.itertuples()):
        color, marker = ALTERNATIVES[row.against]
        values = summary[f"below_{row.against}"].to_numpy()
        right.plot(x + style.sideways(len(values), 0.35), values, ".", color=color, alpha=0.5, mew=0)
        around = [[row.difference - row.low], [row.high - row.difference]]
        right.errorbar(
            x, row.difference, yerr=around, color=color, marker=marker, markersize=5, mec="white", mew=0.4, zorder=3
        )
    right.set_xticks(range(len(paired)), [_said(row) for row in paired.itertuples()], fontsize=7.5, linespacing=1.0)
    right.set_xlim(-0.6, len(paired) - 0.4)
    right.set_ylabel("difference in error [m/s$^2$]")


def _said(row: Any) -> str:
    interval = f"{row.difference:.3f} [{row.low:.3f}, {row.high:.3f}]"
    return f"chosen minus {row.against}\n{interval}\nlower in {row.tasks_better} of {row.tasks} tasks"
