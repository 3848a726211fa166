"""Where a model fails: axis against quantity as a heat map, residuals against the quantities that name the places."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from infotraj.locating import sentences
from infotraj.locating.locating import Located
from infotraj.locating.places import ALPHA, LEAST_EXCESS, Found, Place
from infotraj.locating.ranges import by_range, place_spans
from infotraj.plots import residuals, style

MOST_PLACES, MOST_NAMED = 6, 8  # panels of residuals; places that the heat map numbers and says in words
_TICKS = (0.3, 1, 3, 10, 30, 100, 300, 1000, 3000, 10000)


def place_figures(located: Located, folder: str | Path) -> list[Path]:
    """Writes all figures of what was located as PNG and PDF and returns the paths of the PNGs."""
    folder = Path(folder)
    figures = {"places": draw_places, "time": residuals.draw_time, "lags": residuals.draw_lags}
    if located.places:
        figures = {"places": draw_places, "residuals": draw_residuals, **figures}
    written = []
    for name, draw in figures.items():
        png = folder / f"{name}.png"
        style.write(partial(draw, located), png, folder / f"{name}.pdf")
        written.append(png)
    return written


def draw_places(located: Located) -> Figure:
    """Heat map: how much squared error of each axis goes with each quantity, in units of the floor's square.

    Numbers on the map: the places that are named above it, worst first. Cells within the floor stay white.
    A quantity meant for one axis alone (the tilt rate as it turns fx) shares a column with its siblings.
    """
    columns, rows = _columns(located)
    table = np.full((len(rows), len(columns)), np.nan)
    for found in located.found:
        for a, axis in enumerate(found.samples.axes):
            for k, name in enumerate(found.search.names):
                if np.isfinite(found.search.score[a, k]):
                    excess = _excess(found, a, k)
                    i, j = rows.index(axis), columns.index(_short(name))
                    table[i, j] = np.nanmax([table[i, j], excess])
    figure = style.figure(style.DOUBLE, 1.5 + 0.33 * len(rows) + 0.13 * min(len(located.places), MOST_NAMED))
    axes = figure.subplots()
    shown = np.where(table > LEAST_EXCESS, table, np.nan)
    top = max(10.0, float(np.nanmax(shown)) if np.isfinite(shown).any() else 10.0)
    image = axes.imshow(shown, cmap="YlOrRd", norm=LogNorm(LEAST_EXCESS, top), aspect="auto")
    axes.set_xticks(range(len(columns)), columns, rotation=38, ha="right", rotation_mode="anchor")
    axes.set_yticks(range(len(rows)), rows)
    axes.set_xticks(np.arange(len(columns) + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(len(rows) + 1) - 0.5, minor=True)
    axes.grid(which="minor", color="#DDDDDD", lw=0.5)
    axes.grid(which="major", visible=False)
    axes.tick_params(which="minor", length=0)
    for n, place in enumerate(located.places[:MOST_NAMED]):
        at = (columns.index(_short(place.quantity.name)), rows.index(place.axis))
        color = "white" if table[at[1], at[0]] > 0.3 * top else style.INK
        axes.annotate(str(n + 1), at, ha="center", va="center", weight="bold", color=color, fontsize=10)
    bar = figure.colorbar(image, ax=axes, pad=0.01, fraction=0.04)
    bar.set_label("squared error that goes with it,\nover floor$^2$ (white: none)")
    ticks = [v for v in _TICKS if LEAST_EXCESS <= v <= top]
    bar.set_ticks(ticks, labels=[f"{v:g}" for v in ticks])
    bar.minorticks_off()
    if not located.places:
        axes.set_title("no place: what is left is the noise floor, or the same everywhere", loc="left")
    else:
        lines = [_headline(n, p) for n, p in enumerate(located.places[:MOST_NAMED])]
        axes.set_title("\n".join(lines), loc="left", fontsize=8, linespacing=1.15)
    return figure


def draw_residuals(located: Located) -> Figure:
    """Residual against the quantity of each place, worst first, with the band in which nothing is left to explain.

    Points: all flights. Line: mean of each of 12 ranges, dashed: its RMS. Shaded red: the place.
    """
    shown = located.places[:MOST_PLACES]
    columns = min(3, len(shown))
    rows = -(-len(shown) // columns)
    figure = style.figure(style.DOUBLE, 0.35 + 2.25 * rows)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels[len(shown) :]:
        axes.set_visible(False)
    for n, (axes, place) in enumerate(zip(panels, shown, strict=False)):
        found = next(f for f in located.found if place.axis in f.samples.axes)
        _residual_panel(axes, n, place, found)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
    return figure


def _residual_panel(axes: Axes, n: int, place: Place, found: Found) -> None:
    a = found.samples.axes.index(place.axis)
    x, y = place.quantity.values, found.samples.residual[:, a]
    axes.axhspan(-2 * place.floor, 2 * place.floor, color=style.SKY, alpha=0.5, lw=0, zorder=1, label="±2 floor: noise")
    low, high = np.percentile(x, [0.3, 99.7])
    if place.region is not None and place.region.low > 1.0:
        for k, (start, stop) in enumerate(place_spans(place.region, low, high)):
            axes.axvspan(
                start, stop, color=style.VERMILION, alpha=0.12, lw=0, zorder=0, label=None if k else "the place"
            )
    axes.plot(x, y, ".", color=style.GREY, ms=2, alpha=0.45, mew=0, zorder=2, label="samples")
    middle, mean, rms = by_range(x, y)
    axes.plot(middle, mean, "o-", color=style.BLUE, ms=2.5, lw=1.2, zorder=4, label="mean")
    # On top, for where the mean is positive and the spread small the two are one line.
    axes.plot(middle, rms, "--", color=style.VERMILION, lw=1.0, zorder=5, label="RMS")
    axes.set_xlim(low, high)
    reach = 1.1 * max(np.percentile(np.abs(y), 99.5), 2.5 * place.floor)
    axes.set_ylim(-reach, reach)
    axes.set_xlabel(f"{_short(place.quantity.name)} [{place.quantity.unit}]")
    axes.set_ylabel(f"{place.axis} residual [{place.unit}]".replace("^2", "$^2$"))
    axes.set_title(f"{n + 1}. {place.axis}: {100 * place.explained:.0f} % follows", loc="left")


def _headline(n: int, place: Place) -> str:
    at = place.region
    text = f"{n + 1}. {place.axis}: "
    if at is not None and at.low > 1.0:
        where = sentences.condition(place.quantity, at).replace(place.quantity.name, _short(place.quantity.name))
        return (
            text
            + f"{at.ratio:.1f} times the rest when {where} "
            + f"({100 * at.samples:.0f} % of the samples, {100 * at.squares:.0f} % of the squared error)"
        )
    return (
        text
        + f"follows the {_short(place.quantity.name)} "
        + f"({100 * place.explained:.0f} % of the squared error beside the mean)"
    )


def _excess(found: Found, a: int, k: int) -> float:
    axis, name, floor = found.samples.axes[a], found.search.names[k], found.samples.floor[a]
    if not floor > 0:
        return 0.0
    excess = [p.excess for p in found.places if p.axis == axis and p.quantity.name == name]
    if found.search.p[a, k] <= ALPHA:
        variance = float(np.var(found.samples.residual[:, a]))
        excess.append(max(found.search.explained[a, k], 0.0) * variance / floor**2)
    return max(excess, default=0.0)


def _columns(located: Located) -> tuple[list[str], list[str]]:
    names = [n for found in located.found for n in found.search.names]
    return list(dict.fromkeys(_short(n) for n in names)), [a for found in located.found for a in found.samples.axes]


def _short(name: str) -> str:
    for start, short in (
        ("tilt rate of the arms times thrust", "tilt rate x thrust"),
        ("change of the rotors' thrust", "change of thrust"),
        ("change of the commanded wrench", "change of command"),
    ):
        if name.startswith(start):
            return short
    return name
