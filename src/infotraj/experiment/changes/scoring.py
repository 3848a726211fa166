"""Scores the answers of the study of changes: alone reads what changed.

A change is found where its name is supported, or a group of at most 4 names that holds it; an effect on one rotor on
that rotor. Every other name is a false change. Without healthy flights the question is what the model lacks, which the
file's errors are part of: a name that states the file's error is no false one there, and a change that is a number of
the file is found as well where the answer's section on the file says it and the file's own error together.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from infotraj.effects import effect_class
from infotraj.experiment.changes.answering import WAYS
from infotraj.experiment.hidden.file_errors import excused, told_in_file
from infotraj.experiment.hidden.scoring import AGAIN, LARGEST_GROUP, instances, same_place
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle, load_vehicle
from infotraj.writing import write_text

Score = dict[str, Any]


def score_changes(*, flights: Path, answers: Path, truth: Path, scores: Path) -> None:
    """Writes a JSON list with one score a case."""
    found = [score_change(flights / c.name, answers / c.name, c) for c in sorted(truth.glob("case_*"))]
    write_text(json.dumps(found, indent=1) + "\n", scores)


def score_change(shown: Path, answer: Path, kept: Path) -> Score:
    """The score of one case: what changed, and for each way what was found, what was wrong, sizes and time."""
    run = yaml.safe_load((kept / "run.yaml").read_text())
    score: Score = {key: run[key] for key in ("name", "vehicle", "kind", "number", "effects", "sizes", "failed")}
    if run["failed"]:
        return score
    file, vehicle = load_vehicle(shown / "vehicle.yaml"), load_vehicle(kept / "vehicle.yaml")
    score["ways"] = {way: _way(answer / way, way, run["effects"], file, vehicle) for way in WAYS}
    return score


def _way(folder: Path, way: str, effects: list[dict[str, Any]], file: Vehicle, true: Vehicle) -> Score:
    spent = json.loads((folder / "time.json").read_text())
    score: Score = {"cpu": spent["cpu"], "refusal": spent["error"], "answered": (folder / "answer.json").is_file()}
    if not score["answered"]:
        return score | {"found": [], "wrong": [], "groups": []}
    said = json.loads((folder / "answer.json").read_text())
    score["judged"] = any(axis["judged"] for axis in said["axes"].values())
    score["unexplained"] = bool(said["verdict"]["unexplained"])
    rows = {row["name"]: row for row in said["effects"]}
    score["plausible"] = [row["name"] for row in said["effects"] if row["verdict"] == "Plausible"]
    groups = [list(rows[name]["group"]) for name in said["verdict"]["supported"]]
    score["groups"] = groups
    score |= judged(effects, groups, rows)
    if way == "without":
        used = score["used"]
        left = [(k, group) for k, group in enumerate(groups) if k not in used]
        _, _, own = excused(left, lambda name: instances(name, rows), file, true, frozenset())
        again = [name for name in score["wrong"] if name.endswith(AGAIN)]
        score["wrong"] = [group[0] for k, group in left if k not in own] + again
        section = said["file"]
        score["found"] += [
            e["name"]
            for e in effects
            if e["name"] not in score["found"] and told_in_file(e["name"], e["parameters"], section, file, true)
        ]
    else:
        score["size_errors"] = {
            e["name"]: size_error(e, rows[e["name"]], file) for e in effects if [e["name"]] in groups
        }
    return score


def judged(effects: list[dict[str, Any]], groups: list[list[str]], rows: Mapping[str, Any]) -> Score:
    """Which effects were found, which groups (by their numbers) they were found by, and what is wrong beside.

    groups: as they are supported; rows: the answer's effects by name. Two effects may stand in one group that holds
    both.
    """
    found: list[str] = []
    used: set[int] = set()
    for effect in effects:
        for number, group in enumerate(groups):
            if effect["name"] in group and same_place(effect, dict(rows)) and len(group) <= LARGEST_GROUP:
                found.append(effect["name"])
                used.add(number)
                break
    wrong = [group[0] for number, group in enumerate(groups) if number not in used]
    # A second rotor beside the first is a second name.
    wrong += [group[0] + AGAIN for group in groups for _ in instances(group[0], dict(rows))[1:]]
    return {"found": found, "used": sorted(used), "wrong": wrong}


def size_error(effect: Mapping[str, Any], row: Mapping[str, Any], vehicle: Vehicle) -> float | None:
    """By how much the told change misses the true one, as a share of it; None where the answer has no healthy
    numbers."""
    usual = (row.get("reference") or {}).get("parameters")
    places = [row["parameters"], *instances(effect["name"], {effect["name"]: row})]
    rotor = effect["parameters"].get("rotor")
    now = next((p for p in places if p and p.get("rotor") == rotor), None)
    if usual is None or now is None:
        return None
    cls = effect_class(effect["name"])
    true, told = [], []
    for p in cls.parameters:
        if p.index or p.name not in usual or p.name not in effect["parameters"]:
            continue
        absent = np.atleast_1d(np.asarray(cls.absent(vehicle, p), dtype=float))
        was, value, hidden = (_numbers(v[p.name]) for v in (usual, now, effect["parameters"]))
        true.append(hidden - absent)
        told.append(value / was - 1.0 if p.name == "factor" else value - was)
    if not true:
        return None  # told in another form
    off, change = np.concatenate(told) - np.concatenate(true), np.concatenate(true)
    return float(np.linalg.norm(off) / np.linalg.norm(change))


def _numbers(value: Any) -> Array:
    return np.atleast_1d(np.asarray(value, dtype=float))
