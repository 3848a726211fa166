"""Flies the runs of the hidden-effect study. What the diagnosis gets and what the scorer keeps go to two folders.

The plant is the configured vehicle's, with what is hidden, under a controller that was set up for that vehicle. The
vehicle file that is shown may be wrong, and the flights that are shown may be logged roughly: the vehicle flies alike.
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from infotraj.control.thrust_vector import AGILE, ThrustVectorController
from infotraj.control.tracking import TrackingController
from infotraj.errors import InfotrajError
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.hidden.cases import Batch, Case, hidden_values
from infotraj.experiment.hidden.config import Flights, HiddenStudy
from infotraj.experiment.hidden.file_profiles import wrong_file
from infotraj.experiment.hidden.logs import logged, roughly_logged
from infotraj.flight import COMMANDED_WRENCH, Flight
from infotraj.models.file import vehicle_content
from infotraj.trajectories.standard import Extent, standard
from infotraj.vehicle import Vehicle, load_vehicle

SETTLE = 4.0  # s


def fly_batch(study: HiddenStudy, batch: Batch, *, flights: Path, truth: Path) -> None:
    """Writes, for the run of each seed, flights/run_K (vehicle.yaml and flight tables) and truth/run_K.

    The truth holds run.yaml, truth.yaml, vehicle.yaml (the file as it should be), the held-out flights, and `floor`
    flights: the same without anything hidden.
    """
    for number, seed in enumerate(batch.seeds):
        fly_run(study, batch.case, seed, flights / f"run_{number}", truth / f"run_{number}")


def fly_run(study: HiddenStudy, case: Case, seed: int, shown: Path, kept: Path) -> None:
    """One run: what is shown to the diagnosis, and what is kept for the scorer."""
    from infotraj.robots.plant.hiding import clutter, gusty, hide
    from infotraj.robots.plant.truth_file import write_truth

    settings = study.vehicles[case.vehicle]
    content = yaml.safe_load(Path(settings.file).read_text())
    if case.voltage is not None:
        content["nominal_voltage"] = case.voltage
    for folder in (shown, kept):
        folder.mkdir(parents=True, exist_ok=True)
    (kept / "vehicle.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    vehicle = load_vehicle(kept / "vehicle.yaml")
    effects, other = hidden_values(case, seed, study, vehicle)

    def rng(*purpose: str | int) -> np.random.Generator:
        return generator(study.base_seed, "hidden flights", case.vehicle, case.flown, seed, *purpose)

    file = wrong_file(vehicle, case.file, rng("file"))
    given = content if case.file == "exact" else vehicle_content(file)
    (shown / "vehicle.yaml").write_text(yaml.safe_dump(given, sort_keys=False))

    # A pack that sags in the log alone, as behind speed controllers that make up for it.
    silent = [("battery_sag", {"exponent": 0.0})] if case.kind == "nothing" and case.voltage else []
    truth = hide(vehicle, [*effects, *other, *silent])
    if case.clutter:
        truth = clutter(truth, vehicle, study.clutter.model_dump(), rng("clutter"))
    if case.gusts:
        truth = gusty(truth, vehicle, study.gusts.model_dump(), rng("gusts"))
    ideal = hide(vehicle, [], name="floor")
    swings = any(name == "suspended_load" for name, _ in case.effects)
    flights = settings.gentle if swings and settings.gentle else settings.flights
    # fast paths as wide as they are fast: equally many turns a second
    more = {"speed": flights.speed * flights.faster, "size": flights.size * flights.faster}
    faster = flights.model_copy(update=more)
    failed = ""
    try:
        for k, kind in enumerate(flights.train):
            flight = fly_one(vehicle, truth, kind, flights, case, rng("reference", k), rng("noise", k), rng("log", k))
            if case.file != "exact":  # the commanded wrench is of another file than the one that is shown
                flight = Flight(flight.table.drop(columns=list(COMMANDED_WRENCH), errors="ignore"), flight.meta)
            flight.write(shown / f"flight_{k}.parquet")
        for k, kind in enumerate(flights.held_out):
            for what, plant in (("held_out", truth), ("floor", ideal)):
                path, noise = rng("held-out reference", k), rng("held-out noise", k)
                flight = fly_one(vehicle, plant, kind, faster, case, path, noise)
                flight.write(kept / f"{what}_{k}.parquet")
    except InfotrajError as error:
        failed = str(error)
    about: dict[str, Any] = {
        "case": asdict(case),
        "name": case.name,
        "seed": seed,
        "effects": [{"name": n, "parameters": v} for n, v in effects],
        "other": [{"name": n, "parameters": v} for n, v in other],
        "nearest": [n for name in case.other if name in settings.richer for n in settings.richer[name].nearest],
        "failed": failed,
    }
    (kept / "run.yaml").write_text(yaml.safe_dump(plain_values(about), sort_keys=False))
    write_truth(truth, kept / "truth.yaml")


def fly_one(
    vehicle: Vehicle,
    truth: Any,
    kind: str,
    flights: Flights,
    case: Case,
    path: np.random.Generator,
    noise: np.random.Generator,
    log: np.random.Generator | None = None,
) -> Flight:
    """One flight; log: of the log profile, None for the scorer's own flights."""
    from infotraj.robots.plant.plant import Plant  # late: mujoco
    from infotraj.robots.plant.sensors import Noise

    extent = Extent(flights.size, flights.pace, flights.low, flights.tilt, flights.speed)
    reference = standard(kind, case.seconds or flights.seconds, extent, path)
    controller: TrackingController | ThrustVectorController
    if vehicle.tilts:
        controller = TrackingController(vehicle, reference)
    else:
        controller = ThrustVectorController(vehicle, reference, AGILE if flights.gains == "agile" else None)
    usual = Noise()
    sensors = Noise(*(case.noise * np.array([usual.position, usual.attitude, usual.rate, usual.specific_force])))
    flight, true = Plant(vehicle, truth, settle=SETTLE, noise=sensors).fly_with_truth(reference, controller, noise)
    if log is None or case.log == "clean":
        return logged(flight, case.logging)
    return roughly_logged(logged(flight, "full"), true, case.log, vehicle, case.noise, log)


def plain_values(value: Any) -> Any:
    """Tuples as lists, numpy numbers as Python's: what YAML holds."""
    if isinstance(value, dict):
        return {k: plain_values(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain_values(v) for v in value]
    return value.item() if isinstance(value, np.generic) else value
