"""The waterfall: the held-out error of each axis, effect by effect, with its interval, above the noise floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from infotraj.plots import style
from infotraj.rotations import Array


def waterfall(
    labels: Sequence[str],
    axes: Sequence[str],
    rmse: Array,
    low: Array,
    high: Array,
    floor: Array,
    unit: Mapping[str, str],
    *paths: Path,
) -> None:
    """Draws one panel an axis to each path (.pdf or .png).

    labels (m,): the steps; axes (6,): fx .. tz; rmse, low, high (m, 6) with 95 % interval and floor (6,) in `unit` of
    "force" and "torque". An axis with NaN in it is left out.
    """
    style.write(lambda: _drawn(labels, axes, rmse, low, high, floor, unit), *paths)


def _drawn(labels, axes, rmse, low, high, floor, unit) -> Figure:
    shown = [i for i in range(len(axes)) if np.isfinite(rmse[:, i]).all()]
    rows = 2 if len(shown) > 3 else 1
    columns = -(-max(len(shown), 1) // rows)
    figure = style.figure(style.DOUBLE, rows * (0.9 + 0.22 * len(labels)))
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True)
    place = np.arange(len(labels))
    for panel, i in zip(panels.ravel(), shown, strict=False):
        value = rmse[:, i]
        around = [np.maximum(value - low[:, i], 0.0), np.maximum(high[:, i] - value, 0.0)]
        panel.barh(place, value, color=[style.GREY, *[style.BLUE] * (len(place) - 1)], height=0.6)
        panel.errorbar(value, place, xerr=around, fmt="none", ecolor=style.INK, elinewidth=0.8)
        if np.isfinite(floor[i]):
            panel.axvline(floor[i], color=style.VERMILION, linewidth=1.0, linestyle="--", label="sensor noise")
        what = "force" if axes[i][0] == "f" else "torque"
        panel.set_title(f"{what} {axes[i][1]}")
        panel.set_xlabel(f"held-out RMSE ({unit[what]})")
        panel.set_yticks(place, labels)
        panel.locator_params(axis="x", nbins=4)
        panel.ticklabel_format(axis="x", scilimits=(-2, 4))
    panels[0, 0].invert_yaxis()
    if shown and np.isfinite(floor[shown[0]]):
        panels[0, 0].legend(loc="lower right")
    for panel in panels.ravel()[len(shown) :]:
        panel.set_visible(False)
    return figure
