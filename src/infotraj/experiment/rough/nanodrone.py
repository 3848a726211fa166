"""A nanodrone's log: poses with noise of millimetres, velocities from them, a poor accelerometer."""

from __future__ import annotations

import numpy as np

from infotraj import rotations
from infotraj.experiment.rough.columns import replaced, step
from infotraj.experiment.rough.gauss_markov import gauss_markov
from infotraj.experiment.rough.vibration import shaken
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.vehicle import Vehicle


def nanodrone(flight: Flight, vehicle: Vehicle, rng: np.random.Generator) -> Flight:
    """Accelerometer errors of 0.25 to 0.5 m/s^2 that last 20 to 200 ms (as published flights of one leave), aliased
    vibration behind 5 ms, position noise of 1 to 3 mm, attitude of 0.3 deg, gyro bias of 0.02 rad/s."""
    n, h = len(flight.t), step(flight)
    flight = shaken(flight, rng, lag=0.005)
    for names, error in (
        (POSITION, rng.uniform(0.001, 0.003) * rng.standard_normal((n, 3))),
        (VELOCITY, 0.03 * gauss_markov(n, h, 0.05, rng)),
        (RATE, 0.02 * rng.standard_normal(3)),
        (SPECIFIC_FORCE, rng.uniform(0.25, 0.5) * gauss_markov(n, h, rng.uniform(0.02, 0.2), rng)),
    ):
        if flight.has(*names):
            flight = replaced(flight, names, flight.get(*names) + error)
    turned = rotations.exp(np.radians(0.3) * rng.standard_normal((n, 3)))
    return replaced(flight, ATTITUDE, rotations.multiply(flight.get(*ATTITUDE), turned))
