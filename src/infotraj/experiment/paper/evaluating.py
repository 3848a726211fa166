"""What learning brought: the task and the modified task flown with each model (Fig. 4, 5 and Table I)."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from infotraj.evaluation.angular_acceleration import AxisErrors, prediction_error, tracking_error
from infotraj.experiment.common.config import ExperimentConfig
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.paper import flying
from infotraj.experiment.paper.learning import data_of
from infotraj.flight import read_flight
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.trajectories.reference import read_reference
from infotraj.vehicle import load_vehicle


def fly_with_models(
    config: ExperimentConfig,
    plant: str,
    seed: int,
    *,
    references: dict[str, Path],
    models: dict[str, Path | None],
    flights: dict[str, Path],
) -> None:
    """Flies REFERENCE with MODEL for every key "REFERENCE/MODEL" of `flights`; noise differs."""
    vehicle, robot = load_vehicle(config.vehicle), flying.plant(config, plant)
    known = {name: read_reference(path) for name, path in references.items()}
    for key, path in flights.items():
        reference, model = key.split("/")
        learned = models[model]
        process = None if learned is None else GaussianProcess.load(learned)
        rng = generator(config.base_seed, plant, seed, f"validate {key}")
        flying.fly(robot, vehicle, known[reference], process, config, rng).write(path)


def row(errors: AxisErrors, **key: object) -> dict[str, object]:
    """One row of an error table: the key, then mean, spread and the mean of each axis, rad/s^2."""
    x, y, z = errors.by_axis
    return {**key, "error": errors.mean, "error_std": errors.spread, "error_x": x, "error_y": y, "error_z": z}


def tracking_table(config: ExperimentConfig, plant: str, seed: int, *, flights: dict[str, Path], table: Path) -> None:
    """One row a validation flight "REFERENCE/MODEL": its tracking error of the angular acceleration, rad/s^2."""
    vehicle = load_vehicle(config.vehicle)
    rows = []
    for key, path in flights.items():
        reference, model = key.split("/")
        source, _, points = model.partition("_")
        errors = tracking_error(read_flight(path), vehicle, config.learning.window)
        rows.append(
            row(
                errors,
                plant=plant,
                seed=seed,
                reference=reference,
                source=source,
                points=int(points or 0),
                kind="tracking",
            )
        )
    write_table(pd.DataFrame(rows), table)


def prediction_table(
    config: ExperimentConfig, plant: str, seed: int, *, flight: Path, models: dict[str, Path | None], table: Path
) -> None:
    """One row a model: what it leaves of the residual of a flight that it has not learned, rad/s^2."""
    data = data_of(read_flight(flight), load_vehicle(config.vehicle), config.learning)
    rows = []
    for model, path in models.items():
        source, _, points = model.partition("_")
        errors = prediction_error(None if path is None else GaussianProcess.load(path), data)
        rows.append(
            row(
                errors,
                plant=plant,
                seed=seed,
                reference="task",
                source=source,
                points=int(points or 0),
                kind="prediction",
            )
        )
    write_table(pd.DataFrame(rows), table)
