"""The runs of the study of the iterated loop (config/studies/iterated.yaml): what each plant hides."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from infotraj.errors import UsageError, problem
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.common.strict_yaml import Strict, read_yaml
from infotraj.experiment.hidden.cases import Case, hidden_values
from infotraj.experiment.hidden.config import Count, Flights, HiddenStudy, Sizes, WrongFile, read_study
from infotraj.experiment.hidden.room import Room
from infotraj.vehicle import Vehicle

Kind = Literal["nothing", "single", "pair"]


class IteratedStudy(Strict):
    """The whole study."""

    hidden: str = Field(description="the hidden-effect study: vehicles, effects, usual sizes")
    base_seed: Count
    files: tuple[WrongFile, ...] = Field(min_length=1, description="how wrong the shown file is; drawn")
    sizes: Sizes = Field(description="times the usual size, least and most")
    task: Flights = Field(description="the task's flights, which every loop begins with")
    room: Room
    candidates: int = Field(ge=3, description="motions that a design tries")
    flights: int = Field(ge=2, description="after the task's, at most")
    kinds: tuple[Kind, ...] = Field(min_length=1, description="what the runs hide, in turn")
    left_out: tuple[str, ...] = Field((), description="effects that no motion in this room can show")
    runs: dict[str, Count] = Field(min_length=1, description="by vehicle")


@dataclass(frozen=True)
class Run:
    """One plant: its vehicle, its number among the vehicle's, and what kind of thing it hides."""

    vehicle: str
    number: int
    kind: str

    @property
    def name(self) -> str:
        """`quadrotor 3`."""
        return f"{self.vehicle} {self.number}"


def read_iterated(path: str | Path) -> tuple[IteratedStudy, HiddenStudy]:
    """The study's file and the hidden-effect study that it names. UsageError, one line, where it cannot be used."""
    study = read_yaml(IteratedStudy, path)
    hidden = read_study(Path(path).parent / study.hidden)
    unknown = sorted(set(study.runs) - set(hidden.vehicles))
    if unknown:
        raise UsageError(problem(f"{path}: {unknown[0]}", f"a vehicle of {study.hidden}", "Correct it."))
    return study, hidden.model_copy(update={"base_seed": study.base_seed})


def runs(study: IteratedStudy) -> list[Run]:
    """All runs, one of every vehicle after the other, so that a part of them is a fair sample."""
    most = max(study.runs.values())
    kinds = study.kinds
    return [Run(v, k, kinds[k % len(kinds)]) for k in range(most) for v, count in study.runs.items() if k < count]


def drawn(study: IteratedStudy, hidden: HiddenStudy, run: Run, vehicle: Vehicle) -> list[tuple[str, dict[str, Any]]]:
    """What a run hides: names and numbers of its effects. None comes twice before every one of its kind has come."""
    rng, known = of(study, run, "size"), hidden.vehicles[run.vehicle]
    plain = [n for n, e in known.effects.items() if e.voltage is None and n not in study.left_out]
    sets: list[tuple[str, ...]] = [()]
    if run.kind == "single":
        sets = [(n,) for n in plain if known.effects[n].alone]
    elif run.kind == "pair":
        sets = [tuple(p) for p in known.pairs if set(p) <= set(plain)]
    order = generator(study.base_seed, "iterated", run.vehicle, run.kind).permutation(len(sets))
    earlier = sum(study.kinds[k % len(study.kinds)] == run.kind for k in range(run.number))
    chosen = sets[order[earlier % len(sets)]]
    low, high = study.sizes

    def size(name: str) -> float:
        most = max(low, min(high, known.effects[name].sizes[2]))
        return float(np.exp(rng.uniform(np.log(low), np.log(most))))

    case = Case(run.vehicle, run.kind, tuple((n, size(n)) for n in chosen))
    return hidden_values(case, run.number, hidden, vehicle)[0]


def of(study: IteratedStudy, run: Run, *purpose: str | int) -> np.random.Generator:
    """The run's own random numbers for one purpose."""
    return generator(study.base_seed, "iterated", run.vehicle, run.number, *purpose)
