"""What a prior that knows physics is worth: the same run with and without it, closed into the loop.

Each prior has its own prior model and its own flights, which the model has flown; beside them the points of the flights
without the prior are learned with it, so that nothing but the fit differs. All flights of a run that validate share
their noise. A plant's truth is read by the plant alone.
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
from infotraj.experiment.paper.learning import data_of, known, learn
from infotraj.experiment.paper.selecting import score, simulate
from infotraj.flight import Flight, read_flight
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.learning_data import LearningData
from infotraj.trajectories.reference import Reference, read_reference
from infotraj.vehicle import load_vehicle

NONE, PHYSICS = "none", "physics"


def compare_priors(
    config: ExperimentConfig, plant: str, seed: int, *, task: Path, modified: Path, flight: Path, table: Path
) -> None:
    """Writes a row a validation flight: prior that flew and that learned, source, points, and the error, rad/s^2.

    flight: the run's first, which knows no residual. Sources: `first` (that flight alone), the task's flight again, a
    random candidate, and the choice of `selection.cost`. The modified task is flown with the largest models alone.
    """
    vehicle, robot = load_vehicle(config.vehicle), flying.plant(config, plant)
    around, further = read_reference(task), read_reference(modified)
    first = data_of(read_flight(flight), vehicle, config.learning)
    most = max(config.added_points)

    def rng(*purpose: str | int):
        return generator(config.base_seed, plant, seed, "priors", *purpose)

    def model_of(prior: str) -> GaussianProcess:
        affine = known(config.learning.model_copy(update={"prior": prior}), vehicle)
        return learn(first, config.prior_points, config.learning, rng("prior model"), affine=affine)

    def fly(reference: Reference, model: GaussianProcess, *purpose: str) -> Flight:
        return flying.fly(robot, vehicle, reference, model, config, rng(*purpose))

    def flights_of(model: GaussianProcess) -> dict[str, LearningData]:
        candidates = candidates_of(config, plant, seed, 1, around)
        simulated = simulate(around, candidates, vehicle, model, config, rng("score"))
        scored = score(simulated, config.selection.cost, config.selection, most, rng("score"))
        references = {
            "task": around,
            "random": candidates[generator(config.base_seed, plant, seed, "random", 1).integers(len(candidates))],
            "informative": candidates[scored.chosen],
        }
        return {
            source: data_of(fly(reference, model, "flight", source), vehicle, config.learning)
            for source, reference in references.items()
        }

    models = {prior: model_of(prior) for prior in (NONE, PHYSICS)}
    flown = {prior: flights_of(model) for prior, model in models.items()}
    rows = []

    def validate(model: GaussianProcess, references: dict[str, Reference], **key: object) -> None:
        for name, reference in references.items():
            errors = tracking_error(fly(reference, model, "validate", name), vehicle, config.learning.window)
            rows.append(row(errors, plant=plant, seed=seed, **key, points=model.n, reference=name))

    for prior, model in models.items():
        validate(model, {"task": around}, flown=prior, learned=prior, source="first")
    for before, prior in ((NONE, NONE), (NONE, PHYSICS), (PHYSICS, PHYSICS)):
        for source, data in flown[before].items():
            for points in config.added_points:
                # the subset and the search's starts are the same for both priors
                learned = learn(data, points, config.learning, rng("learn", source, points), models[prior])
                references = {"task": around} | ({"modified": further} if points == most else {})
                validate(learned, references, flown=before, learned=prior, source=source)
        print(f"flown with {before}, learned with {prior}: {rows[-2]['error']:.4f} rad/s^2", flush=True)
    write_table(pd.DataFrame(rows), table)
