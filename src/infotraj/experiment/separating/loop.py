"""Flies the task, asks which of two effects it is, and flies the answer, until it is told or the flights are used up.

All flights are diagnosed with the shown file and nothing else. The same question is then put to random deviations of
the same length, in the same room and within the same limits of the rotors: the design's own search with one motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from infotraj.design.design import Design, design
from infotraj.design.questions import separated
from infotraj.diagnosis.diagnosis import Diagnosis, diagnose
from infotraj.errors import InfotrajError
from infotraj.experiment.hidden.config import HiddenStudy
from infotraj.experiment.hidden.plants import Fly
from infotraj.experiment.separating.cases import Run, SeparatingStudy
from infotraj.experiment.separating.flying import plant, shown_file, task
from infotraj.flight import Flight
from infotraj.models import Model

Answer = dict[str, Any]
ARMS = ("designed", "random")
AGAIN = "again"  # another flight of the task, held against what the design says of one
_SHOWN = ("Supported", "Not separable", "Plausible")


def loop(study: SeparatingStudy, hidden: HiddenStudy, run: Run) -> Answer:
    """What was said after the task (`task`) and after every further flight of each arm, in order.

    What the answers hold knows nothing of what is hidden. A run that ends in a user's error says so (`failed`).
    """
    pair = study.pairs[run.pair].effects
    fly, model = plant(study, hidden, run), Model(shown_file(study, hidden, run))
    out: Answer = {"pair": list(pair), "failed": "", **{arm: [] for arm in (*ARMS, AGAIN)}}
    try:
        flown = [fly(reference, f"task {k}") for k, reference in enumerate(task(study, run))]
        found = diagnose(model, flown)
        out["task"] = answer(found, pair)
        if told(out["task"], pair) is None:
            for arm in ARMS:
                out[arm] = _further(study, run, fly, model, found, flown, arm)
            more = fly(task(study, run, AGAIN)[-1], AGAIN)
            predicted = {"again": out[ARMS[0]][0]["again"], "predicted": out[ARMS[0]][0]["again"], "warning": ""}
            out[AGAIN] = [predicted | answer(diagnose(model, [*flown, more]), pair)]
    except InfotrajError as error:
        out["failed"] = str(error)
    return out


def _further(
    study: SeparatingStudy,
    run: Run,
    fly: Fly,
    model: Model,
    found: Diagnosis,
    flown: Sequence[Flight],
    arm: str,
) -> list[Answer]:
    pair, said = study.pairs[run.pair].effects, []
    flights = list(flown)
    for k in range(study.designed if arm == "designed" else study.random):
        room = study.room.around(flown, model)
        tried = study.candidates if arm == "designed" else 1
        seed = study.base_seed + 1000 * run.number + k
        made = design(found, flights, room, separate=pair, candidates=tried, seed=seed)
        flights.append(fly(made.reference, f"{arm} {k}"))
        found = diagnose(model, flights)
        said.append({**_predicted(made), **answer(found, pair)})
        if told(said[-1], pair) is not None:
            break
    return said


def _predicted(made: Design) -> Answer:
    (asked,) = made.told
    return {"again": asked.again, "predicted": asked.after, "warning": made.not_flown}


def answer(found: Diagnosis, pair: tuple[str, str]) -> Answer:
    """Verdicts and groups of all that is shown, and the log odds of the first of the pair against the second."""
    shown = {
        f.name: {"verdict": f.verdict, "group": list(f.group), "parameters": _plain(f.parameters)}
        for f in found.findings
        if f.verdict in _SHOWN
    }
    try:
        odds = separated(found, *pair).fitted
    except InfotrajError:
        odds = float("nan")
    return {"effects": shown, "supported": list(found.supported), "odds": odds}


def told(said: Answer, pair: tuple[str, str]) -> int | None:
    """0 or 1: the one of the pair that is Supported, alone; None where that is neither or both."""
    alone = [said["effects"].get(n, {}).get("verdict") == "Supported" for n in pair]
    return None if alone[0] == alone[1] else alone.index(True)


def _plain(parameters: dict[str, Any]) -> dict[str, Any]:
    return {k: np.asarray(v).tolist() for k, v in parameters.items()}
