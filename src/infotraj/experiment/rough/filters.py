"""What sensors and drivers do to a signal before it is logged: low-pass filters, which delay it."""

from __future__ import annotations

import numpy as np
from scipy.signal import butter, lfilter, lfilter_zi

from infotraj.experiment.rough.columns import replaced, step
from infotraj.flight import RATE, SPECIFIC_FORCE, Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


def filters(flight: Flight, vehicle: Vehicle, rng: np.random.Generator) -> Flight:
    """Gyro and accelerometer through a low-pass each: of first order with 3 to 12 ms, or Butterworth's second order at
    20 to 80 Hz (the defaults of autopilots lie between 30 and 80 Hz; the range is assumed)."""
    for names in (RATE, SPECIFIC_FORCE):
        if not flight.has(*names):
            continue
        if rng.random() < 0.5:
            flight = lagged(flight, names, rng.uniform(0.003, 0.012))
            continue
        b, a = butter(2, min(rng.uniform(20.0, 80.0), 0.4 / step(flight)), fs=1.0 / step(flight))
        flight = replaced(flight, names, _from_rest(b, a, flight.get(*names)))
    return flight


def lagged(flight: Flight, names: tuple[str, ...], time: float) -> Flight:
    """The columns through a first-order lag of `time` (s), exact for an input that is linear between rows."""
    h = step(flight)
    keep = np.exp(-h / time)
    now, before = 1.0 - time / h * (1.0 - keep), time / h * (1.0 - keep) - keep
    return replaced(flight, names, _from_rest(np.array([now, before]), np.array([1.0, -keep]), flight.get(*names)))


def _from_rest(b: Array, a: Array, x: Array) -> Array:
    start = lfilter_zi(b, a)[:, None] * x[0]
    return lfilter(b, a, x, axis=0, zi=start)[0]
