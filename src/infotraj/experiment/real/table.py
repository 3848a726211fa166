"""The table of real flights: what is known, what was answered, errors on flights not fitted, what cannot be said."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from infotraj.comparing.equation_error import AXES
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.real.cases import RealCase, missing, read_cases
from infotraj.plots import typeset
from infotraj.writing import write_text

FOUND = ("Supported", "Not separable")
NAMED = (*FOUND, "Plausible")
_SURE = 1.96  # standard errors, of an axis that got worse


def write_real_table(
    *, cases: str | Path, only: Sequence[str], data_dir: str | Path | None, answers: Sequence[str | Path],
    table: str | Path, markdown: str | Path,
) -> None:  # fmt: skip
    """Puts the answers (JSON of `answer_case`) side by side.

    table (CSV): a row a case. markdown: for people; cases whose data are not here are listed with the reason.
    """
    found = {content["case"]: content for content in (json.loads(Path(p).read_text()) for p in answers)}
    wanted = read_cases(cases).chosen(only)
    here = [(case, found[case.name]) for case in wanted if case.name in found]
    absent = [f"{c.name}: {missing(c, data_dir) or 'not made'}." for c in wanted if c.name not in found]
    write_table(pd.DataFrame([row(case, result) for case, result in here]), table)
    parts = [
        _section("What is known, and what was answered", ["flights", "known", "answered", "as known", "CPU (s)"],
                 [_overview(c, r) for c, r in here]),
        _section("Error by axis on flights that were not fitted: model as given, as diagnosed (floor)",
                 ["flights", *AXES, "flights not fitted"], [_errors(c, r) for c, r in here]),
        "Forces in N, torques in N m (rad/s^2 where the vehicle file holds no inertia); root mean squares over 0.15 s, "
        f"bias included. **Bold**: worse than as given by more than {_SURE} standard errors.\n",
        _section("What was named", ["flights", "effects", "verdict", "numbers", "held-out change, 95 %", "remarks"],
                 [cells for c, r in here for cells in _named(c, r)]),
        _section("What the vehicle file should say", ["flights", "number", "in the file", "by the flights", "ordinary"],
                 [cells for c, r in here for cells in _file(c, r)]),
        _section("What cannot be answered", ["flights", "known before", "not judged", "left unexplained", "rejected"],
                 [_cannot(c, r) for c, r in here]),
    ]  # fmt: skip
    skipped = "Skipped:\n\n" + "".join(f"- {line}\n" for line in absent) if absent else ""
    write_text("# Public real flights, diagnosed\n\n" + "\n".join([p for p in (*parts, skipped) if p]), markdown)


def row(case: RealCase, result: dict[str, Any]) -> dict[str, Any]:
    """One case for the CSV: verdict, judgement, CPU seconds (s), errors by axis before, after and floor."""
    effects = _effects(result)
    values: dict[str, Any] = {
        "case": case.name,
        "supported": " ".join("+".join(group) for group in _groups(effects, FOUND)),
        "plausible": " ".join("+".join(group) for group in _groups(effects, ("Plausible",))),
        "as_known": "; ".join(judged(case, effects)),
        "right": right(case, effects),
        "seconds": result["seconds"],
    }
    held = result["held_out"]
    for axis in AXES:
        for name, model in (("before", 0), ("after", 1)):
            values[f"{axis}_{name}"] = held["models"][model]["rmse"][axis] if held else None
        values[f"{axis}_floor"] = held["floor"][axis] if held else None
    return values


def judged(case: RealCase, effects: Sequence[dict[str, Any]]) -> list[str]:
    """The answer beside what is known, a sentence each: what had to be found, and what would be wrong."""
    verdicts = {e["name"]: e["verdict"] for e in effects}
    groups = {e["name"]: [n for n in e["group"] if n != e["name"]] for e in effects}
    sentences = []
    for wanted in case.must:
        best = min(wanted, key=lambda n: NAMED.index(v) if (v := verdicts.get(n)) in NAMED else len(NAMED))
        others = [n for n in groups.get(best, []) if n not in wanted]
        if verdicts.get(best) in FOUND:
            apart = f", not told from {', '.join(others)}" if others else ""
            sentences.append(f"{best} found{apart}")
        elif verdicts.get(best) == "Plausible":
            sentences.append(f"{best} Plausible only")
        else:
            sentences.append(f"{' or '.join(wanted)} missed")
    by_name = {e["name"]: e for e in effects if e["verdict"] in NAMED}
    for key, value in case.numbers.items():
        name, parameter, *place = key.split(".")
        if name in by_name:
            found = np.atleast_1d(by_name[name]["parameters"][parameter])[int(place[0]) if place else 0]
            sentences.append(f"{parameter} {_digits(found)} for {value:g} ({found / value - 1:+.0%})")
    sentences += [f"{name} wrongly named" for name in case.never if verdicts.get(name) in FOUND]
    return sentences or (["nothing wrong named"] if case.never else [])


def right(case: RealCase, effects: Sequence[dict[str, Any]]) -> bool:
    """Whether all that had to be found is supported, alone or in a group, and nothing that would be wrong."""
    supported = {e["name"] for e in effects if e["verdict"] in FOUND}
    return all(supported & set(wanted) for wanted in case.must) and not supported & set(case.never)


def _effects(result: dict[str, Any]) -> list[dict[str, Any]]:
    return result["answer"]["effects"] if result["answer"] else []


def _groups(effects: Iterable[dict[str, Any]], verdicts: Sequence[str]) -> list[tuple[str, ...]]:
    groups = [tuple(sorted({e["name"], *e["group"]})) for e in effects if e["verdict"] in verdicts]
    return list(dict.fromkeys(groups))


def _section(title: str, header: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    return f"## {title}\n\n{typeset.markdown(header, cells)}" if cells else ""


def _overview(case: RealCase, result: dict[str, Any]) -> list[str]:
    effects = _effects(result)
    parts = [
        f"{said} {'; '.join(' or '.join(g) for g in groups)}"
        for said, groups in (("Supported:", _groups(effects, FOUND)), ("Plausible:", _groups(effects, ("Plausible",))))
        if groups
    ]
    answered = ". ".join(parts) or ("nothing" if result["answer"] else "rejected: " + "; ".join(result["rejected"]))
    seconds = "-" if result["seconds"] is None else f"{result['seconds']:.0f}"
    return [case.name, case.known, answered, "; ".join(judged(case, effects)) or "-", seconds]


def _errors(case: RealCase, result: dict[str, Any]) -> list[str]:
    held = result["held_out"]
    if held is None:
        return [case.name, *["-"] * len(AXES), "none"]
    before, after = held["models"]
    apart = after["against_first"]
    cells = []
    for axis in AXES:
        old, new, floor = before["rmse"][axis], after["rmse"][axis], after["floor"][axis]
        change, error = apart["relative_change"][axis], apart["standard_error"][axis]
        text = "-" if old is None else f"{old:.3g}, {_digits(new)} ({_digits(floor)})"
        worse = change is not None and change > _SURE * (error or 0.0) and change > 0.0
        cells.append(f"**{text}**" if worse else text)
    return [case.name, *cells, f"{len(held['flights'])}"]


def _named(case: RealCase, result: dict[str, Any]) -> list[list[str]]:
    lines: dict[tuple[str, ...], list[str]] = {}
    effects = sorted(_effects(result), key=lambda e: NAMED.index(e["verdict"]) if e["verdict"] in NAMED else len(NAMED))
    for e in effects:
        if e["verdict"] not in NAMED:
            continue
        low, high = e["ci95"] or (None, None)
        change = f"{_digits(e['heldout_change'])} [{_digits(low)}, {_digits(high)}]" if e["ci95"] else "-"
        remarks = [f"{word} {e[key]:.2g}" for key, word in (("probability", "needed:"), ("form_error", "form:"))
                   if e.get(key) is not None]  # fmt: skip
        remarks += [e["reason"]] if e.get("reason") else []
        numbers = "; ".join(_number(k, v, e["standard_errors"].get(k)) for k, v in e["parameters"].items())
        key = (e["verdict"], e["name"])
        lines[key] = [case.name, e["name"], e["verdict"], numbers, change, "; ".join(remarks)]
    return list(lines.values())


def _file(case: RealCase, result: dict[str, Any]) -> list[list[str]]:
    rows = (result["answer"] or {}).get("file", [])
    return [
        [case.name, r["name"], _digits(r["declared"]), f"{_digits(r['value'])} +- {_digits(r['standard_error'])}",
         "yes" if r["ordinary"] else "no"]
        for r in rows
    ]  # fmt: skip


def _cannot(case: RealCase, result: dict[str, Any]) -> list[str]:
    answer = result["answer"] or {}
    axes = [f"{axis}: {a['reason']}" for axis, a in answer.get("axes", {}).items() if not a["judged"]]
    left = [s["axis"] for s in answer.get("unexplained", [])]
    return [case.name, case.cannot, "; ".join(axes), ", ".join(left), "; ".join(result["rejected"])]


def _number(name: str, value: Any, error: Any) -> str:
    values = np.atleast_1d(value)
    errors = [None] * len(values) if error is None else np.atleast_1d(error)
    return f"{name} " + ", ".join(
        _digits(v) + ("" if s is None else f" +- {_digits(s, 2)}") for v, s in zip(values, errors, strict=True)
    )


def _digits(value: float | None, digits: int = 3) -> str:
    return "-" if value is None or not np.isfinite(value) else f"{value:.{digits}g}"
