"""The hidden-effect study: what was hidden against what was named, the error's fall, and where finding ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from infotraj.plots import style

LAST = ("(nothing)", "(unexplained)")
ALL = "all together"
_COLORS = (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE, style.PURPLE, style.SKY)
_MARKS = ("o", "s", "^", "D", "v", "P")
_AXES = {
    "size": "size of the effect, usual = 1 [-]",
    "seconds": "length of each of 4 flights [s]",
    "noise": "noise of all sensors, usual = 1 [-]",
    "logging": "",
}
_LOGS = {"full": "full", "50hz": "50 Hz", "mocap": "mocap\nno IMU", "no_tilts": "no tilt\ncommands"}


def figure_confusion(table: pd.DataFrame, pdf: str | Path, png: str | Path) -> None:
    """Writes the confusion matrix: rows what was hidden, columns what was named (`hidden_tables.confusion_table`)."""
    style.checked(table, ("vehicle", "kind", "hidden", "named", "share", "runs"), "confusion matrix")
    style.write(lambda: draw_confusion(table), pdf, png)


def draw_confusion(table: pd.DataFrame) -> Figure:
    """The figure itself: one panel a vehicle, one below the other."""
    vehicles = list(dict.fromkeys(table["vehicle"]))
    heights = [table[table["vehicle"] == v].groupby(["kind", "hidden"]).ngroups for v in vehicles]
    figure = style.figure(style.DOUBLE, 0.155 * sum(heights) + 1.5 * len(vehicles) + 0.3)
    panels = figure.subplots(len(vehicles), 1, squeeze=False, height_ratios=[h + 2 for h in heights])[:, 0]
    for axes, vehicle in zip(panels, vehicles, strict=True):
        image = _matrix(axes, table[table["vehicle"] == vehicle], vehicle)
    figure.colorbar(image, ax=panels.tolist(), label="share of runs", shrink=0.4, aspect=30, pad=0.01)
    return figure


def _matrix(axes: Axes, part: pd.DataFrame, vehicle: str):
    order = {"single": 0, "nothing": 1, "cannot_show": 2, "richer": 3, "unlisted": 4}
    keys = sorted({(order[k], k, h) for k, h in zip(part["kind"], part["hidden"], strict=True)})
    hidden = [h for _, k, h in keys if k == "single"]
    others = sorted(set(part["named"]) - set(hidden) - set(LAST))
    named = [*hidden, *others, *LAST]
    image = np.zeros((len(keys), len(named)))
    for row in part.itertuples():
        image[keys.index((order[row.kind], row.kind, row.hidden)), named.index(row.named)] = row.share
    shown = axes.imshow(image, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    for i, j in zip(*np.nonzero(image), strict=True):
        tone = "white" if image[i, j] > 0.55 else style.INK
        axes.text(j, i, f"{100 * image[i, j]:.0f}", ha="center", va="center", fontsize=4.5, color=tone)
    axes.set_xticks(range(len(named)), named, rotation=60, ha="right", rotation_mode="anchor", fontsize=6)
    axes.set_yticks(range(len(keys)), [_row_name(k, h) for _, k, h in keys], fontsize=6)
    for k in range(1, len(keys)):
        if keys[k][1] != keys[k - 1][1]:
            axes.axhline(k - 0.5, color=style.GREY, lw=0.6)
    axes.grid(False)
    axes.set_title(f"{vehicle}: what was hidden (rows), what was named (columns), % of runs", loc="left", fontsize=8)
    return shown


def _row_name(kind: str, hidden: str) -> str:
    return {
        "cannot_show": f"{hidden} (no trace)",
        "richer": f"{hidden} (richer)",
        "unlisted": f"{hidden} (unlisted)",
    }.get(kind, hidden)


def figure_error_fall(runs: pd.DataFrame, pdf: str | Path, png: str | Path) -> None:
    """Writes the held-out error of nominal model, answer and oracle, effect by effect, above the floor."""
    style.checked(runs, ("vehicle", "kind", "size", "hidden", "error_nominal", "error_answer"), "fall of the error")
    style.write(lambda: draw_error_fall(runs), pdf, png)


def draw_error_fall(runs: pd.DataFrame) -> Figure:
    """The figure itself: clean single effects at usual size and unlisted physics; medians over the runs."""
    kinds = runs["kind"].isin(["unlisted", "richer"]) | ((runs["kind"] == "single") & (runs["size"] == "usual"))
    part = runs[kinds & ~runs["clutter"] & runs["answered"]]
    vehicles = list(dict.fromkeys(part["vehicle"])) or ["none"]
    longest = max([part[part["vehicle"] == v]["hidden"].nunique() for v in vehicles], default=1)
    figure = style.figure(style.DOUBLE, 0.16 * max(longest, 3) + 1.0)
    panels = figure.subplots(1, len(vehicles), squeeze=False)[0]
    looks = (
        ("error_nominal", "nominal", style.GREY, "o"),
        ("error_oracle", "oracle", style.GREEN, "|"),
        ("error_answer", "answer", style.BLUE, "D"),
    )
    for axes, vehicle in zip(panels, vehicles, strict=True):
        found = part[part["vehicle"] == vehicle]
        middle = found.groupby("hidden")[[c for c, *_ in looks]].median().sort_values("error_nominal")
        rows = np.arange(len(middle))
        axes.hlines(rows, middle["error_answer"], middle["error_nominal"], color=style.PALE, lw=1.0, zorder=1)
        for column, label, color, marker in looks:
            size = 9 if marker == "|" else 3.5
            axes.plot(middle[column], rows, marker, color=color, markersize=size, label=label, ls="none")
        axes.axvline(1.0, color=style.INK, lw=0.8, ls="--", label="floor (nothing hidden)")
        axes.set_xscale("log")
        axes.set_yticks(rows, middle.index, fontsize=6)
        axes.set_xlabel("held-out squared error over the floor [-]")
        axes.set_title(vehicle, fontsize=8, loc="left")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def figure_curves(table: pd.DataFrame, pdf: str | Path, png: str | Path) -> None:
    """Writes the found rate against size, flight length, noise and kind of log (`hidden_tables.curves_table`)."""
    style.checked(table, ("vehicle", "effect", "what", "value", "share", "low", "high"), "curves")
    style.write(lambda: draw_curves(table), pdf, png)


def draw_curves(table: pd.DataFrame) -> Figure:
    """The figure itself: a row a vehicle, a column a circumstance."""
    vehicles = list(dict.fromkeys(table["vehicle"]))
    figure = style.figure(style.DOUBLE, 1.9 * len(vehicles) + 0.3)
    rows = figure.subfigures(len(vehicles), 1, squeeze=False)[:, 0]
    for part, vehicle in zip(rows, vehicles, strict=True):
        own = table[table["vehicle"] == vehicle]
        panels = part.subplots(1, 4, sharey=True)
        for axes, what in zip(panels, _AXES, strict=True):
            _curve(axes, own[own["what"] == what], what, [e for e in dict.fromkeys(own["effect"]) if e != ALL])
        panels[0].set_ylabel(f"{vehicle}: share right")
        part.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=6, fontsize=7)
    return figure


def _curve(axes: Axes, table: pd.DataFrame, what: str, effects: list[str]) -> None:
    """Each effect, and all together with their 95 % interval."""
    for k, effect in enumerate([*effects, ALL]):
        part = table[table["effect"] == effect]
        if what == "logging":
            x = np.array([list(_LOGS).index(v) for v in part["value"]], dtype=float)
        else:
            x = part["value"].astype(float).to_numpy()
        order = np.argsort(x)
        x, part = x[order], part.iloc[order]
        whole = effect == ALL
        shift = 0.0 if whole else 0.08 * (k - 0.5 * (len(effects) - 1))
        x = x + shift if what == "logging" else x * np.exp(0.4 * shift)
        around = [part["share"] - part["low"], part["high"] - part["share"]] if whole else None
        line = "none" if what == "logging" else "-"
        axes.errorbar(
            x, part["share"], yerr=around, color="black" if whole else _COLORS[k % 6], ls=line, label=effect,
            marker="_" if whole else _MARKS[k % 6], markersize=7 if whole else 3, lw=1.6 if whole else 0.5,
            elinewidth=0.8, capsize=2.0, zorder=3 if whole else 2,
        )  # fmt: skip
    axes.set_ylim(-0.04, 1.04)
    if what == "logging":
        axes.set_xticks(range(len(_LOGS)), list(_LOGS.values()), fontsize=6.5)
    else:
        axes.set_xscale("log")
        marks = sorted(set(table["value"].astype(float)))
        axes.set_xticks(marks, [f"{m:g}" for m in marks], fontsize=6.5)
        axes.set_xticks([], minor=True)
        axes.set_xlabel(_AXES[what], fontsize=7.5)
