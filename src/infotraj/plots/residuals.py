"""Residuals over time and over lags: when a model fails, and whether what is left remembers itself or the commands."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from infotraj.comparing.equation_error import AXES
from infotraj.locating.locating import Located
from infotraj.plots import style

MOST_FLIGHTS = 6


def draw_time(located: Located) -> Figure:
    """RMS of each axis in every second of the worst flights, over the floor; white is noise. Framed: the windows
    named."""
    order = np.argsort([-np.nanmax(np.append(s.rmse / s.floor, 0.0)) for s in located.by_flight])[:MOST_FLIGHTS]
    figure = style.figure(style.DOUBLE, 0.7 + 1.0 * len(order))
    panels = figure.subplots(len(order), 1, squeeze=False)[:, 0]
    image: Any = None
    for axes, k in zip(panels, order, strict=True):
        error = located.errors[k]
        slot = np.floor(error.t - error.t[0]).astype(int)
        slot = np.minimum(slot, max(slot[-1] - 1, 0))  # the last row alone makes no second
        table = np.full((6, slot[-1] + 1), np.nan)
        for a in range(6):
            scored = error.scored[:, a]
            number = np.bincount(slot, scored, minlength=table.shape[1])
            squares = np.bincount(slot, np.where(scored, error.residual[:, a], 0.0) ** 2, minlength=table.shape[1])
            with np.errstate(invalid="ignore", divide="ignore"):
                table[a] = np.where(number > 5, np.sqrt(squares / number) / error.floor[a], np.nan)
        shown = np.where(table >= 1.5, table, np.where(np.isfinite(table), 1.0, np.nan))
        colours = style.mpl.colormaps["YlOrRd"].with_extremes(bad="#E4E4E4", under="white")
        extent = (error.t[0], error.t[0] + table.shape[1], 5.5, -0.5)
        image = axes.imshow(shown, cmap=colours, norm=LogNorm(1.5, 20.0), aspect="auto", extent=extent)
        axes.set_yticks(range(6), AXES)
        axes.grid(visible=False)
        axes.set_title(Path(located.paths[k]).name, loc="left", fontsize=8, pad=2)
        for window in located.windows:
            if window.flight == k:
                a = AXES.index(window.axis)
                frame = style.mpl.patches.Rectangle(
                    (window.start, a - 0.5), window.stop - window.start, 1.0, fill=False, ec=style.BLUE, lw=1.0
                )
                axes.add_patch(frame)
    panels[-1].set_xlabel("t [s]  (grey: not scored; framed: the worst windows)")
    bar = figure.colorbar(image, ax=list(panels), pad=0.01, fraction=0.035, extend="min")
    bar.set_label("RMS of 1 s over the floor")
    bar.set_ticks([1.5, 2, 5, 10, 20], labels=["1.5", "2", "5", "10", "20"])
    bar.minorticks_off()
    return figure


def draw_lags(located: Located) -> Figure:
    """The residual's autocorrelation and its correlation with the rate of change of the prediction, an axis each.

    Blue band: correlations that chance leaves (99 %). Grey: lags within the filter, which makes neighbours alike. A
    peak of the lower row at lag 0 with a minus sign is a measurement that comes late.
    """
    shown = located.lags
    figure = style.figure(style.DOUBLE, 2.9)
    panels = figure.subplots(2, max(len(shown), 1), squeeze=False, sharex=True, sharey="row")
    for column, lags in enumerate(shown):
        top, bottom = panels[:, column]
        for axes, values, from_zero in ((top, lags.auto, True), (bottom, lags.cross, False)):
            part = lags.lag >= 0 if from_zero else np.ones(len(lags.lag), dtype=bool)
            axes.axvspan(-lags.filter, lags.filter, color="#EFEFEF", lw=0, zorder=0)
            axes.axhspan(-lags.band, lags.band, color=style.SKY, alpha=0.45, lw=0, zorder=1)
            axes.plot(lags.lag[part], values[part], color=style.BLUE, lw=1.1, zorder=3)
            axes.axhline(0.0, color=style.GREY, lw=0.5)
        top.set_title(lags.axis)
        note = f"{1e3 * lags.delay:+.0f}±{1e3 * lags.standard_error:.0f} ms, {100 * lags.share:.0f} %"
        bottom.set_title(note, fontsize=7.5, color=style.VERMILION if lags.late else style.GREY)
        bottom.set_xlabel("lag [s]")
    panels[0, 0].set_ylabel("with itself")
    panels[1, 0].set_ylabel("with the prediction's\nrate of change")
    return figure
