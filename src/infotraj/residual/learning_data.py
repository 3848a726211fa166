"""From a flight to what the Gaussian process learns: commanded wrench in, achieved minus commanded torque out.

The angular acceleration is the least-squares slope of the measured rate over a window (Lanczos' differentiator). The
slope is a weighted mean of the true angular acceleration, with weights that follow from the window alone, so exactly
the same weights are laid over the commanded wrench: no filter acts on one side only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import fftconvolve

from infotraj.dynamics import response, rigid_body
from infotraj.errors import InputError, problem
from infotraj.flight import COMMANDED_WRENCH, RATE, Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

WINDOW = 0.15  # s
SETTLING = 0.5  # s after the first command that are not used (flight table's rule)


@dataclass(frozen=True)
class LearningData:
    """n samples of a flight: t (n,) s; inputs (n, 6), wrench by mass and inertia, m/s^2 and rad/s^2, body;
    outputs (n, 3), achieved minus commanded torque by inertia, rad/s^2."""

    t: Array
    inputs: Array
    outputs: Array


@dataclass(frozen=True)
class Slope:
    """Least-squares slope over 2 `half` + 1 samples `dt` (s) apart, and the mean over time that it amounts to."""

    half: int
    dt: float

    @classmethod
    def over(cls, window: float, dt: float) -> Slope:
        """The slope over about `window` seconds."""
        return cls(max(1, round(window / dt / 2)), dt)

    def derivative(self, x: Array) -> Array:
        """Slope of x (n, c) at samples half .. n - half - 1, (n - 2 half, c)."""
        k = np.arange(-self.half, self.half + 1)
        return _correlate(x, k / (np.sum(k * k) * self.dt))

    def mean(self, x: Array) -> Array:
        """The slope's own mean of x (n, c), row k being the value from t[k] to t[k+1]: (n - 2 half, c)."""
        k = np.arange(-self.half, self.half + 1)
        weights = np.cumsum(k[::-1])[::-1][1:] / np.sum(k * k)
        return _correlate(x, np.append(weights, 0.0))


def angular_acceleration(flight: Flight, vehicle: Vehicle, window: float = WINDOW) -> tuple[Slope, Array, Array]:
    """The filter, its times t (n,) s, and J^-1 (J dw/dt + w x J w) in rad/s^2, (n, 3), from the measured rate.

    The gyroscopic torque is added so that the result compares with a torque. InputError where rates are missing or the
    rows are not evenly spaced.
    """
    t, rate = flight.t, flight.get(*RATE)
    dt = np.median(np.diff(t))
    uneven = np.flatnonzero(np.abs(np.diff(t) - dt) > 0.1 * dt)
    if uneven.size or not np.isfinite(rate).all():
        what = f"a gap at {t[uneven[0]]:.3f} s" if uneven.size else "rates that are not numbers"
        raise InputError(
            problem(f"{flight.meta.get('source', 'flight')}: {what}", "evenly spaced rates", "Cut or resample it.")
        )
    slope = Slope.over(window, float(dt))
    if len(t) <= 2 * slope.half:
        raise InputError(problem(f"a flight of {len(t)} rows", f"more than {2 * slope.half}", "Fly longer."))
    inertia = vehicle.inertia_matrix()
    gyroscopic = np.cross(rate, rate @ inertia)
    inner = slice(slope.half, -slope.half)
    scale = rigid_body.scale(vehicle)[3:]
    return slope, t[inner], (slope.derivative(rate) @ inertia + slope.mean(gyroscopic)) / scale


def learning_data(flight: Flight, vehicle: Vehicle, *, response_of_model: bool, window: float = WINDOW) -> LearningData:
    """Inputs and outputs of the residual along a flight.

    With `response_of_model` the commanded wrench is what the commanded rotor speeds and tilts give after the declared
    lags; without, the commanded wrench as it is (the paper's reading).
    """
    slope, t, achieved = angular_acceleration(flight, vehicle, window)
    if response_of_model:
        wrench = response.wrench_of_rows(vehicle, flight.t, flight.numbered("cmd_rotor_"), flight.numbered("cmd_tilt_"))
    else:
        wrench = flight.get(*COMMANDED_WRENCH)
    inputs = slope.mean(wrench / rigid_body.scale(vehicle))
    outputs = achieved - inputs[:, 3:]
    keep = t >= flight.t[0] + SETTLING
    return LearningData(t[keep], inputs[keep], outputs[keep])


def _correlate(x: Array, weights: Array) -> Array:
    return fftconvolve(x, weights[::-1, None], mode="valid", axes=0)
