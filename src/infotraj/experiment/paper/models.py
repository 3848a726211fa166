"""Model files of a run: the prior from the first flight, and what each round's flights add to it (eq. 6, 7)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from infotraj.experiment.common.config import ExperimentConfig
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.paper.learning import data_of, known, learn
from infotraj.flight import read_flight
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.vehicle import load_vehicle


def learn_prior(config: ExperimentConfig, plant: str, seed: int, *, flight: Path, model: Path) -> None:
    """Writes the prior model: `prior_points` of the first flight."""
    vehicle, learning = load_vehicle(config.vehicle), config.learning
    data = data_of(read_flight(flight), vehicle, learning)
    rng = generator(config.base_seed, plant, seed, "prior model")
    learn(data, config.prior_points, learning, rng, affine=known(learning, vehicle)).save(model)


def learn_round(
    config: ExperimentConfig,
    plant: str,
    seed: int,
    source: str,
    *,
    start: Path,
    flight: Path,
    models: Mapping[int, Path],
) -> None:
    """Writes a model for each {points: file}: the starting model's points and so many of the flight of `source`."""
    data = data_of(read_flight(flight), load_vehicle(config.vehicle), config.learning)
    before = GaussianProcess.load(start)
    for points, path in models.items():
        rng = generator(config.base_seed, plant, seed, f"learn {source} from {before.n}", points)
        learn(data, points, config.learning, rng, before).save(path)
