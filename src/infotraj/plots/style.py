"""One look for all figures: sizes, fonts, colours, and files that are the same at every run."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from infotraj.errors import InputError, problem
from infotraj.evaluation.intervals import Interval
from infotraj.rotations import Array
from infotraj.writing import whole

SINGLE, DOUBLE = 3.5, 7.16  # inches: one and two columns of the IEEE page

# Okabe and Ito (2008): told apart by the colour-blind, and in print by the markers beside them.
BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9"
INK, GREY, PALE = "#222222", "#777777", "#C8C8C8"

# Who chose the flight that was learned from: nobody (the task again), chance, the paper's cost, ours.
COLORS = {
    "informative": BLUE,
    "paper": ORANGE,
    "random": GREEN,
    "task": VERMILION,
    "prior": GREY,
    "none": PURPLE,
}
MARKERS = {"informative": "o", "paper": "v", "random": "X", "task": "s", "prior": "D", "none": "^"}
LABELS = {
    "informative": "informative (our cost)",
    "paper": "informative (the paper's cost)",
    "random": "random candidate",
    "task": "non-informative (task)",
    "prior": "prior only",
    "none": "no learning",
}

PREFIXES = (("", 1.0), ("m", 1e3), ("\N{MICRO SIGN}", 1e6))

RC: dict[Any, Any] = {
    "font.family": "serif",
    "font.serif": ["STIXGeneral"],
    "mathtext.fontset": "stix",
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.0,
    "legend.fontsize": 8.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "legend.handlelength": 1.4,
    "errorbar.capsize": 2.0,
    "pdf.fonttype": 42,
    "savefig.dpi": 200,
}


def figure(width: float, height: float) -> Figure:
    """An empty figure of width x height inches whose parts keep clear of each other."""
    return Figure(figsize=(width, height), layout="constrained")


def write(draw: Callable[[], Figure], *paths: str | Path) -> None:
    """Draws in this style and writes to each path (.pdf or .png), whole or not at all, the same bytes every time."""
    with mpl.rc_context(RC):
        drawn = draw()
        for path in map(Path, paths):
            metadata = {"CreationDate": None} if path.suffix == ".pdf" else {"Software": None}
            with whole(path) as part:
                drawn.savefig(part, format=path.suffix.removeprefix("."), metadata=metadata)


def checked(table: pd.DataFrame, columns: Iterable[str], what: str) -> pd.DataFrame:
    """The table itself. InputError, one line, where it is empty or a column is missing."""
    columns = tuple(columns)
    missing = [c for c in columns if c not in table]
    if missing:
        raise InputError(
            problem(f"{what}: no column {', '.join(missing)}", ", ".join(columns), "Write the table again.")
        )
    if table.empty:
        raise InputError(problem(f"{what}: no rows", "at least one", "Run what it is made from."))
    return table


def prefixed(unit: str, largest: float) -> tuple[float, str]:
    """What values up to `largest`, in `unit`, are multiplied by to be shown in the unit that is given with it.

    N and N m get the prefix that leaves `largest` at 1 or above; other units stay as they are.
    """
    options = PREFIXES if unit.startswith("N") else PREFIXES[:1]
    prefix, factor = next((o for o in options if largest * o[1] >= 1.0), options[-1])
    return factor, prefix + unit.replace("^2", "$^2$")


def sideways(count: int, width: float) -> Array:
    """Offsets (count,) within +-width/2 that keep neighbouring points apart; the same for the same count."""
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    return width * (np.mod(golden * np.arange(1, count + 1), 1.0) - 0.5)


def add_runs(axes: Axes, x: float, values: Array, interval: Interval, color: str, marker: str, width: float) -> None:
    """Every run as a small point left of x, and their mean with its 95 % interval right of it."""
    left, right = x - 0.25 * width, x + 0.4 * width
    offsets = sideways(len(values), 0.6 * width)
    axes.plot(left + offsets, values, ".", color=color, alpha=0.5, markersize=3.5, mew=0, zorder=2)
    around = [[interval.mean - interval.low], [interval.high - interval.mean]]
    look: dict[str, Any] = {"color": color, "marker": marker, "markersize": 3.8, "mec": "white", "mew": 0.4}
    axes.errorbar(right, interval.mean, yerr=around, lw=1.0, zorder=4, **look)
