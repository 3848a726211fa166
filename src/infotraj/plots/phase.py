"""Fig. 5: how far the modified task goes beyond the task, torque against attitude."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from infotraj.plots import style

COLUMNS = ("roll", "pitch", "tx", "ty")


def figure_5(task: pd.DataFrame, modified: pd.DataFrame, pdf: str | Path, png: str | Path) -> None:
    """Writes Fig. 5: roll (deg) against torque about x (N m), pitch (deg) against torque about y (N m).

    task, modified: a row a sample, columns roll, pitch (deg), tx, ty (N m). InputError where a column is missing.
    """
    style.checked(task, COLUMNS, "figure 5, task")
    style.checked(modified, COLUMNS, "figure 5, modified task")
    style.write(lambda: draw_figure_5(task, modified), pdf, png)


def draw_figure_5(task: pd.DataFrame, modified: pd.DataFrame) -> Figure:
    """The figure itself; arguments as in `figure_5`."""
    figure = style.figure(style.SINGLE * 1.35, 2.6)
    panels = figure.subplots(1, 2)
    for axes, torque, angle, axis in zip(panels, ("tx", "ty"), ("roll", "pitch"), ("x", "y"), strict=True):
        axes.plot(modified[torque], modified[angle], color=style.SKY, lw=0.8, label="modified task trajectory")
        axes.plot(task[torque], task[angle], color=style.VERMILION, lw=0.8, label="task trajectory")
        axes.set_xlabel(f"torque about {axis} [N m]")
        axes.set_ylabel(f"{angle} angle [deg]")
        axes.margins(0.08)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure
