"""What the study of changes found beside what it must show, with the healthy flights and without, case by case."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from infotraj.evaluation.proportions import share
from infotraj.experiment.changes.answering import WAYS
from infotraj.experiment.common.tables import write_table
from infotraj.plots import typeset
from infotraj.writing import write_text

ALL = "all"
_WORDS = {"with": "with healthy flights", "without": "the same flights without"}


def summarise_changes(scores: Sequence[str | Path], planned: int, table: str | Path, markdown: str | Path) -> None:
    """Writes a row a case and way (CSV), and the page: shares with exact 95 % intervals, then every case (Markdown)."""
    every = [score for path in scores for score in json.loads(Path(path).read_text())]
    made = pd.DataFrame([row for score in every if "ways" in score for row in _rows(score)], columns=list(COLUMNS))
    write_table(made, table)
    write_text(report(every, made, planned), markdown)


COLUMNS = ("case", "vehicle", "kind", "way", "hidden", "found", "wrong", "answered", "said", "unexplained", "cpu")


def _rows(score: dict[str, Any]) -> list[dict[str, Any]]:
    return [
        {
            "case": f"{score['name']} {score['number']}",
            "vehicle": score["vehicle"],
            "kind": score["kind"],
            "way": way,
            "hidden": len(score["effects"]),
            "found": len(said["found"]),
            "wrong": len(said["wrong"]),
            "answered": said["answered"],
            "said": "; ".join("|".join(group) for group in said["groups"]) or said["refusal"],
            "unexplained": bool(said.get("unexplained")),
            "cpu": said["cpu"],
        }
        for way, said in score["ways"].items()
    ]


def report(every: Sequence[dict[str, Any]], made: pd.DataFrame, planned: int) -> str:
    """The page."""
    header = ["vehicle", "", "single changes found", "of several at once", "all changes found", "cases all right",
    "false changes where nothing changed", "changed cases with a wrong name"]  # fmt: skip
    cells = []
    vehicles = sorted(set(made["vehicle"]))
    for vehicle in (*vehicles, *([ALL] if len(vehicles) > 1 else [])):
        for way in WAYS:
            own = made[(made["way"] == way) & ((made["vehicle"] == vehicle) | (vehicle == ALL))]
            cells.append([vehicle, _WORDS[way], *_shares(own)])
    failed = [s for s in every if s["failed"]]
    errors = [e for s in every if "ways" in s for e in s["ways"]["with"].get("size_errors", {}).values()]
    known = [e for e in errors if e is not None]
    lines = ["# What changed, in the study", "", typeset.markdown(header, cells)]
    lines.append(f"{len(every)} of {planned} planned cases were made, in the order in which they were drawn.")
    if failed:
        lines.append(f"{len(failed)} could not be flown: {', '.join(s['name'] for s in failed)}.")
    if known:
        half, most = 100 * np.median(known), 100 * np.quantile(known, 0.9)
        lines.append(
            f"Sizes: a change that was named alone is told to {half:.0f} % of it (median of {len(known)}; 90 % of them "
            f"to {most:.0f} %)."
        )
    for way in WAYS:
        cpu = made[made["way"] == way]["cpu"]
        if len(cpu):
            lines.append(
                f"CPU of a diagnosis, {_WORDS[way]}: {cpu.median():.0f} s (median), at most {cpu.max():.0f} s."
            )
    lines += ["", "Every case, what changed against what was answered:", ""]
    lines.append(typeset.markdown(["case", "times the usual size", *_WORDS.values()], _cases(every)))
    return "\n".join(lines)


def _shares(own: pd.DataFrame) -> list[str]:
    single, several = own[own["kind"] == "single"], own[own["kind"] == "several"]
    changed, nothing = own[own["hidden"] > 0], own[own["hidden"] == 0]
    right = (changed["found"] == changed["hidden"]) & (changed["wrong"] == 0)
    return [
        share(single["found"].sum(), single["hidden"].sum()),
        share(several["found"].sum(), several["hidden"].sum()),
        share(changed["found"].sum(), changed["hidden"].sum()),
        share(right.sum(), len(changed)),
        share((nothing["wrong"] > 0).sum(), len(nothing)),
        share((changed["wrong"] > 0).sum(), len(changed)),
    ]


def _cases(every: Sequence[dict[str, Any]]) -> list[list[str]]:
    order = sorted((s for s in every if "ways" in s), key=lambda s: (s["vehicle"], s["kind"], s["name"], s["number"]))
    return [
        [s["name"], ", ".join(f"{x:.2f}" for x in s["sizes"]), *(_answer(s["ways"][way]) for way in WAYS)]
        for s in order
    ]


def _answer(said: dict[str, Any]) -> str:
    if not said["answered"]:
        return said["refusal"]
    told = "; ".join(" or ".join(group) for group in said["groups"]) or "nothing"
    wrong = f" (**wrong: {', '.join(said['wrong'])}**)" if said["wrong"] else ""
    return told + wrong
