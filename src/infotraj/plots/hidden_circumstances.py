"""The hidden-effect study: false alarms against how wrong the vehicle file is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from infotraj.plots import style

_LOOKS = {
    "false alarms": (style.VERMILION, "o", "a name that states no error of the file"),
    "file errors named as effects": (style.BLUE, "s", "an error of the file, named as an effect"),
}


def figure_false_alarms(table: pd.DataFrame, pdf: str | Path, png: str | Path) -> None:
    """Writes the shares of runs with nothing hidden (`hidden_circumstances.false_alarm_curve`)."""
    style.checked(table, ("vehicle", "what", "off", "share", "low", "high"), "false alarms")
    style.write(lambda: draw_false_alarms(table), pdf, png)


def draw_false_alarms(table: pd.DataFrame) -> Figure:
    """The figure itself: a panel a vehicle, and all together; 95 % intervals."""
    vehicles = list(dict.fromkeys(table["vehicle"]))
    figure = style.figure(style.DOUBLE, 2.3)
    panels = figure.subplots(1, len(vehicles), squeeze=False, sharey=True)[0]
    for axes, vehicle in zip(panels, vehicles, strict=True):
        own = table[table["vehicle"] == vehicle]
        for k, (what, (color, marker, label)) in enumerate(_LOOKS.items()):
            part = own[own["what"] == what]
            around = np.clip([part["share"] - part["low"], part["high"] - part["share"]], 0.0, None)
            axes.errorbar(
                part["off"] + 0.15 * (k - 0.5), part["share"], yerr=around, color=color, marker=marker, markersize=3.5,
                lw=0.9, elinewidth=0.7, capsize=2.0, label=label,
            )  # fmt: skip
        axes.set_title(vehicle, fontsize=8, loc="left")
        axes.set_xlabel("error of the vehicle file [%]")
    panels[0].set_ylabel("share of runs, nothing hidden")
    panels[0].set_ylim(bottom=-0.01)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure
