"""The diagnosis beside the ways of today (`baselines`) on the same flights: found, false alarms, time.

A way names single effects. Where the diagnosis' answer was a group that stood, any one of its members counts as the
hidden effect for a way too; what it names beside is invented. Without an answer, refused or given up, the diagnosis
found nothing.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from infotraj.evaluation.proportions import share

OURS = "infotraj diagnose"
LISTED = ("single", "pair", "triple")
COLUMNS = ("way", "case", "kind", "clutter", "hidden", "found", "invented", "seconds")


def score_ways(
    named: Mapping[str, Mapping[str, Any]], effects: Sequence[Mapping[str, Any]], stood: Mapping[str, Sequence[str]]
) -> dict[str, dict[str, Any]]:
    """What each way found and invented, and its seconds.

    named: of each way its effects (`rotor_effectiveness 3`) and seconds; effects: hidden; stood: groups that stood.
    """
    return {
        way: {**_judged(said["effects"], effects, stood), "seconds": said["seconds"]} for way, said in named.items()
    }


def _judged(
    names: Sequence[str], effects: Sequence[Mapping[str, Any]], stood: Mapping[str, Sequence[str]]
) -> dict[str, list[str]]:
    left = set(names)
    places = {e["name"]: _place(e) for e in effects}
    found = [name for name, place in places.items() if place in left]
    left -= {places[name] for name in found}
    for name in places:
        equal = sorted(n for n in left if n.split()[0] in stood.get(name, ()) and n.split()[0] != name)
        if name not in found and equal:
            found.append(name)
            left.remove(equal[0])
    return {"found": found, "invented": sorted(left)}


def _place(effect: Mapping[str, Any]) -> str:
    rotor = effect["parameters"].get("rotor")
    return effect["name"] if rotor is None else f"{effect['name']} {rotor}"


def ways_table(paths: Sequence[Path]) -> pd.DataFrame:
    """A row a run and way: how many effects are hidden, found and invented, and seconds of CPU.

    Of singles, pairs, triples, nothing and unlisted physics with exact files and clean logs, where they were asked.
    """
    rows = [row for path in paths for score in json.loads(Path(path).read_text()) for row in _rows(score)]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _rows(score: dict[str, Any]) -> Iterator[dict[str, Any]]:
    if score["kind"] not in (*LISTED, "nothing", "unlisted") or not score.get("today"):
        return
    if score.get("gusts") or (score.get("file", "exact"), score.get("log", "clean")) != ("exact", "clean"):
        return
    ours = {"found": score.get("found", []), "invented": score.get("invented", []), "seconds": score["cpu"]}
    for way, said in {OURS: ours, **score["today"]}.items():
        yield {
            "way": way, "case": score["case"], "kind": score["kind"], "clutter": score["clutter"],
            "hidden": len(score["hidden"]) if score["kind"] in LISTED else 0, "found": len(said["found"]),
            "invented": len(said["invented"]), "seconds": said["seconds"],
        }  # fmt: skip


def said(ways: pd.DataFrame) -> str:
    """One Markdown table, a row a way: shares of runs with exact 95 % intervals, median time."""
    from infotraj.plots.typeset import markdown  # late: matplotlib

    header = [
        "way", "every effect found", "found, nothing invented", "nothing hidden: false alarms",
        "unlisted physics: a name", "names invented a run", "CPU time",
    ]  # fmt: skip
    cells = []
    for way, runs in ways.groupby("way", sort=False):
        listed, nothing, unlisted = (runs[runs["kind"].isin(k)] for k in (LISTED, ("nothing",), ("unlisted",)))
        found, wrong = listed["found"] == listed["hidden"], listed["invented"] > 0
        cells.append(
            [
                str(way), _share(found), _share(found & ~wrong), _share(nothing["invented"] > 0),
                _share(unlisted["invented"] > 0), f"{runs['invented'].mean():.2f}", f"{runs['seconds'].median():.1f} s",
            ]
        )  # fmt: skip
    return markdown(header, cells)


def _share(good: pd.Series) -> str:
    return share(int(good.sum()), len(good))
