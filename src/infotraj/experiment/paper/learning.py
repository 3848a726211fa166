"""Learning a residual model from flights, with the configuration's settings."""

from __future__ import annotations

from typing import Any

import numpy as np

from infotraj.experiment.common.config import Learning
from infotraj.flight import Flight
from infotraj.models.affine_effects import affine_prior
from infotraj.residual import hyperparameters
from infotraj.residual.affine_prior import AffinePrior
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.learning_data import LearningData, learning_data
from infotraj.residual.subset import k_medoids
from infotraj.vehicle import Vehicle

STEP = 4  # rows; the window of 0.15 s leaves little new between rows of a 200 Hz log


def data_of(flight: Flight, vehicle: Vehicle, learning: Learning) -> LearningData:
    """The flight's inputs and outputs, thinned to what a subset may be chosen from."""
    data = learning_data(flight, vehicle, response_of_model=learning.response_of_model, window=learning.window)
    return LearningData(data.t[::STEP], data.inputs[::STEP], data.outputs[::STEP])


def learn(
    data: LearningData,
    points: int,
    learning: Learning,
    rng: np.random.Generator,
    prior: GaussianProcess | None = None,
    *,
    affine: AffinePrior | None = None,
) -> GaussianProcess:
    """`points` k-medoids of the data, added to the prior model's points, with all hyperparameters optimised anew.

    affine: what is known before any flight (`known`); None takes that of the prior model.
    """
    chosen = k_medoids(data.inputs, points, rng)
    inputs, outputs = data.inputs[chosen], data.outputs[chosen]
    if prior is not None:
        inputs, outputs = np.concatenate([prior.X, inputs]), np.concatenate([prior.Y, outputs])
        affine = affine or prior.affine
    told = options(learning)
    if affine is not None and learning.lengthscale_prior:
        told["prior"] = hyperparameters.REMAINDER_PRIOR
    return hyperparameters.fit(inputs, outputs, rng, restarts=learning.restarts, affine=affine, **told)


def known(learning: Learning, vehicle: Vehicle) -> AffinePrior | None:
    """What `learning.prior` knows of the residual before any flight of this vehicle."""
    return affine_prior(vehicle) if learning.prior == "physics" else None


def options(learning: Learning) -> dict[str, Any]:
    """What `hyperparameters.fit` and `hyperparameters.sample_hyperparameters` need to be told alike."""
    return {
        "ard": learning.ard,
        "prior": hyperparameters.DEFAULT_PRIOR if learning.lengthscale_prior else None,
        "input_scale": learning.input_scale,
    }
