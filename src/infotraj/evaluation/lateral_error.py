"""Lateral error of a model: what it leaves of the specific force in body x and y on flights that it was not fitted to.

A multirotor whose rotors push along body z predicts no lateral force: what is left there is drag first of all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from infotraj.comparing.equation_error import ForceFrom, equation_error
from infotraj.errors import InputError, problem
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.rotations import Array


@dataclass(frozen=True)
class LateralError:
    """rms (k, 2) m/s^2: of the k flights in body x and y, each flight's mean removed from each axis."""

    rms: Array

    @property
    def rmse(self) -> float:
        """Both axes together, m/s^2: every flight and axis counts the same, however long the flight is."""
        return float(np.sqrt(np.mean(np.square(self.rms))))


def lateral_error(model: Model, flights: Sequence[Flight], force_from: ForceFrom = "accelerometer") -> LateralError:
    """RMSE of the lateral specific force of each flight (m/s^2, body x and y), each flight's mean removed.

    The error is that of `comparing.equation_error`, filter included, over the mass. The mean is removed because the
    mounting of the IMU, or the motion capture's idea of level, shifts it from flight to flight by more than drag does.
    InputError where a flight has nothing lateral to score.
    """
    rms = []
    for flight in flights:
        error = equation_error(model, flight, force_from=force_from)
        lateral = error.residual[:, :2] / (1.0 if model.vehicle.mass is None else model.vehicle.mass)
        if not np.isfinite(lateral).any(axis=0).all():
            what = f"{flight.meta.get('source', 'flight')}: no lateral force by {force_from}"
            raise InputError(problem(what, "measured specific force, or velocity with attitude", "Leave it out."))
        rms.append(np.nanstd(lateral, axis=0))
    return LateralError(np.array(rms).reshape(-1, 2))
