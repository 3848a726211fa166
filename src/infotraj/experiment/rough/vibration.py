"""What rotors out of balance do to the sensors of the frame that they shake."""

from __future__ import annotations

import numpy as np

from infotraj.experiment.rough.columns import replaced
from infotraj.flight import RATE, SPECIFIC_FORCE, Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_FORCE, _RATE = (
    (1.0, 5.0),
    (0.05, 0.3),
)  # m/s^2 and rad/s rms at hover, before any filter; assumed, as seen on small frames
_HARMONICS = (1, 2, 4)  # imbalance, two blades, and the second of these


def vibration(flight: Flight, vehicle: Vehicle, rng: np.random.Generator) -> Flight:
    """Vibration alone: an IMU without a filter, sampled at the log's rate, so that most of it is aliased."""
    return shaken(flight, rng, lag=0.0)


def shaken(flight: Flight, rng: np.random.Generator, lag: float) -> Flight:
    """The IMU shaken at every rotor's speed and its harmonics, seen through a first-order lag (s) and then sampled.

    Sizes grow with the square of the rotor's speed, as an imbalance's force does. The phases are integrals of the
    rotor speeds, so that what is beyond half the log's rate comes out at other frequencies.
    """
    speeds = flight.numbered("rotor_") if flight.has("rotor_0") else flight.numbered("cmd_rotor_")
    h = np.diff(flight.t, prepend=flight.t[0])[:, None]
    phase = np.cumsum(h * speeds, axis=0)
    size = (speeds / np.median(speeds, axis=0)) ** 2
    for names, (low, high) in ((SPECIFIC_FORCE, _FORCE), (RATE, _RATE)):
        if flight.has(*names):
            made = _harmonics(phase, speeds, size, lag, rng)
            made *= rng.uniform(low, high) / np.sqrt(np.mean(made**2))
            gain = 1.0 / np.sqrt(1.0 + (lag * np.median(speeds)) ** 2)
            flight = replaced(flight, names, flight.get(*names) + gain * made)
    return flight


def _harmonics(phase: Array, speeds: Array, size: Array, lag: float, rng: np.random.Generator) -> Array:
    """(n, 3): each harmonic of each rotor with its own direction and phase; weaker and later behind the lag, relative
    to the first harmonic at the median speed."""
    first = np.sqrt(1.0 + (lag * np.median(speeds)) ** 2)
    out = np.zeros((len(phase), 3))
    for rotor in range(phase.shape[1]):
        for order in _HARMONICS:
            w = order * speeds[:, rotor]
            gain = first / np.sqrt(1.0 + (lag * w) ** 2) * size[:, rotor] * rng.uniform(0.3, 1.0) / order
            direction, start = rng.standard_normal(3), rng.uniform(-np.pi, np.pi, 3)
            angle = order * phase[:, rotor] - np.arctan(lag * w)
            out += (gain[:, None] * direction) * np.sin(angle[:, None] + start)
    return out
