"""The page: a template filled with the content, with everything it needs inside it."""

from __future__ import annotations

import json
import re
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined

from infotraj.diagnosis.report.reasons import about_takes, axis_in_words, why
from infotraj.report.bars import gains, panel, whole_gain
from infotraj.report.figures import figures, javascript
from infotraj.report.formats import (
    change,
    changes,
    interval,
    measure,
    minus,
    numbers,
    percent,
    plain_unit,
    signed,
    significant,
)
from infotraj.report.squeezing import deflated
from infotraj.writing import whole

_ORDER = ("Supported", "Not separable", "Plausible", "Not needed", "Not testable here")
_MARKS = {"Supported": "●", "Not separable": "◐", "Plausible": "○", "Not needed": "–", "Not testable here": "?"}
_ADDS = (  # where a verdict's sentence is cut
    "; (?=nothing can be said about |your vehicle file |the numbers of your vehicle file |structured error is left on |"
    "a large error is left on |error without a name is left on |something else changed |plausible: )"
)
_CONFIDENT = ("Supported", "Not separable")


def write_page(content: dict[str, Any], path: Path) -> None:
    """Writes the page, whole or not at all."""
    with whole(path) as part:
        part.write_text(page(content), encoding="utf-8")


def page(content: dict[str, Any]) -> str:
    """The page as HTML text. content: what `content.gathered` made."""
    environment = Environment(
        loader=FunctionLoader(asset), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {"sig": significant, "signed": signed, "percent": percent, "change": change}
    environment.filters |= {"unit": plain_unit, "measure": measure, "interval": interval, "minus": minus}
    environment.filters["axis_in_words"] = axis_in_words
    rows = sorted(content["answer"]["effects"], key=_rank)
    each = gains(content)
    headline, *rest = clauses(content["answer"]["verdict"]["summary"])
    return environment.get_template("page.html").render(
        c=content,
        design=content.get("design"),
        answer=content["answer"],
        headline=headline,
        rest=rest,
        named=[r for r in rows if r["verdict"] in _CONFIDENT],
        maybe=[r for r in rows if r["verdict"] == "Plausible"],
        groups=_groups(rows),
        corrects=content["answer"].get("corrected", []),
        quiet=[r for r in rows if r["verdict"] not in (*_CONFIDENT, "Plausible")],
        marks=_MARKS,
        takes=about_takes([r["reason"] for r in rows if r["verdict"] in (*_CONFIDENT, "Plausible")]),
        gains=each,
        acts={name: gain for gain in each if not gain["corrects"] for name in gain["names"]},
        corrected=next((gain for gain in each if gain["corrects"]), None),
        together=whole_gain(content),
        worst=_worst(content),
        unjudged=dict(why({a: said["reason"] for a, said in content["answer"]["axes"].items() if not said["judged"]})),
        panels=[panel(content, axis) for axis in content["fall"]["axes"]],
        numbers=lambda row, key="parameters": [
            minus(line) for line in numbers(row, content["effects"].get(row["name"], {}), key)
        ],
        changes=lambda row: [minus(line) for line in changes(row)],
        shade=shade,
        figures=deflated(figures(content).encode()),
        data=_safe(json.dumps({key: content[key] for key in ("traces", "fall", "windows", "unit")} | _names(content))),
        bokeh=deflated(javascript()),
        css=asset("page.css"),
        js=asset("unpacking.js") + asset("page.js"),
    )


def shade(value: float | None) -> str:
    """The class of a cell of the heat map: 0 within the noise, 6 at 50 times the floor and beyond."""
    if value is None:
        return "none"
    limits = (1.2, 2.0, 4.0, 8.0, 16.0, 50.0)
    return str(sum(value >= x for x in limits))


def clauses(summary: str) -> list[str]:
    """The verdict, and what its sentence adds of what cannot be said and what is left, a sentence each."""
    parts = re.split(_ADDS, summary.removesuffix("."))
    return [f"{part[:1].upper()}{part[1:]}." for part in parts]


def _groups(rows: list[dict[str, Any]]) -> list[list[str]]:
    """The groups of what these flights cannot tell apart, each once."""
    named = [tuple(row["group"]) for row in rows if row["verdict"] in _CONFIDENT and len(row["group"]) > 1]
    return [list(group) for group in {frozenset(g): g for g in reversed(named)}.values()][::-1]


def _worst(content: dict[str, Any]) -> dict[str, Any] | None:
    """Where the error of the model as given is the largest multiple of the floor, among the axes that are judged."""
    judged = [row for row in content["heat"]["rows"] if content["answer"]["axes"][row["axis"]]["judged"]]
    every = [
        {"ratio": cell["before"], "axis": row["axis"], "flight": flight}
        for row in judged
        for flight, cell in zip(content["heat"]["flights"], row["cells"], strict=True)
        if cell["before"] is not None
    ]
    return max(every, key=lambda one: one["ratio"], default=None)


def _rank(row: dict[str, Any]) -> tuple[int, float]:
    return _ORDER.index(row["verdict"]), -(row["rise"] or 0.0)


def _names(content: dict[str, Any]) -> dict[str, Any]:
    return {"flights": [{"name": f["name"], "seconds": f["seconds"]} for f in content["flights"]]}


def _safe(text: str) -> str:
    """JSON that cannot end the element that holds it."""
    return text.replace("<", "\\u003c")


def asset(name: str) -> str:
    """The text of a file that ships with the page."""
    return (files("infotraj.report") / "assets" / name).read_text(encoding="utf-8")
