"""How many points a Gaussian process needs, with and without the named effects."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from infotraj.plots import style

_LOOKS = {
    "gp": ("Gaussian process alone", style.ORANGE, "s"),
    "both": ("Named effects and Gaussian process", style.BLUE, "o"),
}
_ROWS = {
    "torque_left": "Angular acceleration\nleft (rad/s$^2$ RMS)",
    "force_left": "Specific force\nleft (m/s$^2$ RMS)",
}


def points_needed(table: pd.DataFrame, *paths: Path) -> None:
    """Draws what is left of a held-out flight against the number of points, a column a case: mean and range of seeds.

    table: case, seed, controller (gp, both), points, force_left, torque_left.
    """
    rows = style.checked(table, ["case", "seed", "controller", "points", *_ROWS], "points needed")
    style.write(lambda: _drawn(rows), *paths)


def _drawn(rows: pd.DataFrame) -> Figure:
    cases = list(dict.fromkeys(rows["case"]))
    figure = style.figure(style.DOUBLE, 3.9)
    panels = figure.subplots(2, len(cases), squeeze=False, sharex=True, sharey="row")
    points = sorted(rows["points"].unique())
    place = {p: k for k, p in enumerate(points)}
    for column, case in enumerate(cases):
        words = case.replace("_", " ")
        panels[0, column].set_title(words[0].upper() + words[1:])
        for row, (name, label) in enumerate(_ROWS.items()):
            panel = panels[row, column]
            for controller, (meaning, color, marker) in _LOOKS.items():
                part = rows[(rows["case"] == case) & (rows["controller"] == controller)]
                found = part.groupby("points")[name].agg(["mean", "min", "max"])
                x = np.array([place[p] for p in found.index])
                around = [found["mean"] - found["min"], found["max"] - found["mean"]]
                panel.errorbar(x, found["mean"], yerr=around, color=color, marker=marker, ms=4, label=meaning)
            panel.set_yscale("log")
            panel.yaxis.set_minor_formatter(NullFormatter())
            panel.set_xticks(range(len(points)), [str(p) for p in points])
            if column == 0:
                panel.set_ylabel(label)
            if row == 1:
                panel.set_xlabel("Points learned")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=2)
    return figure
