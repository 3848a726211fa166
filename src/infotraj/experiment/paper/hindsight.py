"""What no one has before the flight: every candidate of a run's first round flown, learned from and put into the loop.

The best of them bounds what any cost could choose, their mean is what a choice at random gives in the mean. Costs are
held against these errors in `experiment.costs`.
"""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from infotraj.evaluation.angular_acceleration import tracking_error
from infotraj.experiment.common.config import ExperimentConfig
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.paper import flying
from infotraj.experiment.paper.choosing import candidates_of
from infotraj.experiment.paper.evaluating import row
from infotraj.experiment.paper.learning import data_of, learn
from infotraj.experiment.paper.selecting import TASK
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.trajectories.reference import read_reference
from infotraj.vehicle import load_vehicle


def hindsight(config: ExperimentConfig, plant: str, seed: int, *, task: Path, model: Path, table: Path) -> None:
    """Writes a row a candidate (-1: the task itself) and data size: tracking error of the task with its model, rad/s^2.

    The candidates are those of the run's first round, `model` is its prior model. The validation flights of a run share
    their noise, so that candidates differ by what they taught.
    """
    vehicle, robot, around = load_vehicle(config.vehicle), flying.plant(config, plant), read_reference(task)
    prior = GaussianProcess.load(model)

    def rng(*purpose: str | int):
        return generator(config.base_seed, plant, seed, "hindsight", *purpose)

    rows = []
    for k, reference in {**dict(enumerate(candidates_of(config, plant, seed, 1, around))), TASK: around}.items():
        name = "task" if k == TASK else k
        data = data_of(
            flying.fly(robot, vehicle, reference, prior, config, rng("flight", name)), vehicle, config.learning
        )
        for added in config.added_points:
            learned = learn(data, added, config.learning, rng("learn", name, added), prior)
            flown = flying.fly(robot, vehicle, around, learned, config, rng("validate"))
            errors = tracking_error(flown, vehicle, config.learning.window)
            rows.append(row(errors, plant=plant, seed=seed, candidate=k, points=learned.n))
        print(f"candidate {name}: {rows[-1]['error']:.4f} rad/s^2 with {rows[-1]['points']} points", flush=True)
    write_table(pd.DataFrame(rows), table)
