"""Scores the answers of the hidden-effect study: alone reads the truth.

An answer is right when each hidden effect is named, alone or in a group of at most 4 whose every member, fitted here in
the effect's place on the flights of the diagnosis, does as well as the oracle on held-out flights, and nothing else is
named. The oracle is the model with the true effects, fitted; as the error to reach (not for members of groups, which
are fitted in the same way) it takes the true parameters where they do better than the fit. As well: it misses no more
than 5 % of what the true effect takes away, or of the floor; from a rough log a quarter of what it takes away.

Where the file is wrong, effects that state the file's errors are counted apart (`hidden_file_errors`), and so are those
that state what a rough log does (`hidden_logs`). The truth of a number is then what it must be beside that file. A
hidden effect that is a number of the file counts as told, apart, where the answer's section on the file says it.
"""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from infotraj.diagnosis.adding import add
from infotraj.effects import effect_class
from infotraj.errors import InfotrajError
from infotraj.experiment.hidden.error import HeldOut
from infotraj.experiment.hidden.file_errors import (
    beside_the_file,
    cancelled,
    excused,
    states_the_file,
    told_in_file,
)
from infotraj.experiment.hidden.logs import TRUE_OF_LOGS
from infotraj.experiment.hidden.ways import score_ways
from infotraj.flight import Flight, read_flight
from infotraj.models import Model
from infotraj.models.file import load_model
from infotraj.vehicle import Vehicle, load_vehicle
from infotraj.writing import write_text

LARGEST_GROUP = 4
MISSED, MISSED_ROUGH = 0.05, 0.25
AGAIN = ", another"
Score = dict[str, Any]


def score_batch(*, flights: Path, answers: Path, named: Path, truth: Path, scores: Path) -> None:
    """Writes a JSON list with one score a run."""
    found = [
        score_run(flights / run.name, answers / run.name, named / f"{run.name}.json", run)
        for run in sorted(truth.glob("run_*"))
    ]
    write_text(json.dumps(found, indent=1) + "\n", scores)


def score_run(shown: Path, answer: Path, today: Path, kept: Path) -> Score:
    """The score of one run: what was hidden, what was said (`answer`, and `today`'s ways), what is right, errors,
    parameters and times."""
    start = time.process_time()
    run = yaml.safe_load((kept / "run.yaml").read_text())
    case = run["case"]
    spent = json.loads((answer / "time.json").read_text()) if (answer / "time.json").is_file() else {}
    score: Score = {
        "case": run["name"], "vehicle": case["vehicle"], "kind": case["kind"], "size": case["size"],
        "clutter": case["clutter"], "curve": case["curve"], "seed": run["seed"], "file": case.get("file", "exact"),
        "log": case.get("log", "clean"), "gusts": case.get("gusts", False),
        "hidden": [*(e["name"] for e in run["effects"]), *(e["name"] for e in run["other"])],
        "nearest": run["nearest"], "failed": run["failed"], "status": spent.get("status"),
        "refusal": spent.get("error", ""), "wall": spent.get("wall"), "cpu": spent.get("cpu"),
    }  # fmt: skip
    if run["failed"]:
        return {**score, "answered": False}
    named = json.loads(today.read_text())
    if not (answer / "answer.json").is_file():
        return {**score, "answered": False, "today": score_ways(named, run["effects"], {})}
    said = json.loads((answer / "answer.json").read_text())
    score["answered"] = True
    score["unexplained"] = bool(said["verdict"]["unexplained"])
    score["supported"] = list(said["verdict"]["supported"])
    rows = {row["name"]: row for row in said["effects"]}
    score["groups"] = [list(rows[name]["group"]) for name in score["supported"]]
    score["plausible"] = [row["name"] for row in said["effects"] if row["verdict"] == "Plausible"]
    score["rises"] = {name: rows[name]["rise"] for name in score["supported"]}
    file, vehicle = load_vehicle(shown / "vehicle.yaml"), load_vehicle(kept / "vehicle.yaml")
    training = [read_flight(p) for p in sorted(shown.glob("flight_*.parquet"))]
    held = HeldOut(
        vehicle,
        [read_flight(p) for p in sorted(kept.glob("held_out_*.parquet"))],
        [read_flight(p) for p in sorted(kept.glob("floor_*.parquet"))],
    )
    base = Model(file)
    score["error_nominal"] = held.error(base)
    answered = load_model(answer / "model.yaml") if (answer / "model.yaml").is_file() else base
    score["error_answer"] = held.error(answered)
    score["force_nominal"], score["force_answer"] = (held.error(m, "force") for m in (base, answered))
    listed = [_label(e) for e in run["effects"]]
    oracle = _fitted(base, listed, training)
    fitted = held.error(oracle) if oracle is not None else None
    true = held.error(Model(vehicle, [effect_class(e["name"])(**e["parameters"]) for e in run["effects"]]))
    score["error_fitted"] = fitted
    score["error_oracle"] = true if fitted is None else min(fitted, true)
    rough = score["log"] != "clean"
    allowed = _allowed(score["error_nominal"], fitted, rough)
    there = [e for e in run["effects"] if not cancelled(e["name"], e["parameters"], file, vehicle)]
    score["cancelled"] = [e["name"] for e in run["effects"] if e not in there]
    score.update(_names(there, score["groups"], rows, base, training, held, fitted, allowed))
    section = said.get("file", [])
    score["told_in_file"] = [
        e["name"]
        for e in there
        if e["name"] not in score["stood"] and told_in_file(e["name"], e["parameters"], section, file, vehicle)
    ]
    _excuse(score, rows, file, vehicle)
    score["today"] = score_ways(named, run["effects"], score["stood"])
    if case["kind"] in ("cannot_show", "richer", "unlisted"):
        score["right"] = _right_beyond(case["kind"], score)
    beside = [{**e, "parameters": beside_the_file(e["name"], e["parameters"], file, vehicle)} for e in there]
    own = TRUE_OF_LOGS.get(score["log"], frozenset())
    score["parameters"] = _parameters([e for e in beside if e["name"] not in own], rows, score["supported"])
    score["score_cpu"] = time.process_time() - start
    return score


