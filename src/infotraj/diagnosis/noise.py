"""The noise of the residual, from what the richest linear model leaves: what is not modelled yet is not noise."""

from __future__ import annotations

import numpy as np

from infotraj.diagnosis.observation import Observation
from infotraj.diagnosis.sums import block_sums
from infotraj.diagnosis.whitened import noise_model, whiten
from infotraj.diagnosis.whitening import Whitener
from infotraj.rotations import Array

_START = 0.3  # gain of the first filter of differences
PRIOR = 3.0  # usual sizes: deviation of every number about its absent value, felt where flights do not determine it


def estimated(observation: Observation, joint: list[list[Array]], rounds: int = 2) -> Observation:
    """The observation with the noise that is left when every column of `joint` is fitted, reweighted `rounds` times.

    joint: residual and columns, one (m, 3, 1 + p) a channel of a flight, not whitened.
    """
    for _ in range(rounds):
        theta = richest(observation, joint)
        left = [[x[:, :, 0] - x[:, :, 1:] @ theta for x in flight] for flight in joint]
        observation = observation.with_noise(noise_model(observation.samples, left))
    return observation


def started(observation: Observation, joint: list[list[Array]]) -> Observation:
    """The observation with the noise that is left by the richest fit under white noise, reweighted.

    What starts from the residual as it is may never leave it: a missing effect that changes slowly passes for noise
    that wanders, and is then not fitted.
    """
    parts: dict[str, list[tuple[Array, bool]]] = {}
    for s, flight in zip(observation.samples, joint, strict=True):
        for channel, x in zip(s.channels, flight, strict=True):
            parts.setdefault(channel.key, []).append((x[:, :, 0], channel.difference))
    noise = {}
    for key, found in parts.items():
        spread = np.maximum(np.concatenate([x for x, _ in found]).std(axis=0), 1e-12)
        gain = _START if found[0][1] else None
        noise[key] = tuple(Whitener(gain, np.zeros(0), float(d)) for d in spread)
    return estimated(observation.with_noise(noise), joint, rounds=3)


def richest(observation: Observation, joint: list[list[Array]]) -> Array:
    """Least-squares numbers (p,) of all columns at once, with a weak prior on their size."""
    return _richest(observation, joint)[0]


def left_by_richest(observation: Observation, joint: list[list[Array]]) -> float:
    """The squared error that these numbers leave, in noise variances."""
    return _richest(observation, joint)[1]


def _richest(observation: Observation, joint: list[list[Array]]) -> tuple[Array, float]:
    white = [whiten(s, observation.noise, flight) for s, flight in zip(observation.samples, joint, strict=True)]
    gram, right, square = block_sums(observation.samples, observation.noise, observation.blocks, white).total()
    right = right.sum(axis=0)
    total = gram.sum(axis=0) + np.eye(gram.shape[-1]) / PRIOR**2
    theta = np.linalg.solve(total, right)
    return theta, float(square.sum() - right @ theta)
