"""The noise of the residual, from what the richest linear model leaves: what is not modelled yet is not noise."""

from __future__ import annotations

import numpy as np

from infotraj.diagnosis.observation import Observation
from infotraj.diagnosis.sums import block_sums
from infotraj.diagnosis.whitened import noise_model, whiten
from infotraj.rotations import Array

PRIOR = 3.0  # usual sizes: standard deviation of every number in the richest fit


def estimated(observation: Observation, joint: list[list[Array]], rounds: int = 2) -> Observation:
    """The observation with the noise that is left when every column of `joint` is fitted, reweighted `rounds` times.

    joint: residual and columns, one (m, 3, 1 + p) a channel of a flight, not whitened.
    """
    for _ in range(rounds):
        theta = richest(observation, joint)
        left = [[x[:, :, 0] - x[:, :, 1:] @ theta for x in flight] for flight in joint]
        observation = observation.with_noise(noise_model(observation.samples, left))
    return observation


def richest(observation: Observation, joint: list[list[Array]]) -> Array:
    """Least-squares numbers (p,) of all columns at once, with a weak prior on their size."""
    white = [whiten(s, observation.noise, flight) for s, flight in zip(observation.samples, joint, strict=True)]
    gram, right, _ = block_sums(observation.samples, observation.noise, observation.blocks, white).total()
    total = gram.sum(axis=0)
    return np.linalg.solve(total + np.eye(len(total)) / PRIOR**2, right.sum(axis=0))
