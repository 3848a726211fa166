"""The figures of the page that are drawn on a canvas, as a Bokeh document: series, residuals, correlations.

Colours come from the page (assets/page.js), which knows whether it is light or dark; here every part gets a role.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import bokeh
import numpy as np
from bokeh.document import Document
from bokeh.models import ColumnDataSource, Range1d
from bokeh.models.annotations import BoxAnnotation, Span
from bokeh.plotting import figure

from infotraj.report.formats import plain_unit, prefixed, signed
from infotraj.report.series import unpacked

_JAVASCRIPT = Path(bokeh.__file__).parent / "server/static/js/bokeh.min.js"
_SERIES = ("measured", "given", "ticked", "left_given", "left_ticked")


def javascript() -> bytes:
    """Bokeh's own JavaScript, to be part of the page."""
    return _JAVASCRIPT.read_bytes()


def figures(content: dict[str, Any]) -> str:
    """Four documents as JSON text, in the order in which the page draws them; their roots are named trace-AXIS,
    place-NUMBER, leftover-AXIS and next-VIEW."""
    documents = []
    for roots in (_traces(content), _places(content), _leftover(content), _next(content)):
        document = Document()
        for root in roots:
            document.add_root(root)
        documents.append(document.to_json(deferred=False))
    return json.dumps(documents)


def _traces(content: dict[str, Any]) -> list[figure]:
    """Measured and predicted wrench, an axis each, linked in time; the page fills in the series."""
    traces = content["traces"]
    shared = Range1d(start=0.0, end=1.0, name="time")
    drawn = []
    for axis in traces["axes"]:
        fig = _figure(f"trace-{axis}", 200, "xbox_zoom", x_range=shared)
        fig.window_axis = "x"
        fig.y_range.update(only_visible=True)
        factor, unit = _scale(content, axis)
        fig.yaxis.axis_label = f"{axis} [{unit}]"
        fig.tags = [factor]
        fig.xaxis.axis_label = "t [s]"
        source = ColumnDataSource({"t": [0.0, 1.0], **{name: [0.0, 0.0] for name in _SERIES}}, name=f"series-{axis}")
        floor = content["fall"]["floor"][axis]
        if floor is not None:
            floor *= factor
            fig.add_layout(
                BoxAnnotation(bottom=-2 * floor, top=2 * floor, tags=["band"], line_color=None, visible=False)
            )
        for name in _SERIES:
            width = 3.2 if name == "measured" else 1.3
            line = fig.line("t", name, source=source, line_width=width, visible=not name.startswith("left_"))
            line.tags = [name.removeprefix("left_"), name]
        drawn.append(fig)
    return drawn


def _scale(content: dict[str, Any], axis: str) -> tuple[float, str]:
    """The factor and the unit in which an axis is drawn."""
    return prefixed(content["unit"][axis], content["traces"]["peak"][axis])


def _places(content: dict[str, Any]) -> list[figure]:
    """The residual against the quantity that names a place, with the band in which nothing is left to explain."""
    drawn = []
    for k, place in enumerate(content["places"]):
        fig = _figure(f"place-{k}", 230, "")
        fig.x_range = Range1d(place["low"], place["high"])
        factor, unit = prefixed(place["unit"], max(-place["bottom"], place["top"]))
        fig.y_range = Range1d(factor * place["bottom"], factor * place["top"])
        fig.xaxis.axis_label = f"{place['quantity']} [{plain_unit(place['quantity_unit'])}]"
        beside = f" beside {signed(factor * place['off'])}" if place["off"] else ""
        fig.yaxis.axis_label = f"{place['axis']} residual{beside} [{unit}]"
        for left, right in place["spans"]:
            fig.add_layout(BoxAnnotation(left=left, right=right, tags=["place"], line_color=None, level="underlay"))
        fig.add_layout(
            BoxAnnotation(
                bottom=-2 * factor * place["floor"],
                top=2 * factor * place["floor"],
                tags=["band"],
                line_color=None,
                level="underlay",
            )
        )
        rows = ColumnDataSource({"x": unpacked(place["x"]), "y": factor * unpacked(place["y"])})
        fig.scatter("x", "y", source=rows, size=2.5, fill_alpha=0.35, line_color=None).tags = ["point"]
        heights = {key: factor * unpacked(place[key]) for key in ("mean", "rms")}
        ranges = ColumnDataSource({"middle": unpacked(place["middle"]), **heights})
        fig.line("middle", "mean", source=ranges, line_width=2.2).tags = ["ticked"]
        fig.scatter("middle", "mean", source=ranges, size=5, line_color=None).tags = ["ticked"]
        # On top, for where the mean is positive and the spread small the two are one line.
        fig.line("middle", "rms", source=ranges, line_width=1.8, line_dash="dashed").tags = ["given"]
        drawn.append(fig)
    return drawn


