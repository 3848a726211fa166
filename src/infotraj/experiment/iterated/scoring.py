"""Scores the runs of the study of the iterated loop: alone reads what was hidden."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from infotraj.experiment.common.scores import Score, add_score, read_scores
from infotraj.experiment.hidden import plants
from infotraj.experiment.hidden.config import HiddenStudy
from infotraj.experiment.hidden.file_errors import cancelled, excused, told_in_file
from infotraj.experiment.hidden.scoring import instances, same_place
from infotraj.experiment.iterated.cases import IteratedStudy, Run, drawn, of
from infotraj.experiment.iterated.loop import ARMS, Answer, loop, settled
from infotraj.vehicle import Vehicle, load_vehicle

Hidden = Sequence[tuple[str, dict[str, Any]]]


def score_run(study: IteratedStudy, hidden: HiddenStudy, run: Run) -> Score:
    """One run, flown, answered and scored."""
    began = time.process_time()
    said = loop(study, hidden, run)
    vehicle, draws = load_vehicle(hidden.vehicles[run.vehicle].file), partial(of, study, run)
    there = drawn(study, hidden, run, vehicle)
    about = {"run": run.name, "kind": run.kind, "hidden": [n for n, _ in there], "parameters": [v for _, v in there]}
    scored_run = scored(said, there, plants.file_of(vehicle, study.files, draws), vehicle)
    return about | scored_run | {"cpu": time.process_time() - began}


def scored(said: Answer, hidden: Hidden, file: Vehicle, vehicle: Vehicle) -> Score:
    """After the task and after each further flight: `what` it was (`judged`), the names, what is open, and whether
    the loop would end there."""
    if said["failed"]:
        return {"failed": said["failed"]}

    def step(now: Answer, before: Answer | None) -> Score:
        what = judged(now, hidden, file, vehicle)
        ends = before is not None and settled(before, now)
        return {"what": what, "supported": now["supported"], "open": now["open"], "ends": ends}

    out: Score = {"failed": "", "first": step(said["first"], None)}
    for arm in ARMS:
        out[arm] = [step(b, a) for a, b in zip([said["first"], *said[arm]], said[arm], strict=False)]
    return out


def judged(now: Answer, hidden: Hidden, file: Vehicle, vehicle: Vehicle) -> str:
    """`right`: every hidden effect is named alone, on its rotor, and nothing else is; `wrong`: something else is;
    `open` otherwise.

    A name that states what the file has wrong is nothing else. A hidden effect that is a number of the file may be told
    in the section on the file, and one that the file's own error cancels need not be told.
    """
    rows = {e["name"]: e for e in now["effects"]}
    groups = [list(rows[name]["group"]) for name in now["supported"]]
    used, missed = set(), False
    for name, values in hidden:
        effect = {"name": name, "parameters": values}
        own = [k for k, g in enumerate(groups) if name in g and same_place(effect, rows)]
        used |= set(own)
        alone = any(len(groups[k]) == 1 for k in own)
        told = told_in_file(name, values, now["file"], file, vehicle) or cancelled(name, values, file, vehicle)
        missed |= not (alone or told)
    left = [(k, g) for k, g in enumerate(groups) if k not in used]
    if len(excused(left, lambda n: instances(n, rows), file, vehicle, frozenset())[2]) < len(left):
        return "wrong"
    return "open" if missed else "right"


def score_runs(study: IteratedStudy, hidden: HiddenStudy, every: Sequence[Run], scores: Path) -> None:
    """Appends one line of JSON a run; a run that is there already is not made again."""
    there = {s["run"] for s in read_scores(scores)}
    for run in every:
        if run.name in there:
            continue
        add_score(score_run(study, hidden, run), scores)
