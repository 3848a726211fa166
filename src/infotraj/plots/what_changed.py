"""What was done to a vehicle against what was answered, and a cut in millimetres against the rotor's factor."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from infotraj.plots import style

_ANSWERS = ("nothing", "rotor M3", "another rotor", "place or trim", "mass or all thrust", "other", "refused")
_TRIM = {"com_offset", "steady_torque", "mass_offset", "suspended_load", "steady_force"}
_THRUST = {"thrust_scale", "battery_sag", "thrust_exponent"}


def what_changed(made: pd.DataFrame, healthy: str, *paths: str | Path) -> None:
    """Draws the confusion and the sizes.

    made: a row a flight with group, condition, doubtful, found (groups of names), rotor (from 1), change, size (mm),
    refused; healthy: the condition without a change.
    """
    style.write(lambda: _drawn(made, healthy), *paths)


def _drawn(made: pd.DataFrame, healthy: str) -> Figure:
    order = [healthy, *sorted(set(made["condition"]) - {healthy})]
    figure = style.figure(style.DOUBLE, 0.24 * len(order) + 1.6)
    groups = sorted(set(made["group"]))
    panels = figure.subplots(1, len(groups) + 1, width_ratios=[*[1.0] * len(groups), 0.9])
    for panel, group in zip(panels, groups, strict=False):
        own = made[(made["group"] == group) & ~made["doubtful"]]
        count = np.zeros((len(order), len(_ANSWERS)))
        for _, row in own.iterrows():
            count[order.index(row["condition"]), _ANSWERS.index(_answer(row))] += 1
        panel.imshow(count, cmap="Blues", vmin=0, vmax=6, aspect="auto")
        for i, j in zip(*np.nonzero(count), strict=True):
            panel.text(j, i, f"{count[i, j]:.0f}", ha="center", va="center", fontsize=8)
        panel.set_xticks(range(len(_ANSWERS)), _ANSWERS, rotation=90)
        panel.grid(False)
        panel.set_title(group.replace("_", " "))
        panel.set_yticks(range(len(order)), [_words(x) for x in order] if panel is panels[0] else [""] * len(order))
    _sizes(panels[-1], made)
    return figure


def _answer(row: pd.Series) -> str:
    if row["refused"]:
        return "refused"
    names = {n for group in str(row["found"] or "").split("; ") for n in group.split("|") if n}
    if not names:
        return "nothing"
    if "rotor_effectiveness" in names:
        return "rotor M3" if row["rotor"] == 3 else "another rotor"
    if names & _TRIM and not names & _THRUST:
        return "place or trim"
    return "mass or all thrust" if names & _THRUST else "other"


def _words(condition: str) -> str:
    return condition.replace("_", " ").replace("cut propeller", "cut").replace("on propeller", "on")


def _sizes(panel: Axes, made: pd.DataFrame) -> None:
    looks = ((style.BLUE, "o"), (style.VERMILION, "s"))
    for (group, own), (color, marker) in zip(made.groupby("group"), looks, strict=False):
        cut = own[own["size"].notna() & (own["rotor"] == 3)]
        label = str(group).replace("_", " ")
        panel.plot(cut["size"], 100 * cut["change"], marker, color=color, ms=4, alpha=0.7, label=label)
    panel.axhline(0.0, color=style.GREY, lw=0.8)
    panel.set_xlabel("cut off M3's propeller (mm)")
    panel.set_ylabel("thrust of M3 (%)")
    panel.legend(loc="upper right", bbox_to_anchor=(1.0, 0.97))
