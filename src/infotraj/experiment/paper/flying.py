"""Execution by the MuJoCo plant: a reference is flown with a model; the controller's demand stays with the flight."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from infotraj.control.tracking import DEMAND, TrackingController
from infotraj.experiment.common.config import ExperimentConfig
from infotraj.experiment.common.named_files import plant_path
from infotraj.experiment.common.randomness import generator
from infotraj.flight import Flight
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.robots.robot import Robot
from infotraj.trajectories.reference import Reference, read_reference
from infotraj.vehicle import Vehicle, load_vehicle

if TYPE_CHECKING:
    from infotraj.robots.plant.plant import Plant


def plant(config: ExperimentConfig, name: str) -> Plant:
    """The plant of that name: config/plants/NAME.yaml beside the vehicle's folder."""
    from infotraj.robots.plant.plant import Plant  # late: mujoco

    return Plant.load(load_vehicle(config.vehicle), plant_path(config.vehicle, name))


def fly(
    robot: Robot,
    vehicle: Vehicle,
    reference: Reference,
    process: GaussianProcess | None,
    config: ExperimentConfig,
    rng: np.random.Generator,
) -> Flight:
    """The flight, with the demand (m/s^2 and rad/s^2) that the controller held in each row."""
    controller = TrackingController(vehicle, reference, process, config.gains)
    flight = robot.fly(reference, controller, rng)
    record = controller.record()
    # a command acts from its sample on: each row takes the last sample that is not later
    held = np.searchsorted(record["t"].to_numpy(), flight.t + 1e-9, side="right") - 1
    table = flight.table.assign(**{column: record[column].to_numpy()[held] for column in DEMAND})
    return Flight(table, flight.meta)


def fly_reference(
    config: ExperimentConfig,
    plant_name: str,
    seed: int,
    purpose: str,
    *,
    reference: Path,
    model: Path | None,
    flight: Path,
) -> None:
    """Flies a reference file with a model file (none: the first-principles model) and writes the flight table."""
    vehicle = load_vehicle(config.vehicle)
    process = None if model is None else GaussianProcess.load(model)
    rng = generator(config.base_seed, plant_name, seed, purpose)
    fly(plant(config, plant_name), vehicle, read_reference(reference), process, config, rng).write(flight)
