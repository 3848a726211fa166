"""From a prior model to the informative reference: sample, simulate, score, choose (Sec. III-C, steps 1 to 6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from infotraj.dynamics.allocation import Allocation
from infotraj.experiment.common.config import Cost, Deviations, ExperimentConfig, Selection
from infotraj.informative import region
from infotraj.informative.cost import Scorer, Subset, of_one_lengthscale
from infotraj.informative.simulation import EstimateNoise, Simulator
from infotraj.residual.draws import PosteriorDraws
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.subset import farthest_first, k_medoids
from infotraj.rotations import Array
from infotraj.trajectories.deviations import DeviationSpace, deviate, within_limits
from infotraj.trajectories.reference import Reference
from infotraj.vehicle import Vehicle

TASK = -1  # the number of the task's own flight in tables of candidates


@dataclass(frozen=True)
class Simulated:
    """References (the task last), and what each would command with draws of `prior`, (references, draws, n, 6); `task`
    holds more simulations of the task, (task_draws, n, 6)."""

    prior: GaussianProcess
    draws: PosteriorDraws
    references: list[Reference]
    commands: Array
    task: Array

    @property
    def visited(self) -> Array:
        """All inputs that the simulated task visits, (rows, 6)."""
        return self.task.reshape(-1, self.task.shape[-1])


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
                "candidate": [*range(count), TASK],
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


def simulate(
    task: Reference,
    candidates: list[Reference],
    vehicle: Vehicle,
    prior: GaussianProcess,
    config: ExperimentConfig,
    rng: np.random.Generator,
    threads: int = 1,
) -> Simulated:
    """Simulates candidates and the task in closed loop with draws of the residual (eq. 12, 14)."""
    settings = config.selection
    simulator = Simulator(vehicle, prior, config.gains, EstimateNoise(*settings.estimate_noise), threads)
    draws = PosteriorDraws.sample(prior, rng, max(settings.draws, settings.task_draws))
    references = [*candidates, task]
    commands = simulator.commands(references, draws.part(0, settings.draws), rng)
    visited = simulator.commands([task], draws.part(0, settings.task_draws), rng)[0]
    return Simulated(prior, draws, references, commands, visited)


def score(
    simulated: Simulated,
    cost: Cost,
    settings: Selection,
    points: int,
    rng: np.random.Generator,
    threads: int = 1,
) -> Scored:
    """Scores what was simulated for a model that will learn `points` from the flight (eq. 13, 15, 18)."""
    prior, commands = simulated.prior, simulated.commands
    where, radius = _region(cost, settings, simulated, rng)
    fixed = cost.kernel == "fixed"
    process = of_one_lengthscale(prior, cost.lengthscale, cost.noise) if fixed else prior
    subset: Subset = k_medoids if cost.subset == "medoids" else (lambda X, count, _: farthest_first(X, count))
    scorer = Scorer(process, where, cost.points or points, subset, threads)
    return Scored(simulated.references, commands, scorer.costs(commands, rng), where, radius)


def _region(
    cost: Cost, settings: Selection, simulated: Simulated, rng: np.random.Generator
) -> tuple[Array, float | None]:
    visited = simulated.visited
    if cost.region == "visited":
        return region.visited_region(visited, settings.region_points, rng), None
    flown = simulated.draws.part(0, len(simulated.task))
    radius = cost.epsilon or region.epsilon(simulated.prior, flown, simulated.task)
    return region.uniform_region(visited, radius, settings.region_points, rng), radius
