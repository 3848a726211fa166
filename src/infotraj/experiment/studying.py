"""When does the informative cost predict the error? The ranks of Fig. 2 under other choices, on the same flights.

Flights are flown once a run; only what scores them varies, one choice at a time from the configuration's own: region
and epsilon, number of draws, consistent or fresh draws, uncertain hyperparameters, and, as bounds of what scoring could
reach, the inputs really flown, the region really needed, and hyperparameters learned from all flights together.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import spearmanr

from infotraj.evaluation.angular_acceleration import prediction_error
from infotraj.experiment import flying
from infotraj.experiment.config import ExperimentConfig
from infotraj.experiment.learning import data_of, learn, options
from infotraj.experiment.randomness import generator
from infotraj.experiment.selecting import sample_candidates
from infotraj.experiment.tables import write_table
from infotraj.informative import region
from infotraj.informative.cost import Scorer
from infotraj.informative.simulation import EstimateNoise, Simulator
from infotraj.residual import hyperparameters
from infotraj.residual.draws import MarginalDraws, PosteriorDraws
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.learning_data import LearningData
from infotraj.rotations import Array
from infotraj.trajectories.reference import read_reference
from infotraj.vehicle import load_vehicle

OURS = "visited region, noise by the rate of the torque"
BOUND = "all three known, noise by the rate of the torque (bound)"
_POINTS_OF_ALL = 200  # learned from all flights together: the floor that no single flight can pass


def study(config: ExperimentConfig, plant: str, seed: int, *, reference: Path, table: Path) -> None:
    """Writes a row a choice: Spearman's rank correlation of cost and error over the candidates (the task left out),
    for the error about y and for the mean over the axes, and the errors' range beside what no flight can remove."""
    vehicle, robot, task = load_vehicle(config.vehicle), flying.plant(config, plant), read_reference(reference)

    def rng(*purpose: str | int) -> np.random.Generator:
        return generator(config.base_seed, plant, seed, "study", *purpose)

    def flown(what, process, *purpose) -> LearningData:
        return data_of(flying.fly(robot, vehicle, what, process, config, rng(*purpose)), vehicle, config.learning)

    prior = learn(flown(task, None, "prior"), config.prior_points, config.learning, rng("learn prior"))
    test = flown(task, prior, "test")
    points = config.correlation.points
    candidates = sample_candidates(task, vehicle, config.deviations, config.correlation.candidates, rng("candidates"))
    data = [flown(candidate, prior, "flight", k) for k, candidate in enumerate(candidates)]
    models = [learn(own, points, config.learning, rng("learn", k), prior) for k, own in enumerate(data)]
    errors = np.array([prediction_error(model, test).by_axis for model in models])
    together = LearningData(
        np.arange(sum(len(d.t) for d in data), dtype=float),
        np.concatenate([d.inputs for d in data]),
        np.concatenate([d.outputs for d in data]),
    )
    best = learn(together, _POINTS_OF_ALL, config.learning, rng("learn all"))

    simulator = Simulator(vehicle, prior, config.gains, EstimateNoise(*config.selection.estimate_noise))
    draws = PosteriorDraws.sample(prior, rng("draws"), config.selection.draws)
    commands = simulator.commands([*candidates, task], draws, rng("noise"))
    fresh = simulator.commands(
        [*candidates, task], MarginalDraws(prior, rng("fresh"), config.selection.draws), rng("noise")
    )
    visited = _rows(commands[-1])
    radius = region.epsilon(prior, draws, commands[-1])
    count = config.selection.region_points
    needed = region.visited_region(visited, count, rng("region"))
    sampled = hyperparameters.sample_hyperparameters(prior, rng("hyper"), 8, **options(config.learning))
    known = GaussianProcess(
        prior.X, prior.Y, best.lengthscales, best.signal_variance, best.noise_variance, prior.prior_mean
    )
    shortest = min(len(d.inputs) for d in data)
    inputs = np.stack([d.inputs[:shortest] for d in data])[:, None]

    def uniform(scale: float) -> Array:
        return region.uniform_region(visited, scale * radius, count, rng("region", _scale_name(scale)))

    chosen = commands[:-1]
    choices: list[tuple[str, tuple[GaussianProcess, ...], Array, Array]] = [
        (OURS, (prior,), needed, chosen),
        ("visited region", (prior,), needed, chosen),
        ("uniform region, epsilon from simulation", (prior,), uniform(1.0), chosen),
        ("uniform region, half of epsilon", (prior,), uniform(0.5), chosen),
        ("uniform region, twice epsilon", (prior,), uniform(2.0), chosen),
        ("one draw", (prior,), needed, chosen[:, :1]),
        ("fresh marginal draws", (prior,), region.visited_region(_rows(fresh[-1]), count, rng("region")), fresh[:-1]),
        ("8 draws of the hyperparameters", tuple(sampled), needed, chosen),
        ("hyperparameters of all flights (bound)", (known,), needed, chosen),
        ("inputs flown and region needed (bound)", (prior,), test.inputs, inputs),
        ("all three known (bound)", (known,), test.inputs, inputs),
        (BOUND, (known,), test.inputs, inputs),
    ]
    floor = prediction_error(best, test).by_axis
    rows = []
    for name, processes, where, flights in choices:
        late = config.selection.response_time if name in (OURS, BOUND) else 0.0
        period = task.dt if flights.shape[2] > shortest else float(np.median(np.diff(data[0].t)))
        scorer = Scorer(processes, where, points, response_time=late, period=period)
        cost = scorer.costs(flights, rng("score")).mean(axis=1)
        rows.append(
            {
                "plant": plant,
                "seed": seed,
                "choice": name,
                "rank_y": spearmanr(cost, errors[:, 1]).statistic,
                "rank_mean": spearmanr(cost, errors.mean(axis=1)).statistic,
                "epsilon": radius,
                "error_y_best": errors[:, 1].min(),
                "error_y_median": np.median(errors[:, 1]),
                "error_y_worst": errors[:, 1].max(),
                "error_y_all_flights": floor[1],
            }
        )
        print(f"{name}: {rows[-1]['rank_y']:.2f} about y, {rows[-1]['rank_mean']:.2f} over the axes", flush=True)
    write_table(pd.DataFrame(rows), table)


