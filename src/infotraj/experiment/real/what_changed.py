"""Real flights with a known change against the vehicle's own healthy ones: what was done, what was answered."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pydantic import Field

from infotraj.datasets.location import find_dataset, how_to_get
from infotraj.errors import InfotrajError, InputError
from infotraj.experiment.common.strict_yaml import Strict, read_yaml
from infotraj.experiment.common.tables import write_table
from infotraj.flight import Flight
from infotraj.plots import typeset
from infotraj.plots.what_changed import what_changed
from infotraj.writing import write_text

FOUND = ("Supported", "Not separable")


class Condition(Strict):
    """What was done to the vehicle, as the answer that is right."""

    right: tuple[str, ...] = Field(description="names, any of which is right")
    rotor: int | None = Field(None, description="which rotor, where the name is of one")
    toward: tuple[float, float] | None = Field(None, description="x, y: where a centre of mass moves")
    size: float | None = Field(None, description="mm cut off")


class Study(Strict):
    """Logs of one vehicle, healthy and changed."""

    folder: str
    mapping: str
    groups: Mapping[str, str] = Field(description="vehicle file of each group of logs")
    logs: str
    least_height: float
    healthy: str
    doubtful: tuple[str, ...] = ()
    conditions: Mapping[str, Condition]


def read_study(path: str | Path) -> Study:
    """The study's file. UsageError, one line, where it cannot be used."""
    return read_yaml(Study, path)


def answer_group(study: str | Path, group: str, data_dir: str | Path | None, output: str | Path) -> None:
    """Diagnoses every flight of a group against the healthy ones, each healthy one against the others (JSON)."""
    from infotraj.diagnosis.diagnosis import diagnose, learn  # late: reading a study needs no diagnosis
    from infotraj.models.file import read_model

    asked = read_study(study)
    folder = find_dataset(asked.folder, data_dir)
    if folder is None:
        raise InputError(how_to_get(asked.folder))
    model, _ = read_model(Path(asked.groups[group]))
    flights = {
        (condition, path.name): _flight(path, asked, model.vehicle)
        for condition in (asked.healthy, *asked.conditions)
        for path in sorted((folder / group / condition).glob(asked.logs))
    }
    healthy = {k: f for k, f in flights.items() if k[0] == asked.healthy and k[1] not in asked.doubtful}
    answers = []
    usual = learn(model, list(healthy.values()))
    for key, flight in flights.items():
        row: dict[str, Any] = {"group": group, "condition": key[0], "log": key[1], "found": [], "refused": ""}
        try:
            others = learn(model, [f for k, f in healthy.items() if k != key]) if key in healthy else usual
            found = diagnose(model, [flight], reference=others)
        except InfotrajError as error:
            row["refused"] = str(error)
        else:
            if not found.judged:
                row["refused"] = next(iter(found.refused.values()))
            row["found"] = [_told(found, f) for f in found.findings if f.verdict in FOUND]
            row["plausible"] = [f.name for f in found.findings if f.verdict == "Plausible"]
            row["notes"] = [d.reason for d in found.doubts if not d.refuses]
        answers.append(row)
        print(group, *key, [t["name"] for t in row["found"]], row["refused"], flush=True)
    Path(output).write_text(json.dumps(answers, indent=1))


def _flight(path: Path, study: Study, vehicle: Any) -> Flight:
    from infotraj.diagnosis.gates.premises import examined
    from infotraj.importing import import_log

    flight = import_log(path, study.mapping)
    flown = flight.t[flight.get("pz")[:, 0] > study.least_height]
    return examined(flight.between(flown[0], flown[-1]), vehicle)


def _told(found: Any, finding: Any) -> dict[str, Any]:
    usual = found.healthy_numbers(finding)
    told = {"name": finding.name, "group": list(finding.group), "parameters": finding.parameters}
    return told | {"standard_errors": finding.standard_errors, "healthy": usual["parameters"] if usual else {}}


