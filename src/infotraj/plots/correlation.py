"""Fig. 2: is a flight with a low informative cost one whose model tracks well?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from scipy.stats import spearmanr

from infotraj.plots import style

COLUMNS = ("plant", "seed", "candidate", "cost", "error", "error_std")
TASK = -1
FEW = 12  # up to so many points a panel each shows its spread, as in the paper


def figure_2(table: pd.DataFrame, pdf: str | Path, png: str | Path) -> None:
    """Writes Fig. 2: tracking error of the angular acceleration about y against the informative cost.

    A row a flight: plant, seed, candidate (-1 is the task itself), cost, error and error_std (rad/s^2), and cost_paper
    where the paper's own cost is to be shown below ours. A column of panels a plant, with Spearman's rank correlation
    over each seed's sampled candidates. InputError where a column is missing.
    """
    style.checked(table, COLUMNS, "figure 2")
    style.write(lambda: draw_figure_2(table), pdf, png)


def draw_figure_2(table: pd.DataFrame) -> Figure:
    """The figure itself; arguments as in `figure_2`."""
    plants = list(dict.fromkeys(table["plant"]))
    costs = {"cost": "our cost"} | ({"cost_paper": "the paper's cost"} if "cost_paper" in table else {})
    figure = style.figure(style.SINGLE if len(plants) == 1 else style.DOUBLE, 0.5 + 2.4 * len(costs))
    panels = figure.subplots(len(costs), len(plants), sharey=True, squeeze=False)
    for row, (column, name) in zip(panels, costs.items(), strict=True):
        for axes, plant in zip(row, plants, strict=True):
            part = table[table["plant"] == plant].assign(cost=table[column])
            _add_panel(axes, part)
            _describe(axes, str(plant), name, rank_correlations(part))
        row[0].set_ylabel("abs ang acc error about y [rad/s$^2$]")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def rank_correlations(table: pd.DataFrame) -> pd.Series:
    """Spearman's rank correlation of cost and error over the sampled candidates, one a seed that has at least 3."""
    sampled = table[table["candidate"] != TASK]
    found = {
        seed: spearmanr(rows["cost"], rows["error"]).statistic
        for seed, rows in sampled.groupby("seed")
        if len(rows) > 2 and rows["cost"].nunique() > 1 and rows["error"].nunique() > 1
    }
    return pd.Series(found, dtype=float)


def _add_panel(axes: Axes, part: pd.DataFrame) -> None:
    sampled, task = part[part["candidate"] != TASK], part[part["candidate"] == TASK]
    if len(part) <= FEW:
        for rows, color in ((sampled, style.BLUE), (task, style.VERMILION)):
            axes.errorbar(
                rows["cost"], rows["error"], yerr=rows["error_std"], fmt="none", ecolor=color, lw=0.8, zorder=1
            )
    else:
        for _, rows in sampled.groupby("seed"):
            _add_trend(axes, rows)
    size = 22 if len(part) <= FEW else 7
    axes.scatter(
        sampled["cost"],
        sampled["error"],
        s=size,
        color=style.BLUE,
        alpha=0.55,
        lw=0,
        label="sampled trajectory",
        zorder=2,
    )
    if len(task):
        axes.scatter(
            task["cost"],
            task["error"],
            s=45,
            marker="*",
            color=style.VERMILION,
            ec="white",
            lw=0.4,
            label="task trajectory",
            zorder=3,
        )
    if part["cost"].min() > 0 and part["cost"].max() > 20 * part["cost"].min():
        axes.set_xscale("log")
        # A range of little more than a decade would label every tick of it.
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())


def _add_trend(axes: Axes, rows: pd.DataFrame) -> None:
    """The least-squares line of one seed, over its own costs: correlation is within a seed, levels differ between."""
    if len(rows) > 2 and rows["cost"].nunique() > 1:
        slope, level = np.polyfit(rows["cost"], rows["error"], 1)
        # A line over the costs is none on a logarithmic axis.
        costs = np.linspace(rows["cost"].min(), rows["cost"].max(), 100)
        first = axes.get_legend_handles_labels()[1].count("one seed's trend") == 0
        axes.plot(
            costs,
            level + slope * costs,
            color=style.PALE,
            lw=0.8,
            zorder=1,
            label="one seed's trend" if first else None,
        )


def _describe(axes: Axes, plant: str, cost: str, correlations: pd.Series) -> None:
    axes.set_xlabel(f"{cost} [rad$^2$/s$^4$]")
    title = plant
    if len(correlations) == 1:
        title += f"\nSpearman {correlations.iloc[0]:.2f}"
    elif len(correlations):
        title += (
            f"\nSpearman: median {correlations.median():.2f}, "
            f"{correlations.min():.2f} to {correlations.max():.2f}\nover {len(correlations)} seeds"
        )
    axes.set_title(title, linespacing=1.1)
