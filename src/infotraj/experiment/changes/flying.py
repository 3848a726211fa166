"""Flies the plants of the study of changes: healthy flights of several days, then flights with what has changed.

What the diagnosis gets and what the scorer keeps go to two folders. The plant is the configured vehicle's; the vehicle
file that is shown is wrong by the study's profile, before and after alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import yaml

from infotraj.errors import InfotrajError
from infotraj.experiment.changes.cases import Change, ChangeStudy, changed_effects, day
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.hidden.cases import Case
from infotraj.experiment.hidden.config import HiddenStudy
from infotraj.experiment.hidden.file_profiles import wrong_file
from infotraj.experiment.hidden.flying import fly_one, plain_values
from infotraj.flight import COMMANDED_WRENCH, Flight
from infotraj.models.file import vehicle_content
from infotraj.vehicle import load_vehicle


def fly_changes(
    study: ChangeStudy, hidden: HiddenStudy, batch: Sequence[Change], *, flights: Path, truth: Path
) -> None:
    """Writes, for each case, flights/case_K (vehicle.yaml, healthy_*.parquet, now_*.parquet) and truth/case_K.

    The truth holds run.yaml: the case, what changed with its numbers, and why it could not be flown, if so.
    """
    for change in batch:
        name = f"case_{change.number:03d}"
        fly_change(study, hidden, change, flights / name, truth / name)


def fly_change(study: ChangeStudy, hidden: HiddenStudy, change: Change, shown: Path, kept: Path) -> None:
    """One case: what is shown to the diagnosis, and what is kept for the scorer."""
    from infotraj.robots.plant.hiding import hide

    settings = hidden.vehicles[change.vehicle]
    for folder in (shown, kept):
        folder.mkdir(parents=True, exist_ok=True)
    vehicle = load_vehicle(settings.file)
    effects = changed_effects(change, hidden, vehicle)

    def rng(*purpose: str | int) -> np.random.Generator:
        return generator(study.base_seed, "changes flown", change.vehicle, change.number, *purpose)

    file = wrong_file(vehicle, study.file, rng("file"))
    for folder, written in ((shown, file), (kept, vehicle)):
        (folder / "vehicle.yaml").write_text(yaml.safe_dump(vehicle_content(written), sort_keys=False))
    swings = any(name == "suspended_load" for name, _ in effects)
    flights = settings.gentle if swings and settings.gentle else settings.flights
    kinds = flights.train
    today = day(study.drift, vehicle, rng("drift", "now"))
    flown = [
        (f"healthy_{k}", kinds[k % len(kinds)], day(study.drift, vehicle, rng("drift", k)))
        for k in range(study.healthy)
    ]
    flown += [(f"now_{k}", kind, [*effects, *today]) for k, kind in enumerate(kinds)]
    case = Case(change.vehicle, change.kind, change.effects)
    failed = ""
    try:
        for name, kind, own in flown:
            truth = hide(vehicle, own, name=name)
            flight = fly_one(vehicle, truth, kind, flights, case, rng(name, "path"), rng(name, "noise"), rng("log"))
            # The commanded wrench is of another file than the one that is shown.
            table = flight.table.drop(columns=list(COMMANDED_WRENCH), errors="ignore")
            Flight(table, flight.meta).write(shown / f"{name}.parquet")
    except InfotrajError as error:
        failed = str(error)
    about = {
        "name": change.name,
        **asdict(change),
        "effects": [{"name": n, "parameters": v} for n, v in effects],
        "sizes": [size for _, size in change.effects],
        "failed": failed,
    }
    (kept / "run.yaml").write_text(yaml.safe_dump(plain_values(about), sort_keys=False))
