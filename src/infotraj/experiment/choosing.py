"""The informative reference of a run's round: candidates are sampled, simulated, scored, and the best is written."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from infotraj.experiment.config import ExperimentConfig
from infotraj.experiment.randomness import generator
from infotraj.experiment.selecting import sample_candidates, score
from infotraj.experiment.tables import write_table
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.trajectories.reference import read_reference
from infotraj.vehicle import load_vehicle


def choose_informative(
    config: ExperimentConfig,
    plant: str,
    seed: int,
    round: int,
    *,
    task: Path,
    model: Path,
    reference: Path,
    costs: Path,
    region: Path,
) -> None:
    """Writes the candidate of least cost (CSV), the cost of all (CSV) and the region with its epsilon (npz)."""
    vehicle, around, prior = load_vehicle(config.vehicle), read_reference(task), GaussianProcess.load(model)
    rng = generator(config.base_seed, plant, seed, "candidates", round)
    candidates = sample_candidates(around, vehicle, config.deviations, config.selection.candidates, rng)
    rng = generator(config.base_seed, plant, seed, "score", round)
    scored = score(around, candidates, vehicle, prior, config, max(config.added_points), rng)
    write_table(scored.table(), costs)
    np.savez_compressed(region, region=scored.region, epsilon=np.nan if scored.epsilon is None else scored.epsilon)
    candidates[scored.chosen].write(reference)
