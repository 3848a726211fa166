"""The chosen candidate as it was simulated: one rollout under one draw of the residual, kept as a flight table."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from infotraj.dynamics import rigid_body
from infotraj.dynamics.allocation import Allocation
from infotraj.experiment.common.config import ExperimentConfig
from infotraj.experiment.common.randomness import generator
from infotraj.flight import ATTITUDE, COMMANDED_WRENCH, POSITION, RATE, VELOCITY, Flight
from infotraj.informative.simulation import EstimateNoise, Simulator
from infotraj.residual.draws import PosteriorDraws
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference, read_reference
from infotraj.vehicle import Vehicle, load_vehicle


def simulate_chosen(
    config: ExperimentConfig, plant: str, seed: int, round: int, *, reference: Path, model: Path, rollout: Path
) -> None:
    """Simulates the chosen reference once more, with a draw of its own, and writes the rollout as a flight table."""
    vehicle, chosen, process = load_vehicle(config.vehicle), read_reference(reference), GaussianProcess.load(model)
    rng = generator(config.base_seed, plant, seed, "shown rollout", round)
    simulator = Simulator(vehicle, process, config.gains, EstimateNoise(*config.selection.estimate_noise))
    commands, moved = simulator.rollout(chosen, PosteriorDraws.sample(process, rng, 1), rng)
    as_flight(vehicle, chosen, commands[0], moved[0]).write(rollout)


def as_flight(vehicle: Vehicle, reference: Reference, commands: Array, moved: Array) -> Flight:
    """Commands (n, 6), scaled, and states (n, 13) as a flight table: what it would have logged without noise."""
    wrench = commands * rigid_body.scale(vehicle)
    rotor, tilt = Allocation(vehicle).actuators(wrench)
    columns: dict[str, Array] = {"t": reference.t}
    for names, values in (
        (POSITION, moved[:, :3]),
        (ATTITUDE, moved[:, 3:7]),
        (VELOCITY, moved[:, 7:10]),
        (RATE, moved[:, 10:]),
        (COMMANDED_WRENCH, wrench),
        ([f"cmd_rotor_{i}" for i in range(rotor.shape[1])], rotor),
        ([f"cmd_tilt_{i}" for i in range(tilt.shape[1])], tilt),
    ):
        columns.update(zip(names, values.T, strict=True))
    poses = reference.table().filter(regex=r"ref_(p[xyz]|q[wxyz])$")
    table = pd.concat([pd.DataFrame(columns), poses], axis=1)
    return Flight(table, {"vehicle": vehicle.name, "robot": "simulation of h + g', one draw", "simulated": True})
