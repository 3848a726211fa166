"""Fig. 2: candidates around the pitching task are scored, then each is flown, learned and evaluated."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from infotraj.evaluation.angular_acceleration import prediction_error
from infotraj.experiment.common.config import ExperimentConfig
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.paper import flying
from infotraj.experiment.paper.learning import data_of, known, learn
from infotraj.experiment.paper.selecting import TASK, sample_candidates, score, simulate
from infotraj.trajectories.reference import read_reference
from infotraj.vehicle import load_vehicle

PITCH_AXIS = 1


def correlate(config: ExperimentConfig, plant: str, seed: int, *, reference: Path, table: Path) -> None:
    """Writes a row a candidate (-1 is the task): our cost, the paper's, and error and its spread about y, rad/s^2.

    The error is what a model with `correlation.points` of the candidate's flight leaves of the residual of a test
    flight, which is the task flown with the prior model ("test data generated with the prior model", Sec. V-A).
    """
    vehicle, robot, task = load_vehicle(config.vehicle), flying.plant(config, plant), read_reference(reference)

    def rng(*purpose: str | int):
        return generator(config.base_seed, plant, seed, "correlation", *purpose)

    def flown(what, process, *purpose):
        return data_of(flying.fly(robot, vehicle, what, process, config, rng(*purpose)), vehicle, config.learning)

    first, affine = flown(task, None, "prior flight"), known(config.learning, vehicle)
    prior = learn(first, config.prior_points, config.learning, rng("prior"), affine=affine)
    test = flown(task, prior, "test flight")
    settings = config.correlation
    candidates = sample_candidates(task, vehicle, config.deviations, settings.candidates, rng("candidates"))
    simulated = simulate(task, candidates, vehicle, prior, config, rng("simulate"))
    chosen_by = {"cost": config.selection.cost, "cost_paper": config.selection.paper}
    costs = {
        name: score(simulated, cost, config.selection, settings.points, rng("score")).table()["cost"]
        for name, cost in chosen_by.items()
    }
    errors = []
    for k, candidate in enumerate([*candidates, task]):
        data = flown(candidate, prior, "flight", k)
        model = learn(data, settings.points, config.learning, rng("model", k), prior)
        errors.append(prediction_error(model, test).absolute[:, PITCH_AXIS])
        print(f"candidate {k + 1} of {len(candidates) + 1}: {errors[-1].mean():.4f} rad/s^2", flush=True)
    names = {"plant": plant, "seed": seed, "candidate": [*range(len(candidates)), TASK]}
    found = {"error": [e.mean() for e in errors], "error_std": [e.std() for e in errors]}
    write_table(pd.DataFrame({**names, **costs, **found}), table)
