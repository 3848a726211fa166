"""The hidden-effect study: how near the fitted numbers come to the true ones, and whether their intervals hold them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from infotraj.plots import style

_FAR = 5.0  # standard errors: farther numbers are drawn there
_INSIDE = 1.96
_LOOKS = ((False, "clean", style.BLUE, "o", 0.0), (True, "with clutter", style.ORANGE, "^", 0.25))


def figure_numbers(table: pd.DataFrame, pdf: str | Path, png: str | Path) -> None:
    """Writes how far fitted numbers are off: of their standard errors, and of the true size.

    table: a row a number of a named effect (`hidden_tables.runs_table`, the second).
    """
    columns = ("vehicle", "clutter", "effect", "parameter", "true", "estimate", "standard_error")
    style.checked(table, columns, "fitted numbers")
    style.write(lambda: draw_numbers(table), pdf, png)


def draw_numbers(table: pd.DataFrame) -> Figure:
    """The figure itself: a row of two panels a vehicle, a line an effect."""
    vehicles = list(dict.fromkeys(table["vehicle"]))
    heights = [table[table["vehicle"] == v]["effect"].nunique() + 3 for v in vehicles]
    figure = style.figure(style.DOUBLE, 0.14 * sum(heights) + 0.7 * len(vehicles) + 0.3)
    grid = figure.subplots(len(vehicles), 2, squeeze=False, sharey="row", height_ratios=heights)
    for (left, right), vehicle in zip(grid, vehicles, strict=True):
        part = table[table["vehicle"] == vehicle]
        _off(left, right, part)
        left.set_title(vehicle, loc="left", fontsize=8)
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def _off(left: Axes, right: Axes, part: pd.DataFrame) -> None:
    effects = sorted(set(part["effect"]), reverse=True)
    left.axvspan(-_INSIDE, _INSIDE, color=style.PALE, alpha=0.5, lw=0, label="95 % interval")
    for clutter, label, color, marker, shift in _LOOKS:
        own = part[part["clutter"].astype(bool) == clutter]
        off = (own["estimate"] - own["true"]).to_numpy(dtype=float)
        size = own.groupby(["effect", "parameter"])["true"].transform(lambda x: np.sqrt(np.mean(x**2)))
        rows = np.array([effects.index(e) for e in own["effect"]], dtype=float) - shift
        look: dict[str, Any] = {"ls": "none", "marker": marker, "ms": 2.5, "mew": 0, "alpha": 0.7, "color": color}
        left.plot(np.clip(off / own["standard_error"], -_FAR, _FAR), rows, label=label, **look)
        right.plot(np.maximum(100 * np.abs(off) / size, 1e-2), rows, **look)
    clean = part[~part["clutter"].astype(bool)]
    for row, effect in enumerate(effects):
        own = clean[clean["effect"] == effect]
        held = ((own["estimate"] - own["true"]).abs() <= _INSIDE * own["standard_error"]).sum()
        if len(own):
            left.text(1.06 * _FAR, row, f"{held}/{len(own)}", fontsize=5, va="center", ha="left", clip_on=False)
    left.set_xlim(-1.04 * _FAR, 1.3 * _FAR)
    left.set_yticks(range(len(effects)), effects, fontsize=6)
    left.set_xlabel("off by [standard errors]; right: clean numbers in the interval")
    right.set_xscale("log")
    right.set_xlabel("off by [% of the true size]")
