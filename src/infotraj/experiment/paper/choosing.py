"""Who chooses the reference of a run's round, all among the same candidates: our cost, the paper's cost, or chance."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from infotraj.experiment.common.config import ExperimentConfig
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.paper.selecting import sample_candidates, score, simulate
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.trajectories.reference import Reference, read_reference
from infotraj.vehicle import load_vehicle


def candidates_of(config: ExperimentConfig, plant: str, seed: int, round: int, task: Reference) -> list[Reference]:
    """The candidates of a run's round, the same whoever chooses among them."""
    rng = generator(config.base_seed, plant, seed, "candidates", round)
    return sample_candidates(task, load_vehicle(config.vehicle), config.deviations, config.selection.candidates, rng)


def choose(
    config: ExperimentConfig,
    plant: str,
    seed: int,
    round: int,
    source: str,
    *,
    task: Path,
    model: Path,
    reference: Path,
    costs: Path,
    region: Path,
) -> None:
    """Writes the candidate of least cost (CSV), the cost of all (CSV) and the region with its epsilon (npz).

    source: `informative` chooses by `selection.cost`, `paper` by the paper's cost word for word.
    """
    vehicle, around, prior = load_vehicle(config.vehicle), read_reference(task), GaussianProcess.load(model)
    candidates = candidates_of(config, plant, seed, round, around)
    rng = generator(config.base_seed, plant, seed, "score", round)
    simulated = simulate(around, candidates, vehicle, prior, config, rng)
    settings = config.selection
    cost = settings.paper if source == "paper" else settings.cost
    scored = score(simulated, cost, settings, max(config.added_points), rng)
    write_table(scored.table(), costs)
    np.savez_compressed(region, region=scored.region, epsilon=np.nan if scored.epsilon is None else scored.epsilon)
    candidates[scored.chosen].write(reference)


def choose_random(config: ExperimentConfig, plant: str, seed: int, round: int, *, task: Path, reference: Path) -> None:
    """Writes one of the same candidates (CSV), drawn without a look at its cost: what choosing has to beat."""
    candidates = candidates_of(config, plant, seed, round, read_reference(task))
    rng = generator(config.base_seed, plant, seed, "random", round)
    candidates[rng.integers(len(candidates))].write(reference)
