"""The cases of the study of changes (config/studies/changes.yaml): what changes on which plant, and in which order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from infotraj.errors import UsageError, problem
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.common.strict_yaml import Strict, read_yaml
from infotraj.experiment.hidden.cases import Case, hidden_values
from infotraj.experiment.hidden.config import Count, HiddenStudy, Sizes, VehicleStudy, WrongFile, read_study
from infotraj.vehicle import NotNegative, Vehicle

Effects = list[tuple[str, dict[str, Any]]]


class Drift(Strict):
    """What differs from day to day and is no change: standard deviations."""

    thrust: NotNegative = Field(description="share of the thrust of all rotors")
    rotors: NotNegative = Field(description="share of each rotor's thrust")
    trim: NotNegative = Field(description="of the centre of mass, share of the rotors' mean distance, an axis")


class Counts(Strict):
    """How many cases of each kind."""

    single: Count = 0
    several: Count = 0
    nothing: Count = 0


class ChangeStudy(Strict):
    """The whole study."""

    hidden: str = Field(description="the hidden-effect study beside it: vehicles, paths, usual sizes, pairs, triples")
    base_seed: Count
    file: WrongFile
    sizes: Sizes = Field(description="times the usual size, least and most")
    healthy: int = Field(ge=1, description="flights, on as many days")
    batch: int = Field(ge=1, description="cases a job")
    drift: Drift
    cases: dict[str, Counts]


@dataclass(frozen=True)
class Change:
    """One plant before and after. effects: (name of the hidden-effect study, multiple of its usual size)."""

    vehicle: str
    kind: str
    effects: tuple[tuple[str, float], ...]
    number: int

    @property
    def name(self) -> str:
        """Readable: quadrotor/single/linear_drag."""
        return f"{self.vehicle}/{self.kind}/" + ("+".join(n for n, _ in self.effects) or "nothing")


def read_changes(path: str | Path) -> tuple[ChangeStudy, HiddenStudy]:
    """The study's file and the hidden-effect study that it names. UsageError, one line, where it cannot be used."""
    study = read_yaml(ChangeStudy, path)
    hidden = read_study(Path(path).parent / study.hidden)
    unknown = sorted(set(study.cases) - set(hidden.vehicles))
    if unknown:
        raise UsageError(problem(f"{path}: vehicle {unknown[0]}", " or ".join(hidden.vehicles), "Correct it."))
    return study, hidden.model_copy(update={"base_seed": study.base_seed})


def changes(study: ChangeStudy, hidden: HiddenStudy, vehicle: str) -> list[Change]:
    """The cases of a vehicle, in random order: what is made of them so far is a fair sample of all."""
    rng = generator(study.base_seed, "changes", vehicle)
    settings, count = hidden.vehicles[vehicle], study.cases[vehicle]
    drawn: list[tuple[str, tuple[str, ...]]] = [("nothing", ())] * count.nothing
    drawn += [("single", (n,)) for n in _taken([n for n in settings.effects if _alone(settings, n)], count.single, rng)]
    drawn += [("several", s) for s in _taken([*settings.pairs, *settings.triples], count.several, rng)]
    order = rng.permutation(len(drawn))
    return [
        Change(vehicle, drawn[i][0], tuple((n, _multiple(study, settings, n, rng)) for n in drawn[i][1]), number)
        for number, i in enumerate(order)
    ]


def batches(study: ChangeStudy, hidden: HiddenStudy) -> dict[str, list[Change]]:
    """The cases of each job, by its key: `quadrotor_0`."""
    found: dict[str, list[Change]] = {}
    for vehicle in study.cases:
        every = changes(study, hidden, vehicle)
        found |= {
            f"{vehicle}_{k // study.batch}": every[k : k + study.batch] for k in range(0, len(every), study.batch)
        }
    return found


def changed_effects(change: Change, hidden: HiddenStudy, vehicle: Vehicle) -> Effects:
    """What changes, with its numbers."""
    case = Case(change.vehicle, change.kind, change.effects)
    return hidden_values(case, change.number, hidden, vehicle)[0]


def day(drift: Drift, vehicle: Vehicle, rng: np.random.Generator) -> Effects:
    """What one day brings, as effects: thrust of all rotors, thrust of each, another trim."""
    n = len(vehicle.rotors)
    reach = float(np.mean([np.linalg.norm(r.position) for r in vehicle.rotors]))
    common = 1.0 + drift.thrust * rng.standard_normal()
    each = 1.0 + drift.rotors * rng.standard_normal(n)
    trim = drift.trim * reach * rng.standard_normal(3)
    return [
        ("thrust_scale", {"factor": float(common)}),
        *(("rotor_effectiveness", {"rotor": k, "factor": float(f)}) for k, f in enumerate(each)),
        ("com_offset", {"r": trim.tolist()}),
    ]


def _alone(settings: VehicleStudy, name: str) -> bool:
    return settings.effects[name].alone and settings.effects[name].voltage is None


def _taken(names: Sequence[Any], count: int, rng: np.random.Generator) -> list[Any]:
    """So many of these, each as often as any other, but for one."""
    out: list[Any] = []
    while len(out) < count and len(names):
        out += [names[i] for i in rng.permutation(len(names))]
    return out[:count]


def _multiple(study: ChangeStudy, settings: VehicleStudy, name: str, rng: np.random.Generator) -> float:
    """A size between the study's limits, where the effect's own largest size allows it."""
    low, high = study.sizes
    high = max(low, min(high, settings.effects[name].sizes[2]))
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
