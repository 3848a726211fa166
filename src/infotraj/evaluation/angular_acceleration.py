"""Errors of the angular acceleration: in closed loop against the demand, and of a model's prediction.

The paper's tracking error (footnote in Sec. V-A) is actual minus commanded torque: what the robot did against what the
controller asked for after its model was inverted. Divided by the inertia it is an angular acceleration, rad/s^2. Both
sides pass the same window, so its noise floor is that of the rate's slope alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj.control.tracking import DEMAND
from infotraj.flight import Flight
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.learning_data import SETTLING, WINDOW, LearningData, angular_acceleration
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


@dataclass(frozen=True)
class AxisErrors:
    """Absolute errors (n, 3) rad/s^2 about x, y, z at times t (n,) s."""

    t: Array
    absolute: Array

    @property
    def by_axis(self) -> Array:
        """Mean absolute error of each axis, (3,)."""
        return self.absolute.mean(axis=0)

    @property
    def mean(self) -> float:
        """Mean over time and axes (Fig. 4)."""
        return float(self.absolute.mean())

    @property
    def spread(self) -> float:
        """Standard deviation over time of the mean over the axes (Fig. 4)."""
        return float(self.absolute.mean(axis=1).std())


def tracking_error(flight: Flight, vehicle: Vehicle, window: float = WINDOW) -> AxisErrors:
    """Achieved minus demanded angular acceleration of a flight that recorded its controller's demand."""
    slope, t, achieved = angular_acceleration(flight, vehicle, window)
    asked = slope.mean(flight.get(*DEMAND[3:]))
    keep = t >= flight.t[0] + SETTLING
    return AxisErrors(t[keep], np.abs(achieved - asked)[keep])


def prediction_error(process: GaussianProcess | None, data: LearningData) -> AxisErrors:
    """What a model leaves of the residual of a flight; None is the first-principles model."""
    predicted = 0.0 if process is None else process.mean(data.inputs)
    return AxisErrors(data.t, np.abs(data.outputs - predicted))
