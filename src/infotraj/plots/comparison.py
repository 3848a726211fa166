"""Model against measurement: time series with the band of the noise, errors over the floor, rollouts over the
horizon."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from infotraj.comparing.comparison import Comparison
from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.comparing.rollouts import MEASURES, UNITS
from infotraj.comparing.statistics import statistics, worst_flight
from infotraj.plots import style

MODEL_COLORS = (style.BLUE, style.VERMILION, style.GREEN, style.PURPLE, style.ORANGE)
SPAN = 10.0  # s of a flight that the time series show
_FLAT = 5.0  # a mean this many times the reach of the rest would leave the rest no room in a panel
_TICKS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)


def comparison_figures(comparison: Comparison, folder: str | Path) -> list[Path]:
    """Writes all figures of a comparison as PNG and PDF and returns the paths of the PNGs."""
    folder = Path(folder)
    figures = {"wrench": draw_wrench, "errors": draw_errors}
    if any(r.reason is None for r in comparison.models[0].rollouts):
        figures["rollouts"] = draw_rollouts
    written = []
    for name, draw in figures.items():
        png = folder / f"{name}.png"
        style.write(partial(draw, comparison), png, folder / f"{name}.pdf")
        written.append(png)
    return written


def draw_wrench(comparison: Comparison) -> Figure:
    """Measured and predicted wrench over the 10 s in which the worst flight is worst, and the residual over the flight.

    Left: measured in black, each model in its colour. Right: residual of each model with the band (2 floor) in which
    nothing is left to explain; the grey part is what the left side shows. Of one model a residual that is all but its
    mean is drawn beside it, and the mean is given as a number.
    """
    k = worst_flight(comparison.models[0].errors)
    first = comparison.models[0].errors[k]
    answered = [a for a in range(6) if first.scored[:, a].any()]
    start, stop = _worst_span(first)
    figure = style.figure(style.DOUBLE, 0.6 + 1.02 * len(answered))
    panels = figure.subplots(len(answered), 2, squeeze=False, sharex="col", width_ratios=[1.0, 1.15])
    inside = (first.t >= start) & (first.t <= stop)
    for row, a in enumerate(answered):
        what = "force" if a < 3 else "torque"
        alike = [i for i in answered if (i < 3) == (a < 3)]  # one unit for all forces, one for all torques
        shown = [
            first.measured[inside][:, alike],
            *(m.errors[k].predicted[inside][:, alike] for m in comparison.models),
        ]
        factor, unit = style.prefixed(first.unit[what], float(np.nanmax(np.abs(shown))))
        left, right = panels[row]
        left.plot(first.t[inside], factor * first.measured[inside, a], color=style.INK, lw=1.4, label="measured")
        if not inside.all():
            right.axvspan(start, stop, color="#F2F2F2", lw=0, zorder=0)
        floor = factor * first.floor[a]
        right.axhspan(-2 * floor, 2 * floor, color=style.SKY, alpha=0.45, lw=0, zorder=1, label="±2 floor: noise")
        residuals = [factor * m.errors[k].residual[:, a] for m in comparison.models]
        rms, taken = float(np.sqrt(np.nanmean(residuals[0] ** 2))), 0.0
        beside = residuals[0] - np.nanmean(residuals[0])
        if len(residuals) == 1 and abs(np.nanmean(residuals[0])) > _FLAT * max(_reach(beside), 2.6 * floor):
            taken = float(np.nanmean(residuals[0]))
            residuals = [beside]
        for m, (model, residual) in enumerate(zip(comparison.models, residuals, strict=True)):
            error, color = model.errors[k], MODEL_COLORS[m % len(MODEL_COLORS)]
            name = f"predicted by {Path(model.name).stem}"
            left.plot(error.t[inside], factor * error.predicted[inside, a], color=color, lw=1.0, label=name)
            right.plot(error.t, residual, color=color, lw=0.7, label=name, zorder=2)
        # one loss of signal must not squeeze the rest of the residual into a line
        low, high = np.nanpercentile(np.concatenate(residuals), [0.15, 99.85])
        low, high = min(low, -2.6 * floor), max(high, 2.6 * floor)
        room = 0.08 * (high - low) or 1.0  # 1: an exact model of a simulated flight
        right.set_ylim(low - room, high + room)
        left.set_ylabel(f"{AXES[a]} [{unit}]")
        text = f"RMSE {rms:.3g} {unit}" + (f", {rms / floor:.1f} × floor" if floor > 0 else "")
        text += f"; drawn less its mean of {taken:+.3g} {unit}".replace("-", "−") if taken else ""
        right.set_title(text, loc="right", fontsize=7.5, pad=1.5)
        left.set_xlim(first.t[inside][0], first.t[inside][-1])
        right.set_xlim(first.t[0], first.t[-1])
    panels[0, 0].set_title("measured and predicted", loc="left")
    panels[0, 1].set_title("residual", loc="left")
    for axes in panels[-1]:
        axes.set_xlabel("t [s]")
    handles = {}
    for axes in panels[0]:
        handles.update(dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True)))
    figure.legend(handles.values(), handles.keys(), loc="outside upper center", ncols=min(len(handles), 5))
    figure.supxlabel(Path(comparison.paths[k]).name, fontsize=7, color=style.GREY)
    return figure


def draw_errors(comparison: Comparison) -> Figure:
    """RMSE of every model and axis in units of the floor, every flight a point, and the share of variance explained."""
    figure = style.figure(style.DOUBLE, 2.7)
    left, right = figure.subplots(1, 2, width_ratios=[1.5, 1.0])
    width = 0.8 / len(comparison.models)
    for m, model in enumerate(comparison.models):
        color, s = MODEL_COLORS[m % len(MODEL_COLORS)], model.overall
        with np.errstate(invalid="ignore", divide="ignore"):
            over = s.rmse / s.floor
            flights = np.array([(f := statistics([e])).rmse / f.floor for e in model.errors])
        x = np.arange(6) + (m - 0.5 * (len(comparison.models) - 1)) * width
        label = Path(model.name).stem
        left.plot(x, over, "o", color=color, ms=6, mec="white", mew=0.6, label=label, zorder=3)
        if len(flights) > 1:
            spots = style.sideways(len(flights), 0.7 * width)
            left.plot((x[None] + spots[:, None]).ravel(), flights.ravel(), ".", color=color, ms=3, alpha=0.5, mew=0)
        right.bar(x, 100 * np.clip(s.explained, 0, 1), 0.9 * width, color=color, label=label)
        for place, value, answered in zip(x, s.explained, s.rows > 0, strict=True):
            text = "?" if not answered else (f"{100 * value:.0f}" if value > 0 else "≤0")
            right.annotate(
                text, (place, 100 * np.clip(np.nan_to_num(value), 0, 1)), ha="center", va="bottom", fontsize=6.5
            )
    left.axhspan(0.5, 1.1, color=style.SKY, alpha=0.45, lw=0)
    left.set_yscale("log")
    high = left.get_ylim()[1]
    left.set_ylim(0.7, max(high, 3.0))
    ticks = [v for v in _TICKS if v <= max(high, 3.0)]
    left.set_yticks(ticks, labels=[f"{v}" for v in ticks])
    left.minorticks_off()
    left.set_xticks(range(6), AXES)
    left.set_ylabel("RMSE over the noise floor")
    left.set_title("the band is the floor: nothing left to explain", loc="left")
    right.set_xticks(range(6), AXES)
    right.set_ylim(0, 112)
    right.set_ylabel("variance explained [%]")
    right.grid(visible=False, axis="x")
    if len(comparison.models) > 1:
        left.legend(loc="upper right")
    return figure


def draw_rollouts(comparison: Comparison) -> Figure:
    """Mean error of position, velocity, attitude and rate against the horizon; shaded: 10 to 90 % of all starts."""
    figure = style.figure(style.DOUBLE, 2.3)
    panels = figure.subplots(1, 4)
    for m, model in enumerate(comparison.models):
        used = [r for r in model.rollouts if r.reason is None and len(r.t)]
        if not used:
            continue
        color = MODEL_COLORS[m % len(MODEL_COLORS)]
        times = _seconds(comparison, model)
        order = np.argsort(times)
        for measure, axes in enumerate(panels):
            values = [np.concatenate([r.errors[:, h, measure] for r in used]) for h in order]
            values = [v[np.isfinite(v)] for v in values]
            there = [i for i, v in enumerate(values) if len(v)]
            x = times[order][there]
            low, high = (np.array([np.percentile(values[i], q) for i in there]) for q in (10, 90))
            axes.fill_between(x, low, high, color=color, alpha=0.15, lw=0)
            axes.plot(x, [values[i].mean() for i in there], "o-", color=color, ms=3, label=Path(model.name).stem)
    for axes, name in zip(panels, MEASURES, strict=True):
        axes.set_title(f"{name} [{UNITS[name]}]")
        axes.set_xlabel("horizon [s]")
        axes.set_ylim(bottom=0)
        axes.set_xlim(left=0)
    if len(comparison.models) > 1:
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _seconds(comparison: Comparison, model) -> np.ndarray:
    step = float(np.median(np.diff(comparison.flights[0].t)))
    return np.array([h.seconds if h.seconds is not None else h.steps * step for h in model.rollouts[0].horizons])


def _worst_span(error: EquationError) -> tuple[float, float]:
    """The SPAN seconds with the largest squared error in units of the floor."""
    with np.errstate(invalid="ignore", divide="ignore"):
        square = np.nansum((error.residual / error.floor) ** 2, axis=1)
    if error.t[-1] - error.t[0] <= SPAN:
        return float(error.t[0]), float(error.t[-1])
    total = np.concatenate([[0.0], np.cumsum(np.nan_to_num(square, posinf=0.0))])
    stops = np.searchsorted(error.t, error.t + SPAN)
    held = np.where(error.t + SPAN <= error.t[-1], total[stops] - total[: len(error.t)], -1.0)
    start = float(error.t[int(np.argmax(held))])
    return start, start + SPAN


def _reach(values: np.ndarray) -> float:
    return float(np.nanpercentile(np.abs(values), 99.7))
