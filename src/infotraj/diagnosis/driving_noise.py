"""Noise in the recorded motion that drives a prediction: errors in variables.

A load is swung along the recorded motion from a flight's first row to its last: noise of the accelerometer moves it
further and further from where it hangs. What that does to a prediction is no noise of the samples (Fuller,
"Measurement error models", 1987). It is drawn here: white noise as large as that of the samples is put on recorded
position, velocity and specific force (attitude is left as it is; a sensor that filters its noise seems more exact than
it is). Samples that it makes uncertain weigh less, and what is left of it widens the standard errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from infotraj.diagnosis.candidates import read
from infotraj.diagnosis.fitting import Fit
from infotraj.diagnosis.noise import PRIOR
from infotraj.diagnosis.observation import Member, Observation
from infotraj.diagnosis.residual import FlightSamples
from infotraj.diagnosis.scanning import shape_of
from infotraj.diagnosis.sensitivities import sensitivities
from infotraj.diagnosis.whitened import moving_mean, stacked, whiten
from infotraj.flight import POSITION, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.models import Model
from infotraj.rotations import Array

_DRAWS = 8
_DIFFERENCES = 3  # of a sample from its neighbours, which leave its noise and little of the motion
_OF_THEIR_NOISE = 20.0  # variance of these differences for noise of unit variance
_DRIVEN = ("force", "velocity", "rate")  # channels whose measured side the draws leave as it is
_LASTS = 0.25  # s over which an error of the prediction is taken to last
_EXACT = 0.003  # of a shape itself
_SMOOTH = 1.0  # s over which its size is averaged


def swings(observation: Observation, members: Sequence[Member]) -> bool:
    """Whether a member has a shape: its prediction is integrated along the recorded motion."""
    return any(shape_of(m.candidate, observation) is not None for m in members)


def weighted(observation: Observation) -> bool:
    """Whether samples weigh differently."""
    return any(s.weights is not None for s in observation.samples)


def unweighted(observation: Observation) -> Observation:
    """The observation whose samples weigh all alike."""
    if not weighted(observation):
        return observation
    return replace(observation, samples=tuple(replace(s, weights=None) for s in observation.samples))


def weighed(observation: Observation, members: Sequence[Member]) -> Observation:
    """The observation with samples weighted by how certain the motion leaves the prediction of these members.

    An error that lasts for n samples counts n times as much as one of a sample alone.
    """
    plain = unweighted(observation)
    if not swings(observation, members):
        return plain
    model = observation.model(members)
    out = []
    for s, change in zip(plain.samples, _draws(plain, model), strict=True):
        weights = []
        for channel, x in zip(s.channels, whiten(s, plain.noise, change), strict=True):
            lasting, smooth = (max(1, round(time / channel.step)) for time in (_LASTS, _SMOOTH))
            mean = moving_mean(x.reshape(len(x), -1), channel.run, lasting).reshape(x.shape)
            size = moving_mean(np.mean(lasting * mean**2, axis=2), channel.run, smooth)
            weights.append(1.0 / np.sqrt(1.0 + np.maximum(size, 0.0)))
        out.append(replace(s, weights=tuple(weights)))
    return replace(plain, samples=tuple(out))


def driving_variance(observation: Observation, made: Fit) -> Array:
    """Variance (p,) of a fit's numbers in usual sizes by noise of the motion: 0 where no member swings along it.

    A shape is never taken for more exact than 0.3 % of itself: the longer a flight, the less the linearisation shows.
    """
    if not swings(observation, made.members):
        return np.zeros(len(made.at_bound))
    samples, noise = observation.samples, observation.noise
    own = stacked(samples, noise, sensitivities(observation, made.members, []).joint)[:, 1:]
    change = stacked(samples, noise, _draws(observation, observation.model(made.members)))
    moved = np.linalg.solve(own.T @ own + np.eye(own.shape[1]) / PRIOR**2, own.T @ change)
    return np.where(made.at_bound, 0.0, np.mean(moved**2, axis=1) + _inexact(observation, made.members))


def _inexact(observation: Observation, members: Sequence[Member]) -> Array:
    out = []
    for m in members:
        at = m.places(observation.vehicle)
        shape, numbers = shape_of(m.candidate, observation), read(m.effect, at)
        out += [(_EXACT * numbers[i] / p.scale) ** 2 if i == shape else 0.0 for i, p in enumerate(at)]
    return np.array(out)


def _draws(observation: Observation, model: Model) -> list[list[Array]]:
    """Changes of the residual, one (m, 3, draws) a channel of a flight, when the prediction follows noisier motions."""
    rng = np.random.default_rng(0)  # the same draws whatever the model: two fits are weighed alike
    return [_changes(s, model, rng) for s in observation.samples]


def _changes(samples: FlightSamples, model: Model, rng: np.random.Generator) -> list[Array]:
    before = samples.residual(model)
    drawn = [samples.of_prediction(model.predict(_noisier(samples.flight, rng))) for _ in range(_DRAWS)]
    return [
        np.stack([after[i] - b if c.name in _DRIVEN else np.zeros_like(b) for after in drawn], axis=2)
        for i, (c, b) in enumerate(zip(samples.channels, before, strict=True))
    ]


def _noisier(flight: Flight, rng: np.random.Generator) -> Flight:
    """The flight with as much noise again on its motion as its samples have."""
    table = flight.table.copy()
    for column in (*POSITION, *VELOCITY, *SPECIFIC_FORCE):
        if not flight.has(column):
            continue
        values = table[column].to_numpy(dtype=float, copy=True)
        rows = np.flatnonzero(np.isfinite(values))
        size = np.sqrt(np.mean(np.diff(values[rows], n=_DIFFERENCES) ** 2) / _OF_THEIR_NOISE) if len(rows) > 50 else 0.0
        values[rows] += rng.normal(0.0, size, len(rows))
        table[column] = values
    return Flight(table, flight.meta)
