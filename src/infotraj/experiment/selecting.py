"""From a prior model to the informative reference: sample, simulate, score, choose (Sec. III-C, steps 1 to 6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from infotraj.dynamics.allocation import Allocation
from infotraj.experiment.config import Deviations, ExperimentConfig, Selection
from infotraj.experiment.learning import options
from infotraj.informative import region
from infotraj.informative.cost import Scorer
from infotraj.informative.simulation import EstimateNoise, Simulator
from infotraj.residual import hyperparameters
from infotraj.residual.draws import PosteriorDraws
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.rotations import Array
from infotraj.trajectories.deviations import DeviationSpace, deviate, within_limits
from infotraj.trajectories.reference import Reference
from infotraj.vehicle import Vehicle


@dataclass(frozen=True)
class Scored:
    """Candidates (the task itself last), their simulated commands (references, draws, n, 6) and costs
    (references, draws), and the region (r, 6) with its epsilon, which is None where the region does not need one."""

    references: list[Reference]
    commands: Array
    costs: Array
    region: Array
    epsilon: float | None

    @property
    def chosen(self) -> int:
        """The candidate with the smallest cost, the task not being one."""
        return int(np.argmin(self.costs[:-1].mean(axis=1)))

    def table(self) -> pd.DataFrame:
        """One row a candidate, -1 being the task: cost (mean over draws), its spread, and which is chosen."""
        count = len(self.references) - 1
        return pd.DataFrame(
            {
                "candidate": [*range(count), -1],
                "cost": self.costs.mean(axis=1),
                "cost_std": self.costs.std(axis=1),
                "chosen": [i == self.chosen for i in range(count + 1)],
            }
        )


def sample_candidates(
    task: Reference, vehicle: Vehicle, settings: Deviations, count: int, rng: np.random.Generator
) -> list[Reference]:
    """`count` candidate references: the task with sampled deviations, each within the vehicle's limits."""
    space = DeviationSpace(
        settings.max_acceleration,
        settings.min_frequency,
        settings.max_frequency,
        np.radians(settings.max_angle_deg),
        settings.terms,
        settings.max_jerk,
    )
    allocation = Allocation(vehicle)
    return [deviate(task, within_limits(task, space.sample(rng), allocation)) for _ in range(count)]


def score(
    task: Reference,
    candidates: list[Reference],
    vehicle: Vehicle,
    prior: GaussianProcess,
    config: ExperimentConfig,
    points: int,
    rng: np.random.Generator,
    threads: int = 1,
) -> Scored:
    """Simulates and scores candidates and the task for a model that will learn `points` from the flight."""
    settings = config.selection
    simulator = Simulator(vehicle, prior, config.gains, EstimateNoise(*settings.estimate_noise), threads)
    draws = PosteriorDraws.sample(prior, rng, max(settings.draws, settings.task_draws))
    references = [*candidates, task]
    commands = simulator.commands(references, draws, rng)
    points_of_region, radius = _region(settings, prior, draws, commands[-1, : settings.task_draws], rng)
    models = (
        (prior,)
        if settings.hyperparameter_samples == 1
        else tuple(
            hyperparameters.sample_hyperparameters(
                prior, rng, settings.hyperparameter_samples, **options(config.learning)
            )
        )
    )
    scorer = Scorer(models, points_of_region, points, threads, settings.response_time, task.dt)
    costs = scorer.costs(commands[:, : settings.draws], rng)
    return Scored(references, commands, costs, points_of_region, radius)


def _region(
    settings: Selection, prior: GaussianProcess, draws: PosteriorDraws, commands: Array, rng: np.random.Generator
) -> tuple[Array, float | None]:
    visited = commands.reshape(-1, commands.shape[-1])
    if settings.region == "visited":
        return region.visited_region(visited, settings.region_points, rng), None
    radius = settings.epsilon or region.epsilon(prior, draws, commands)
    return region.uniform_region(visited, radius, settings.region_points, rng), radius