def _allowed(nominal: float, oracle: float | None, rough: bool) -> float:
    """By how much (floors) a model may be worse than the fitted oracle and still count as well as it."""
    if oracle is None or not np.isfinite(oracle):
        return 0.0
    taken = max(0.0, nominal - oracle)
    return MISSED_ROUGH * max(1.0, taken) if rough else MISSED * max(1.0, min(oracle, taken))


def _excuse(score: Score, rows: dict[str, Any], file: Vehicle, true: Vehicle) -> None:
    """Counts what states the file's or the log's own errors apart from what is invented."""
    left = [(k, group) for k, group in enumerate(score["groups"]) if k not in score["used"]]
    own = TRUE_OF_LOGS.get(score["log"], frozenset())
    score["file_errors"], score["log_errors"], numbers = excused(
        left, lambda name: instances(name, rows), file, true, own
    )
    others = [group[0] for k, group in left if k not in numbers]
    again = [name for name in score["invented"] if name.endswith(AGAIN)]
    score["beyond"] = [group for k, group in left if k not in numbers]
    score["invented"] = [*others, *_again(again, rows, score, file, true)]
    told = len(score["stood"]) + len(score["told_in_file"])
    score["right"] = told == score["sought"] and not score["invented"]


def _again(names: Sequence[str], rows: dict[str, Any], score: Score, file: Vehicle, true: Vehicle) -> list[str]:
    """Of further instances of an effect, those that do not state an error of the file."""
    out = []
    for name in sorted(set(names)):
        plain = name.removesuffix(AGAIN)
        stated = [states_the_file(plain, values, file, true) for values in instances(plain, rows)]
        # one instance is the group's own, found or counted above
        out += [name] * max(0, len(stated) - max(1, sum(stated) + (plain in score["stood"])))
    return out


def _right_beyond(kind: str, score: Score) -> bool:
    """Whether the answer is right about what has no name of its own, errors of file and log left out.

    Unlisted physics: flagged as unexplained, and nothing named. Richer physics: a nearest name, and no other. What
    leaves no trace: nothing named.
    """
    if kind == "richer":
        near = [bool(set(group) & set(score["nearest"])) for group in score["beyond"]]
        return bool(near) and all(near)
    return not score["invented"] and (kind == "cannot_show" or score["unexplained"])


