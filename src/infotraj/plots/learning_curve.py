"""Fig. 4: tracking error against the number of data points, learned from the flight that our cost, the paper's cost or
chance chose, or from the task's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from infotraj.errors import InputError, problem
from infotraj.evaluation.intervals import bootstrap_mean
from infotraj.plots import style

COLUMNS = ("plant", "seed", "source", "points", "error", "error_std")
PAPER_GAIN = 13.3  # %, Sec. V-B
ORDER = ("none", "prior", "task", "random", "paper", "informative")
ROOM = 0.72  # of the distance between two data sizes, which the sources of one size share


def figure_4(table: pd.DataFrame, pdf: str | Path, png: str | Path) -> None:
    """Writes Fig. 4: absolute angular acceleration error, its spread within the flight, and the paired gain.

    A row a run: plant, seed, source (task, random, paper, informative, prior, none), points (in all), error (mean over
    time and axes, rad/s^2), error_std (its spread within the flight). A column of panels a plant; points are runs, bars
    95 % bootstrap intervals of the mean; gain = 1 - informative/other of the same plant, seed and number of points, in
    %, the other being the task and, where it is there, the random candidate.
    InputError where a column is missing or a source is not known.
    """
    style.checked(table, COLUMNS, "figure 4")
    unknown = sorted(set(table["source"]) - set(ORDER))
    if unknown:
        raise InputError(problem(f"figure 4: source {unknown[0]}", ", ".join(ORDER), "Leave its rows out."))
    style.write(lambda: draw_figure_4(table), pdf, png)


def draw_figure_4(table: pd.DataFrame) -> Figure:
    """The figure itself; arguments as in `figure_4`."""
    plants = list(dict.fromkeys(table["plant"]))
    sizes = sorted(table["points"].unique())
    figure = style.figure(style.SINGLE if len(plants) == 1 else style.DOUBLE, 5.6)
    rows = figure.subplots(
        3, len(plants), sharex=True, sharey="row", squeeze=False, gridspec_kw={"height_ratios": [1.5, 1.0, 1.2]}
    )
    for column, plant in enumerate(plants):
        part = table[table["plant"] == plant]
        _add_sources(rows[0, column], part, "error", sizes)
        _add_sources(rows[1, column], part, "error_std", sizes)
        _add_gain(rows[2, column], part, sizes)
        rows[0, column].set_title(str(plant))
        rows[2, column].set_xticks(range(len(sizes)), [str(s) for s in sizes])
        rows[2, column].set_xlabel("num data points")
        rows[2, column].set_xlim(-0.5, len(sizes) - 0.5)
    rows[0, 0].set_ylabel("abs ang acc error [rad/s$^2$]")
    rows[1, 0].set_ylabel("its std in flight [rad/s$^2$]")
    rows[2, 0].set_ylabel("gain of informative [%]")
    for axes in rows[:2].flat:
        # a model of the task's flight that fails is ten times worse than the others; gains are ratios anyway
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.yaxis.set_minor_formatter(NullFormatter())
    entries: dict[str, Any] = {}
    for axes in rows.flat:
        entries |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=3 if len(plants) > 1 else 2)
    return figure


def paired_gains(table: pd.DataFrame, source: str = "informative", over: str = "task") -> pd.DataFrame:
    """Gain of one source over another (%), a row a plant, seed and number of points that has both."""
    keys = ["plant", "seed", "points"]
    wide = table[table["source"].isin([source, over])].pivot_table(index=keys, columns="source", values="error")
    if not {source, over} <= set(wide):
        return pd.DataFrame(columns=[*keys, "gain"])
    wide = wide.dropna(subset=[source, over])
    return (100.0 * (1.0 - wide[source] / wide[over])).rename("gain").reset_index()


def _add_sources(axes: Axes, part: pd.DataFrame, value: str, sizes: list[int]) -> None:
    for (source, points), rows in part.groupby(["source", "points"]):
        values = rows[value].dropna().to_numpy()
        if len(values):
            there = [s for s in ORDER if ((part["source"] == s) & (part["points"] == points)).any()]
            apart = ROOM / max(2, len(there))
            x = sizes.index(points) + apart * (there.index(source) - 0.5 * (len(there) - 1))
            style.add_runs(axes, x, values, bootstrap_mean(values), style.COLORS[source], style.MARKERS[source], apart)
    for source in ORDER:
        if (part["source"] == source).any():
            color, marker = style.COLORS[source], style.MARKERS[source]
            axes.plot([], [], marker, color=color, markersize=4.5, label=style.LABELS[source])


def _add_gain(axes: Axes, part: pd.DataFrame, sizes: list[int]) -> None:
    axes.axhline(0.0, color=style.INK, lw=0.6)
    axes.axhline(PAPER_GAIN, color=style.ORANGE, lw=1.0, ls="--", label=f"the paper's mean gain, {PAPER_GAIN} %")
    said = []
    others = [other for other in ("task", "random") if (part["source"] == other).any()]
    for k, other in enumerate(others):
        gains = paired_gains(part, over=other)
        color, marker = style.COLORS[other], style.MARKERS[other]
        x = 0.5 * ROOM * (k - 0.5 * (len(others) - 1))
        for points, rows in gains.groupby("points"):
            values = rows["gain"].to_numpy()
            style.add_runs(axes, sizes.index(points) + x, values, bootstrap_mean(values), color, marker, 0.5 * ROOM)
        if len(gains):
            average = bootstrap_mean(gains.groupby("seed")["gain"].mean().to_numpy())
            said.append(f"over {other}: {average.mean:.1f} % [{average.low:.1f}, {average.high:.1f}]")
    axes.set_title("\n".join(said), fontsize=7.5)