def judged(answer: Mapping[str, Any], study: Study) -> str:
    """An answer as `right`, `wrong`, `nothing`, or `refused`. Of a healthy flight a name is wrong."""
    if answer["refused"]:
        return "refused"
    if not answer["found"]:
        return "nothing"
    condition = study.conditions.get(answer["condition"])
    if condition is None:
        return "wrong"
    groups = {tuple(t["group"]) for t in answer["found"]}
    right = [any(_fits(t, condition) for t in answer["found"] if tuple(t["group"]) == g) for g in groups]
    return "right" if all(right) else "wrong"


def _fits(told: Mapping[str, Any], condition: Condition) -> bool:
    if told["name"] not in condition.right:
        return False
    if told["name"] == "rotor_effectiveness" and condition.rotor is not None:
        return bool(told["parameters"]["rotor"] == condition.rotor and change(told) < 0)
    if told["name"] == "com_offset" and condition.toward is not None:
        moved = np.subtract(told["parameters"]["r"], told["healthy"]["r"])[:2]
        return bool(moved @ np.array(condition.toward) > 0)
    return True


def change(told: Mapping[str, Any]) -> float:
    """By what share of its healthy thrust a rotor's differs."""
    return float(told["parameters"]["factor"] / told["healthy"]["factor"] - 1.0)


def said(told: Mapping[str, Any]) -> str:
    """A finding in words, with its change."""
    name, p, healthy = told["name"], told["parameters"], told["healthy"]
    if name == "rotor_effectiveness":
        error = told["standard_errors"]["factor"]
        return f"rotor {p['rotor'] + 1} gives {p['factor']:.2f} +- {error:.2f} (healthy {healthy['factor']:.2f})"
    if name == "com_offset":
        moved = 1000 * np.subtract(p["r"], healthy["r"])[:2]
        return f"centre of mass by ({moved[0]:+.1f}, {moved[1]:+.1f}) mm"
    return name


def _groups(found: Sequence[Mapping[str, Any]]) -> list[str]:
    """What was told, a sentence a group."""
    groups = dict.fromkeys(tuple(t["group"]) for t in found)
    return [" or ".join(said(t) for t in found if tuple(t["group"]) == g) for g in groups]


def _in_table(said: str, plausible: str) -> str:
    return (said or "nothing") + (f" (plausible: {plausible})" if plausible else "")


def write_what_changed(
    study: str | Path, answers: Sequence[str | Path], table: str | Path, markdown: str | Path, *figures: str | Path
) -> None:
    """All answers side by side: CSV, a table a condition, and the figure."""
    asked = read_study(study)
    every = [row for p in answers for row in json.loads(Path(p).read_text())]
    rows = []
    for a in every:
        weak = [t for t in a["found"] if t["name"] == "rotor_effectiveness"]
        rows.append({
            "group": a["group"], "condition": a["condition"], "log": a["log"], "judged": judged(a, asked),
            "doubtful": a["condition"] == asked.healthy and a["log"] in asked.doubtful,
            "found": "; ".join("|".join(g) for g in dict.fromkeys(tuple(t["group"]) for t in a["found"])),
            "said": "; ".join(_groups(a["found"])), "refused": a["refused"],
            "plausible": "; ".join(a.get("plausible", ())),
            "rotor": weak[0]["parameters"]["rotor"] + 1 if weak else None,
            "change": change(weak[0]) if weak else None,
            "size": asked.conditions[a["condition"]].size if a["condition"] in asked.conditions else None,
        })  # fmt: skip
    made = pd.DataFrame(rows)
    write_table(made, table)
    cells = []
    for (group, condition), part in made.groupby(["group", "condition"], sort=True):
        count = part["judged"].value_counts()
        counts = ", ".join(f"{n} {word}" for word, n in count.items())
        words = " / ".join(_in_table(s, p) for s, p in zip(part["said"], part["plausible"], strict=True))
        cells.append([group, condition, counts, words])
    header = ["logs", "what was done", "of the flights", "answered, flight by flight"]
    text = typeset.markdown(header, cells)
    write_text(f"# What changed, on real flights\n\n{text}\n", markdown)
    what_changed(made, asked.healthy, *figures)