def summarise(*, tables: list[Path], markdown: Path) -> None:
    """Writes a Markdown table: a row a choice, median and range of the rank correlations over the runs."""
    runs = pd.concat([pd.read_csv(path) for path in tables], ignore_index=True)
    lines = ["| choice | about y: median (range) | mean over the axes: median (range) |", "|---|---|---|"]
    for name, part in runs.groupby("choice", sort=False):
        cells = [
            f"{part[c].median():.2f} ({part[c].min():.2f} to {part[c].max():.2f})" for c in ("rank_y", "rank_mean")
        ]
        lines.append(f"| {name} | {cells[0]} | {cells[1]} |")
    one = runs.drop_duplicates(["plant", "seed"])
    lines += [
        "",
        f"{len(one)} runs. Error about y, medians over the runs: best candidate {one['error_y_best'].median():.3f}, "
        f"median {one['error_y_median'].median():.3f}, worst {one['error_y_worst'].median():.3f} rad/s^2; a model of "
        f"{_POINTS_OF_ALL} points from all flights leaves {one['error_y_all_flights'].median():.3f}.",
    ]
    markdown.parent.mkdir(parents=True, exist_ok=True)
    markdown.write_text("\n".join(lines) + "\n")


def _scale_name(scale: float) -> str:
    """The name of a multiple of epsilon among the purposes of random numbers."""
    return f"epsilon x {scale:g}"


def _rows(commands: Array) -> Array:
    return commands.reshape(-1, commands.shape[-1])
