"""Flies the task, and then one flight after the other until the diagnosis has nothing open and says the same twice.

Every arm begins with the same flights of the task and differs in how the next flight is chosen: as `infotraj design`
does it, by a random motion in the same limits, by the task again, or by doublets and sweeps. All flights so far are
diagnosed together, with the shown file and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from infotraj.design.design import at_random, design, largest
from infotraj.design.paths import Room
from infotraj.diagnosis.diagnosis import Diagnosis, diagnose
from infotraj.diagnosis.report.summary import as_dict
from infotraj.errors import InfotrajError
from infotraj.experiment.hidden import plants
from infotraj.experiment.hidden.config import HiddenStudy
from infotraj.experiment.hidden.plants import Fly
from infotraj.experiment.iterated.cases import IteratedStudy, Run, drawn, of
from infotraj.experiment.iterated.doublets import axes_of, doublets
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference
from infotraj.vehicle import load_vehicle

Answer = dict[str, Any]
OPEN = ("Not separable", "Plausible")
_SHOWN = ("Supported", *OPEN)


@dataclass(frozen=True)
class _Flown:
    """What is known when the next flight is chosen: its number, the flights, their diagnosis, the room."""

    study: IteratedStudy
    run: Run
    number: int
    model: Model
    flights: Sequence[Flight]
    found: Diagnosis
    room: Room


def loop(study: IteratedStudy, hidden: HiddenStudy, run: Run) -> Answer:
    """What was said after the task (`first`) and after every further flight of each arm, in order.

    What the answers hold knows nothing of what is hidden. A run that ends in a user's error says so (`failed`).
    """
    vehicle, draws = load_vehicle(hidden.vehicles[run.vehicle].file), partial(of, study, run)
    fly = plants.plant(vehicle, drawn(study, hidden, run, vehicle), draws)
    model = Model(plants.file_of(vehicle, study.files, draws))
    out: Answer = {"failed": "", **{arm: [] for arm in ARMS}}
    try:
        flown = [fly(reference, f"task {k}") for k, reference in enumerate(plants.task(study.task, draws))]
        found = diagnose(model, flown)
        out["first"] = answer(found)
        start = _Flown(study, run, 0, model, flown, found, study.room.around(flown, model))
        for arm in ARMS:
            out[arm] = _further(start, fly, arm)
    except InfotrajError as error:
        out["failed"] = str(error)
    return out


def _further(start: _Flown, fly: Fly, arm: str) -> list[Answer]:
    said: list[Answer] = []
    flights, found, before = list(start.flights), start.found, answer(start.found)
    for k in range(start.study.flights):
        now = _Flown(start.study, start.run, k, start.model, flights, found, start.room)
        flights.append(fly(ARMS[arm](now), f"{arm} {k}"))
        found = diagnose(start.model, flights)
        said.append(answer(found))
        if settled(before, said[-1]):
            break
        before = said[-1]
    return said


def settled(before: Answer, now: Answer) -> bool:
    """Whether nothing is open and the last flight changed no name."""
    return not now["open"] and before["supported"] == now["supported"]


def answer(found: Diagnosis) -> Answer:
    """Of the JSON of `diagnose` the effects that are named or open and the section on the file; and what is open."""
    said = as_dict(found)
    kept = ("name", "verdict", "group", "parameters", "instances")
    rows = [{k: e[k] for k in kept if k in e} for e in said["effects"] if e["verdict"] in _SHOWN]
    return {
        "supported": sorted(said["verdict"]["supported"]),
        "open": sorted(e["name"] for e in rows if e["verdict"] in OPEN),
        "effects": rows,
        "file": said["file"],
    }


def _designed(now: _Flown) -> Reference:
    seed = now.study.base_seed + 1000 * now.run.number + now.number
    return design(now.found, now.flights, now.room, candidates=now.study.candidates, seed=seed).reference


def _random(now: _Flown) -> Reference:
    return at_random(now.model, now.flights, now.room, now.study.base_seed + 1000 * now.run.number + now.number)


def _task(now: _Flown) -> Reference:
    return plants.task(now.study.task, partial(of, now.study, now.run), f"again {now.number}")[-1]


def _doublets(now: _Flown) -> Reference:
    """Each axis as large as the rotors can fly it alone: the axes move one after the other."""

    def motion(shares: Array, share: float = 1.0) -> Reference:
        return doublets(now.room, of(now.study, now.run, "doublets", now.number), share * shares)

    axes = np.eye(axes_of(now.room))
    shares = [largest(now.model, partial(motion, axis), now.flights) for axis in axes]
    return motion(np.array(shares))


ARMS: dict[str, Callable[[_Flown], Reference]] = {
    "designed": _designed,
    "random": _random,
    "doublets": _doublets,
    "task": _task,
}
