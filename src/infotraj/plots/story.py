"""The product's story in five panels: the model fails, where, the name, the error falls, the flight gets better."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from infotraj.plots import style
from infotraj.rotations import Array

_WIDTH, _HEIGHT, _DPI = 8.4, 5.9, 240  # inches; 2016 pixels wide
_MATTERS = 0.05  # rise below which an effect is negligible, the diagnosis's own limit
_VERDICTS = {"Supported": style.BLUE, "Not separable": style.SKY, "Plausible": style.ORANGE}


@dataclass(frozen=True)
class Wrench:
    """One axis along a flight: t (n,) s, measured, predicted as given and with the named effects, in `unit`."""

    t: Array
    measured: Array
    given: Array
    named: Array
    axis: str
    unit: str


@dataclass(frozen=True)
class Place:
    """Residual (n,) of one axis as given and with the named effects, against a quantity (n,)."""

    quantity: Array
    given: Array
    named: Array
    axis: str
    unit: str
    name: str
    quantity_unit: str


@dataclass(frozen=True)
class Ranking:
    """Effects, the largest rise first: names, rise over the noise floor, verdicts."""

    names: Sequence[str]
    rise: Array
    verdicts: Sequence[str]


@dataclass(frozen=True)
class Fall:
    """Held-out RMSE over the floor by step: axis to value, low and high, each (steps,)."""

    labels: Sequence[str]
    axes: Mapping[str, tuple[Array, Array, Array]]


@dataclass(frozen=True)
class Flown:
    """Tracking errors (mm) of one controller, one a seed, their mean with its 95 % interval, and what kind it is."""

    label: str
    values: Array
    mean: float
    low: float
    high: float
    kind: str


@dataclass(frozen=True)
class Story:
    """What the five panels show."""

    wrench: Wrench
    place: Place
    ranking: Ranking
    fall: Fall
    flown: Sequence[Flown]


def draw(story: Story, *paths: Path) -> None:
    """Draws the figure to each path (.pdf or .png)."""
    style.write(lambda: _drawn(story), *paths)


def _drawn(story: Story) -> Figure:
    mpl.rcParams["savefig.dpi"] = _DPI  # inside the style's own context
    figure = style.figure(_WIDTH, _HEIGHT)
    # Rows of their own: the long labels below shall not push the panels above apart.
    halves: Any = figure.subfigures(2, 1, height_ratios=[1.0, 1.2])
    above, below = halves
    first, second = above.subplots(1, 2, width_ratios=[1.7, 1.0])
    _wrench(first, story.wrench)
    _place(second, story.place)
    third, fourth, fifth = below.subplots(1, 3, width_ratios=[1.15, 0.95, 1.3])
    _ranking(third, story.ranking)
    _fall(fourth, story.fall)
    _flown(fifth, story.flown)
    return figure


def _title(panel: Axes, letter: str, text: str) -> None:
    panel.set_title(rf"$\bf{{{letter}}}$  {text}", loc="left", fontsize=10.0)


def _wrench(panel: Axes, w: Wrench) -> None:
    _title(panel, "a", "The model and the flight disagree")
    panel.plot(w.t, w.measured, color=style.PALE, lw=4.0, label="measured", solid_capstyle="round")
    panel.plot(w.t, w.given, color=style.VERMILION, lw=1.3, label="model as given")
    panel.plot(w.t, w.named, color=style.BLUE, lw=1.1, ls=(0, (4, 1.5)), label="with the named effects")
    low = min(w.measured.min(), w.given.min())
    high = max(w.measured.max(), w.given.max())
    panel.set_ylim(low - 0.06 * (high - low), high + 0.28 * (high - low))
    panel.set_xlim(w.t[0], w.t[-1])
    panel.set_xlabel("Time (s)")
    panel.set_ylabel(f"{_word(w.axis)} ({w.unit})")
    panel.legend(ncols=3, loc="upper left", borderaxespad=0.2, columnspacing=1.4)


def _place(panel: Axes, p: Place) -> None:
    _title(panel, "b", "Where it fails")
    step = max(len(p.quantity) // 1200, 1)
    look: dict[str, Any] = {"ls": "none", "marker": ".", "ms": 2.6, "mew": 0, "rasterized": True}
    panel.plot(p.quantity[::step], p.given[::step], color=style.VERMILION, alpha=0.45, **look)
    panel.plot(p.quantity[::step], p.named[::step], color=style.BLUE, alpha=0.45, **look)
    panel.axhline(0.0, color=style.INK, lw=0.6)
    panel.set_xlabel(f"{p.name[0].upper()}{p.name[1:]} ({p.quantity_unit})")
    panel.set_ylabel(f"{_word(p.axis)}, measured\nminus predicted ({p.unit})")
    for label, color in (("model as given", style.VERMILION), ("with the named effects", style.BLUE)):
        panel.plot([], [], ls="none", marker="o", ms=4, mew=0, color=color, label=label)
    low, high = panel.get_ylim()
    panel.set_ylim(low, high + 0.3 * (high - low))
    panel.legend(loc="upper right", borderaxespad=0.2, handletextpad=0.1)


def _ranking(panel: Axes, r: Ranking) -> None:
    _title(panel, "c", "What is missing")
    place = np.arange(len(r.names))
    rise = np.maximum(r.rise, 1e-4)
    color = [_VERDICTS.get(v, style.PALE) for v in r.verdicts]
    panel.barh(place, rise, left=1e-4, color=color, height=0.62)
    panel.set_xscale("log")
    panel.set_xlim(1e-4, max(rise) * 30.0)
    panel.axvline(_MATTERS, color=style.INK, lw=0.8, ls="--")
    inside = np.log10(rise.max() / 1e-4) * 0.45
    for k, verdict in enumerate(r.verdicts):
        far = np.log10(rise[k] / 1e-4) > inside
        at, align = (rise[k] * 0.6, "right") if far else (max(rise[k], _MATTERS) * 1.7, "left")
        panel.text(at, k, verdict, va="center", ha=align, fontsize=8.0, color="white" if far else style.INK)
    panel.set_yticks(place, [n.replace("_", " ") for n in r.names])
    panel.invert_yaxis()
    panel.grid(axis="y", visible=False)
    panel.set_xlabel("Rise of the held-out error without it\n(noise floors; dashed: least that matters)")


def _fall(panel: Axes, f: Fall) -> None:
    _title(panel, "d", "The error falls")
    place = np.arange(len(f.labels))
    looks = ((style.BLUE, "o"), (style.GREEN, "s"))
    for (axis, (value, low, high)), (color, marker) in zip(f.axes.items(), looks, strict=False):
        around = [np.maximum(value - low, 0.0), np.maximum(high - value, 0.0)]
        label = _word(axis)
        panel.errorbar(place, value, yerr=around, color=color, marker=marker, ms=4.5, mec="white", mew=0.5, label=label)
    panel.axhline(1.0, color=style.VERMILION, lw=1.0, ls="--")
    panel.text(-0.3, 1.08, "noise floor", color=style.VERMILION, ha="left", va="bottom", fontsize=8.0)
    panel.set_yscale("log")
    top = max(v[2].max() for v in f.axes.values())
    panel.set_ylim(0.7, top * 4.0)
    panel.set_xlim(-0.35, place[-1] + 0.4)
    panel.set_xticks(place, [_wrapped(label) for label in f.labels])
    panel.set_ylabel("Held-out RMSE over floor")
    panel.legend(loc="upper right", borderaxespad=0.2)


def _flown(panel: Axes, flown: Sequence[Flown]) -> None:
    _title(panel, "e", "The next flight is better")
    bars = [f for f in flown if f.kind != "oracle"]
    colors = {"nominal": style.VERMILION, "gp": style.ORANGE, "right": style.BLUE, "both": style.GREEN}
    for k, f in enumerate(bars):
        color = colors.get(f.kind, style.GREY)
        panel.barh(k, f.mean, color=color, height=0.66, alpha=0.85)
        offsets = style.sideways(len(f.values), 0.4)
        panel.plot(f.values, k + offsets, ".", color=style.INK, ms=2.5, mew=0, alpha=0.6)
        around = [[f.mean - f.low], [f.high - f.mean]]
        panel.errorbar(f.mean, k, xerr=around, fmt="none", ecolor=style.INK, elinewidth=1.0)
        panel.text(max(f.high, f.values.max()) + 3.0, k, f"{f.mean:.0f}", va="center", fontsize=8.0)
    best = [f for f in flown if f.kind == "oracle"]
    if best:
        panel.axvline(best[0].mean, color=style.INK, lw=0.9, ls="--")
    panel.set_yticks(np.arange(len(bars)), [f.label for f in bars])
    panel.invert_yaxis()
    panel.grid(axis="y", visible=False)
    panel.set_xlim(0.0, 1.15 * max(max(f.high, f.values.max()) for f in bars))
    panel.set_xlabel("Distance of the rotors from the reference\n(mm RMS; dashed: with the true effects)")


def _word(axis: str) -> str:
    return f"{'Force' if axis[0] == 'f' else 'Torque'} {axis[1]}"


def _wrapped(label: str) -> str:
    words = label.removeprefix("+ ")
    if words == label:
        return "as\ngiven"
    first, _, rest = words.partition(" ")
    return f"+ {first}\n{rest}"
