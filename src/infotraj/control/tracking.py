"""The tracking controller pi(x_task, x, h + mu) of eq. 2 and eq. 20 as a robot calls it, sample by sample."""

from __future__ import annotations

import numpy as np
import pandas as pd

from infotraj.control.demand import demand
from infotraj.control.gains import Gains
from infotraj.control.inversion import invert
from infotraj.control.response import Response, invert_response
from infotraj.dynamics import rigid_body
from infotraj.dynamics.allocation import Allocation
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference
from infotraj.vehicle import Vehicle

DEMAND = ("demand_ax", "demand_ay", "demand_az", "demand_alphax", "demand_alphay", "demand_alphaz")


def no_residual() -> GaussianProcess:
    """A residual that is zero everywhere: the first-principles model alone."""
    return GaussianProcess.empty(np.ones((3, 6)), np.ones(3), np.ones(3))


def states(reference: Reference) -> Array:
    """The reference as rows (n, 19): position, attitude, velocity, rate, acceleration, angular acceleration."""
    parts = ("position", "attitude", "velocity", "rate", "acceleration", "angular_acceleration")
    return np.ascontiguousarray(np.concatenate([getattr(reference, name) for name in parts], axis=1))


class TrackingController:
    """Tracks `reference` with the model h + mu; `process` None means the first-principles model alone.

    response: what a richer model than h says the vehicle does (h with named effects); it is inverted in the place of
    h. `command` returns the wrench (6,) N and N m, the rotor speeds (rad/s) and tilts (rad) for sample k.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        reference: Reference,
        process: GaussianProcess | None = None,
        gains: Gains | None = None,
        response: Response | None = None,
    ) -> None:
        self.period = reference.dt
        self._vehicle = vehicle
        self._inertia = vehicle.inertia_matrix()
        self._scale = rigid_body.scale(vehicle)
        self._allocation = Allocation(vehicle)
        self._reference = states(reference)
        self._t = reference.t
        self._process = (process or no_residual()).mean_arrays
        self._gains = gains or Gains()
        self._response = response
        self._state = np.empty(13)
        self._command = np.empty(6)
        self.reset()

    def reset(self) -> None:
        """Forgets the integrals and the record of the last flight."""
        self._integral = np.zeros(6)
        self._correction = np.zeros(3)
        self._offset = np.zeros(6)
        self._demand = np.full((len(self._t), 6), np.nan)

    def command(self, k: int, estimate) -> tuple[Array, Array, Array]:
        """Wrench, rotor speeds and tilts that act from sample k on, from the estimate at sample k."""
        state = self._state
        state[:3], state[3:7] = estimate.position, estimate.attitude
        state[7:10], state[10:] = estimate.velocity, estimate.rate
        wanted = self._demand[k]
        demand(
            self._gains,
            self._vehicle.gravity,
            self._inertia,
            self.period,
            state,
            self._reference[k],
            self._integral,
            wanted,
        )
        if self._response is None:
            invert(wanted, self._process, self._gains.max_correction, self._correction, self._command)
        else:
            self._invert_response(self._response, self._t[k], state, wanted)
        wrench = self._command * self._scale
        rotor_speed, tilt = self._allocation.actuators(wrench)
        return wrench, rotor_speed, tilt

    def _invert_response(self, response: Response, time: float, state: Array, wanted: Array) -> None:
        rate = state[10:]
        asked = wanted.copy()
        # The demand holds the gyroscopic torque that h needs; the response knows its own.
        asked[3:] -= np.cross(rate, self._inertia @ rate) / self._scale[3:]
        invert_response(
            wanted,
            asked,
            time,
            state,
            response,
            self._allocation,
            self._scale,
            self._process,
            self._gains.max_correction,
            self._offset,
            self._correction,
            self._command,
        )

    def record(self) -> pd.DataFrame:
        """The demand of each sample: t (s), then DEMAND in m/s^2 and rad/s^2, gyroscopic torque and weight included."""
        return pd.DataFrame({"t": self._t, **dict(zip(DEMAND, self._demand.T, strict=True))})
