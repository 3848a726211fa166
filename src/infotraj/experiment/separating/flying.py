"""The plant of a run: it flies the task and whatever reference it is given. What it hides stays here."""

from __future__ import annotations

from functools import partial

from infotraj.experiment.hidden import plants
from infotraj.experiment.hidden.config import HiddenStudy
from infotraj.experiment.hidden.plants import Fly
from infotraj.experiment.separating.cases import Run, SeparatingStudy, drawn, of
from infotraj.trajectories.reference import Reference
from infotraj.vehicle import Vehicle, load_vehicle


def shown_file(study: SeparatingStudy, hidden: HiddenStudy, run: Run) -> Vehicle:
    """The vehicle file as a user has it: wrong by a drawn profile."""
    return plants.file_of(_vehicle(study, hidden, run), study.files, partial(of, study, run))


def plant(study: SeparatingStudy, hidden: HiddenStudy, run: Run) -> Fly:
    """Flies references on the run's plant. The controller knows the configured vehicle, not what is hidden."""
    vehicle = _vehicle(study, hidden, run)
    name, values, _ = drawn(study, hidden, run, vehicle)
    return plants.plant(vehicle, [(name, values)], partial(of, study, run))


def task(study: SeparatingStudy, run: Run, what: str = "task") -> list[Reference]:
    """The references of the task's flights; `what`: other draws of the same kinds."""
    return plants.task(study.task, partial(of, study, run), what)


def _vehicle(study: SeparatingStudy, hidden: HiddenStudy, run: Run) -> Vehicle:
    return load_vehicle(hidden.vehicles[study.pairs[run.pair].vehicle].file)
