"""The cases of the study of separating flights (config/studies/separating_*.yaml): which effect, which plant."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field, model_validator

from infotraj.errors import UsageError, problem
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.common.strict_yaml import Strict, read_yaml
from infotraj.experiment.hidden.cases import Case, hidden_values
from infotraj.experiment.hidden.config import Count, Flights, HiddenStudy, Sizes, WrongFile, read_study
from infotraj.experiment.hidden.room import Room
from infotraj.vehicle import Vehicle


class Pair(Strict):
    """Two effects of the catalogue on one vehicle."""

    vehicle: str
    effects: tuple[str, str]

    @property
    def name(self) -> str:
        """`quadrotor: mass_offset or thrust_scale`."""
        return f"{self.vehicle}: {self.effects[0]} or {self.effects[1]}"


class SeparatingStudy(Strict):
    """The whole study."""

    hidden: str = Field(description="the hidden-effect study: vehicles and usual sizes")
    base_seed: Count
    files: tuple[WrongFile, ...] = Field(min_length=1, description="how wrong the shown file is; drawn")
    sizes: Sizes = Field(description="times the usual size, least and most")
    task: Flights = Field(description="the task's flights; what they leave undecided is asked")
    room: Room
    candidates: int = Field(ge=3, description="motions that the design tries")
    designed: int = Field(ge=1, description="flights at most, each designed after the one before")
    random: int = Field(ge=1, description="random deviations at most")
    runs: int = Field(ge=1, description="of each pair")
    pairs: tuple[Pair, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _told_apart(self) -> SeparatingStudy:
        for pair in self.pairs:
            if pair.effects[0] == pair.effects[1]:
                raise ValueError(f"pairs: {pair.effects[0]} twice")
        return self


@dataclass(frozen=True)
class Run:
    """One plant: `pair` (its place in the study), number, and which of the two effects it hides."""

    pair: int
    number: int

    @property
    def hides(self) -> int:
        """0 or 1: the effects take turns."""
        return self.number % 2


def read_separating(path: str | Path) -> tuple[SeparatingStudy, HiddenStudy]:
    """The study's file and the hidden-effect study that it names. UsageError, one line, where it cannot be used."""
    study = read_yaml(SeparatingStudy, path)
    hidden = read_study(Path(path).parent / study.hidden)
    for pair in study.pairs:
        known = hidden.vehicles.get(pair.vehicle)
        if known is None or not set(pair.effects) <= set(known.effects):
            raise UsageError(problem(f"{path}: {pair.name}", f"a vehicle and effects of {study.hidden}", "Correct it."))
    return study, hidden.model_copy(update={"base_seed": study.base_seed})


def runs(study: SeparatingStudy) -> list[Run]:
    """All runs, one of every pair after the other, so that a part of them is a fair sample."""
    return [Run(pair, number) for number in range(study.runs) for pair in range(len(study.pairs))]


def drawn(study: SeparatingStudy, hidden: HiddenStudy, run: Run, vehicle: Vehicle) -> tuple[str, dict[str, Any], float]:
    """What a run hides: the effect's name, its numbers, and its size in times the usual one."""
    pair = study.pairs[run.pair]
    name = pair.effects[run.hides]
    low, high = study.sizes
    high = max(low, min(high, hidden.vehicles[pair.vehicle].effects[name].sizes[2]))
    size = float(np.exp(of(study, run, "size").uniform(np.log(low), np.log(high))))
    effects, _ = hidden_values(Case(pair.vehicle, "single", ((name, size),)), run.number, hidden, vehicle)
    return *effects[0], size


def of(study: SeparatingStudy, run: Run, *purpose: str | int) -> np.random.Generator:
    """The run's own random numbers for one purpose."""
    pair = study.pairs[run.pair]
    return generator(study.base_seed, "separating", pair.vehicle, *pair.effects, run.number, *purpose)
