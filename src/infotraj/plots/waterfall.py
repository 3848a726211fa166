"""The waterfall: the held-out error of each axis, effect by effect, with its interval, above the noise floor."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from infotraj.plots import style
from infotraj.rotations import Array

_INTERVAL, _NOISE = "95 % interval, stretches of the flights resampled", "noise floor"
_PALE_BLUE = "#B8DCF2"


def waterfall(
    labels: Sequence[str],
    axes: Sequence[str],
    rmse: Array,
    low: Array,
    high: Array,
    floor: Array,
    unit: Mapping[str, str],
    *paths: Path,
    refused: Collection[str] = (),
) -> None:
    """Draws one panel an axis to each path (.pdf or .png).

    labels (m,): the steps; axes (6,): fx .. tz; rmse, low, high (m, 6) with 95 % interval and floor (6,) in `unit` of
    "force" and "torque". An axis with NaN in it is left out. refused: axes by which nothing was judged, drawn pale.
    """
    style.write(lambda: _drawn(labels, axes, rmse, low, high, floor, unit, refused), *paths)


def _drawn(labels, axes, rmse, low, high, floor, unit, refused) -> Figure:
    shown = [i for i in range(len(axes)) if np.isfinite(rmse[:, i]).all()]
    rows = 2 if len(shown) > 3 else 1
    columns = -(-max(len(shown), 1) // rows)
    figure = style.figure(style.DOUBLE, rows * (0.9 + 0.22 * len(labels)) + 0.2)
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True)
    place = np.arange(len(labels))
    handles = {}
    for panel, i in zip(panels.ravel(), shown, strict=False):
        what = "force" if axes[i][0] == "f" else "torque"
        # All panels of a quantity share its unit: their numbers are read against each other.
        largest = max(rmse[:, k].max() for k in shown if axes[k][0] == axes[i][0])
        factor, name = style.prefixed(unit[what], largest)
        value = factor * rmse[:, i]
        around = [np.maximum(value - factor * low[:, i], 0.0), np.maximum(factor * high[:, i] - value, 0.0)]
        left_out = axes[i] in refused
        first, further = (style.PALE, _PALE_BLUE) if left_out else (style.GREY, style.BLUE)
        panel.barh(place, value, color=[first, *[further] * (len(place) - 1)], height=0.6)
        bars = panel.errorbar(value, place, xerr=around, fmt="none", ecolor=style.INK, elinewidth=0.8)
        handles[_INTERVAL] = bars
        for y, number, end in zip(place, value, np.fmax(factor * high[:, i], value), strict=True):
            text = f"{number:#.3g}".rstrip(".")
            panel.annotate(text, (end, y), (4, 0), textcoords="offset points", va="center", fontsize=7,
                           bbox={"fc": "white", "ec": "none", "pad": 0.8, "alpha": 0.8})  # fmt: skip
        panel.set_xlim(right=1.22 * np.fmax(factor * high[:, i], value).max())  # room for the numbers
        if np.isfinite(floor[i]):
            handles[_NOISE] = panel.axvline(factor * floor[i], color=style.VERMILION, linewidth=1.0, linestyle="--")
        panel.set_title(f"{what} {axes[i][1]}" + (", not judged" if left_out else ""))
        panel.set_xlabel(f"held-out RMSE [{name}]")
        panel.set_yticks(place, labels)
        panel.locator_params(axis="x", nbins=4)
    panels[0, 0].invert_yaxis()
    # Outside: wherever it is put in a panel, some flights' bars reach it.
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=len(handles) or 1)
    for panel in panels.ravel()[len(shown) :]:
        panel.set_visible(False)
    return figure
