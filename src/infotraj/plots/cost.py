"""The informative cost of all candidates, and which of them was chosen."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from infotraj.plots import style

COLUMNS = ("candidate", "cost", "chosen")
TASK = -1


def figure_costs(table: pd.DataFrame, pdf: str | Path, png: str | Path, title: str = "") -> None:
    """Writes the costs of all candidates, sorted, with the chosen one and the task marked.

    A row a candidate: candidate (-1 is the task itself), cost (rad^2/s^4), chosen (true or false), and, where it was
    computed, cost_std, the standard deviation over the draws. InputError where a column is missing.
    """
    style.checked(table, COLUMNS, "figure of costs")
    style.write(lambda: draw_figure_costs(table, title), pdf, png)


def draw_figure_costs(table: pd.DataFrame, title: str = "") -> Figure:
    """The figure itself; arguments as in `figure_costs`."""
    ranked = table.sort_values("cost", kind="stable").reset_index(drop=True)
    figure = style.figure(style.DOUBLE if len(ranked) > 25 else style.SINGLE, 2.5)
    axes = figure.subplots()
    chosen = ranked["chosen"].astype(bool)
    task = ranked["candidate"] == TASK
    groups = {
        "sampled candidate": (~chosen & ~task, style.GREY, "o", 16),
        "task trajectory": (task & ~chosen, style.VERMILION, "*", 60),
        "task trajectory, chosen": (task & chosen, style.BLUE, "*", 60),
        "chosen": (chosen & ~task, style.BLUE, "o", 34),
    }
    for label, (rows, color, marker, size) in groups.items():
        if rows.any():
            x, y = ranked.index[rows], ranked.loc[rows, "cost"]
            if "cost_std" in ranked:
                axes.errorbar(x, y, yerr=ranked.loc[rows, "cost_std"], fmt="none", ecolor=color, lw=0.8, alpha=0.7)
            axes.scatter(x, y, s=size, color=color, marker=marker, ec="white", lw=0.4, label=label, zorder=3)
    names = ["task" if c == TASK else str(c) for c in ranked["candidate"]]
    axes.set_xticks(range(len(ranked)), names, rotation=90, fontsize=7 if len(ranked) <= 45 else 5)
    axes.set_xlabel("candidate, by cost" + (" (bars: std over draws)" if "cost_std" in ranked else ""))
    axes.set_ylabel("informative cost [rad$^2$/s$^4$]")
    axes.set_title(title)
    axes.legend(loc="upper left")
    return figure
