"""Scores the runs of the study of separating flights: alone reads which of the two effects was hidden."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from infotraj.experiment.common.scores import Score, add_score, read_scores
from infotraj.experiment.hidden.config import HiddenStudy
from infotraj.experiment.separating.cases import Run, SeparatingStudy, drawn
from infotraj.experiment.separating.loop import AGAIN, ARMS, Answer, loop, told
from infotraj.vehicle import load_vehicle


def score_run(study: SeparatingStudy, hidden: HiddenStudy, run: Run) -> Score:
    """One run, flown, answered and scored."""
    began = time.process_time()
    said = loop(study, hidden, run)
    pair = study.pairs[run.pair]
    name, values, size = drawn(study, hidden, run, load_vehicle(hidden.vehicles[pair.vehicle].file))
    about = {"pair": pair.name, "number": run.number, "hidden": name, "size": size, "parameters": values}
    return about | scored(said, run.hides) | {"cpu": time.process_time() - began}


def scored(said: Answer, hides: int) -> Score:
    """What was answered after the task and after each further flight, with `what` it was: see `judged`."""
    if said["failed"]:
        return {"failed": said["failed"]}
    pair = tuple(said["pair"])
    out: Score = {"failed": "", "task": said["task"] | {"what": judged(said["task"], pair, hides)}}
    for arm in (*ARMS, AGAIN):
        out[arm] = [
            {**step, "what": judged(step, pair, hides), "true_odds": step["odds"] * (1 - 2 * hides)}
            for step in said[arm]
        ]
    return out


def judged(step: Answer, pair: tuple[str, str], hides: int) -> str:
    """`right` or `wrong`: the hidden effect or the other is Supported, the one and not both; else `group` where both
    stand in one group, or `undecided`."""
    alone = told(step, pair)
    if alone is not None:
        return "right" if alone == hides else "wrong"
    groups = [set(e["group"]) for e in step["effects"].values()]
    return "group" if any(set(pair) <= g for g in groups) else "undecided"


def score_runs(study: SeparatingStudy, hidden: HiddenStudy, every: Sequence[Run], scores: Path) -> None:
    """Appends one line of JSON a run; a run that is there already is not made again."""
    there = {(s["pair"], s["number"]) for s in read_scores(scores)}
    for run in every:
        if (study.pairs[run.pair].name, run.number) in there:
            continue
        add_score(score_run(study, hidden, run), scores)