def _leftover(content: dict[str, Any]) -> list[figure]:
    """Correlations over lags of what is left with everything that is supported."""
    drawn = []
    shared, height = Range1d(start=-0.5, end=0.5), Range1d(start=-1.05, end=1.05)
    for row in content["leftover"]:
        fig = _figure(f"leftover-{row['axis']}", 170, "", x_range=shared, y_range=height)
        fig.xaxis.axis_label = "lag [s]"
        fig.yaxis.axis_label = f"{row['axis']} correlation"
        fig.add_layout(
            BoxAnnotation(left=-row["filter"], right=row["filter"], tags=["filter"], line_color=None, level="underlay")
        )
        fig.add_layout(
            BoxAnnotation(bottom=-row["band"], top=row["band"], tags=["band"], line_color=None, level="underlay")
        )
        source = ColumnDataSource({key: unpacked(row[key]) for key in ("lag", "auto", "cross")})
        fig.line("lag", "auto", source=source, line_width=1.8).tags = ["ticked"]
        fig.line("lag", "cross", source=source, line_width=1.8, line_dash="dashed").tags = ["given"]
        fig.add_layout(Span(location=0, dimension="width", line_width=1, tags=["axis"]))
        drawn.append(fig)
    return drawn


def _next(content: dict[str, Any]) -> list[figure]:
    """The designed flight, if there is one: from above, from the side, and its speed and rate of turning."""
    if content.get("design") is None:
        return []
    held = content["design"]["drawn"]
    views = {}
    for view, (i, j) in {"above": (0, 1), "side": (0, 2)}.items():
        fig = views[view] = _figure(f"next-{view}", 230, "", match_aspect=True)
        fig.xaxis.axis_label, fig.yaxis.axis_label = (f"{'xyz'[k]} [m]" for k in (i, j))
        for key, role in (("simulated", "given"), ("position", "ticked")):
            if held[key] is not None:
                places = np.array(held[key])
                fig.line(places[:, i], places[:, j], line_width=1.6).tags = [role]
        start = np.array(held["position"][0])
        fig.scatter(start[[i]], start[[j]], size=8, line_color=None).tags = ["ticked"]
    speed = views["speed"] = _figure("next-speed", 230, "")
    speed.xaxis.axis_label, speed.yaxis.axis_label = "t [s]", "m/s, rad/s"
    speed.line(held["t"], held["speed"], line_width=1.6).tags = ["ticked"]
    speed.line(held["t"], held["rate"], line_width=1.6, line_dash="dashed").tags = ["given"]
    return list(views.values())


def _figure(name: str, height: int, tools: str, **ranges: Any) -> figure:
    fig = figure(
        name=name, height=height, sizing_mode="stretch_width", tools=tools, toolbar_location=None, lod_threshold=None,
        min_border_right=12, **ranges,
    )  # fmt: skip
    fig.background_fill_color = None
    fig.border_fill_color = None
    fig.outline_line_color = None
    fig.axis.axis_label_text_font_style = "normal"
    fig.axis.axis_label_text_font_size = "12px"
    fig.axis.major_label_text_font_size = "11px"
    fig.axis.minor_tick_line_color = None
    fig.xgrid.grid_line_color = None
    return fig
