"""A log as an autopilot writes it: an estimator's state, the filtered IMU of a shaking frame, held commands."""

from __future__ import annotations

import numpy as np

from infotraj import rotations
from infotraj.experiment.rough.columns import held, numbered, replaced, step
from infotraj.experiment.rough.filters import lagged
from infotraj.experiment.rough.gauss_markov import gauss_markov, smooth_gauss_markov
from infotraj.experiment.rough.vibration import shaken
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.vehicle import Vehicle

# Standard deviations of an estimator's slow errors. With the sensors' lag: as EKF logs show beside motion capture
# (position and velocity 1 to 10 cm(/s), attitude 0.2 to 1 deg); assumed within that.
_POSITION, _VELOCITY, _ATTITUDE = 0.03, 0.04, np.radians(0.4)  # m, m/s, rad
_LAG = 0.008  # s, gyro and accelerometer


def autopilot(flight: Flight, vehicle: Vehicle, rng: np.random.Generator) -> Flight:
    """Estimator errors that stay for seconds, rotor vibration behind a filter of 8 ms, commands at 100 or 50 Hz."""
    flight = estimated(flight, rng)
    for names in (RATE, SPECIFIC_FORCE):
        if flight.has(*names):
            flight = lagged(flight, names, _LAG)
    flight = shaken(flight, rng, lag=_LAG)
    period = 1.0 / rng.choice([100.0, 50.0])
    commands = numbered(flight, "cmd_rotor_")
    return held(flight, commands, period) if commands and period > step(flight) else flight


def estimated(flight: Flight, rng: np.random.Generator) -> Flight:
    """The pose and velocity of an estimator: each error a Gauss-Markov process over 1 to 5 s, its size the usual one
    times 0.5 to 1.5; of second order, or, in every other log, of first: a filter that jumps at each correction."""
    n, h = len(flight.t), step(flight)
    process = gauss_markov if rng.random() < 0.5 else smooth_gauss_markov

    def error(size: float) -> np.ndarray:
        return size * rng.uniform(0.5, 1.5) * process(n, h, rng.uniform(1.0, 5.0), rng)

    for names, size in ((POSITION, _POSITION), (VELOCITY, _VELOCITY)):
        if flight.has(*names):
            flight = replaced(flight, names, flight.get(*names) + error(size))
    if flight.has(*ATTITUDE):
        turned = rotations.multiply(flight.get(*ATTITUDE), rotations.exp(error(_ATTITUDE)))
        flight = replaced(flight, ATTITUDE, turned)
    return flight