def _names(
    effects: Sequence[dict[str, Any]],
    groups: Sequence[Sequence[str]],
    rows: dict[str, Any],
    base: Model,
    training: Sequence[Flight],
    held: HeldOut,
    oracle: float | None,
    allowed: float,
) -> Score:
    """Which hidden effects were found, what was invented, and whether the answer is right.

    oracle: the fitted oracle's held-out error; allowed: by how much more a group's member may have.
    """
    stood: dict[str, list[str]] = {}
    used: set[int] = set()
    members: Score = {}
    for effect in effects:
        for number, group in enumerate(groups):
            if number in used or effect["name"] not in group or not same_place(effect, rows):
                continue
            used.add(number)
            good = len(group) <= LARGEST_GROUP
            others = [_label(e) for e in effects if e is not effect]
            for name in group if good and len(group) > 1 else ():
                if name == effect["name"]:
                    continue
                model = _fitted(base, [*others, _instance(name, rows)], training)
                reached = held.error(model) if model is not None else float("inf")
                members[f"{effect['name']} as {name}"] = reached / oracle if oracle and np.isfinite(reached) else None
                good &= oracle is not None and oracle != 0.0 and reached - oracle <= allowed
            if good:
                stood[effect["name"]] = list(group)
            break
    invented = [group[0] for number, group in enumerate(groups) if number not in used]
    # A second rotor beside the first is a second name.
    invented += [group[0] + AGAIN for group in groups for _ in instances(group[0], rows)[1:]]
    return {
        "found": list(stood),
        "stood": stood,
        "sought": len(effects),
        "used": sorted(used),
        "invented": invented,
        "members": members,
        "right": len(stood) == len(effects) and not invented,
    }


def _label(effect: dict[str, Any]) -> str:
    values = effect["parameters"]
    return f"{effect['name']}:{values['rotor']}" if "rotor" in values else effect["name"]


def _instance(name: str, rows: dict[str, Any]) -> str:
    """A group's member as `add` names it: with its place, where the answer gives one."""
    place = (rows.get(name, {}).get("parameters") or {}).get("rotor")
    return name if place is None else f"{name}:{int(place)}"


def same_place(effect: dict[str, Any], rows: dict[str, Any]) -> bool:
    """Whether an effect on one rotor was named on that rotor."""
    if "rotor" not in effect["parameters"]:
        return True
    return any(values.get("rotor") == effect["parameters"]["rotor"] for values in instances(effect["name"], rows))


def instances(name: str, rows: dict[str, Any]) -> list[dict[str, Any]]:
    """The numbers of each instance of an effect in the answer."""
    row = rows.get(name, {})
    return list(row.get("instances", [])) or [row.get("parameters") or {}]


def _fitted(base: Model, names: Sequence[str], training: Sequence[Flight]) -> Model | None:
    """The base model with these effects fitted; None where they cannot be."""
    if not names:
        return base
    try:
        return add(base, names, training).model
    except InfotrajError:
        return None


def _parameters(
    effects: Sequence[dict[str, Any]], rows: dict[str, Any], supported: Sequence[str]
) -> list[dict[str, Any]]:
    """One row for each number of each hidden effect that was named: true, estimated, standard error."""
    out = []
    for effect in effects:
        row = rows.get(effect["name"])
        if effect["name"] not in supported or row is None or len(row["group"]) > 1 or not same_place(effect, rows):
            continue
        for key, true in effect["parameters"].items():
            estimate, error = (row["parameters"] or {}).get(key), (row["standard_errors"] or {}).get(key)
            if estimate is None or error is None:
                continue
            for place, (a, b, c) in enumerate(zip(*map(np.atleast_1d, (true, estimate, error)), strict=True)):
                out.append(
                    {"effect": effect["name"], "parameter": key, "place": place, "true": float(a),
                     "estimate": float(b), "standard_error": float(c)}
                )  # fmt: skip
    return out
