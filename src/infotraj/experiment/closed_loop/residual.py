"""What a model with effects leaves, learned by Gaussian processes, and the controller that inverts both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from infotraj.control.gains import Gains
from infotraj.control.tracking import TrackingController
from infotraj.dynamics import response, rigid_body
from infotraj.experiment.common.config import Learning
from infotraj.experiment.paper.learning import STEP, options
from infotraj.flight import SPECIFIC_FORCE, Flight
from infotraj.models import Model
from infotraj.models.instant import Instant
from infotraj.residual import hyperparameters
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.learning_data import SETTLING, LearningData, angular_acceleration
from infotraj.residual.subset import k_medoids
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference
from infotraj.vehicle import Vehicle


@dataclass(frozen=True)
class Residual:
    """Two processes over the commanded wrench (6, scaled): what is left of the specific force and of the angular
    acceleration, m/s^2 and rad/s^2, each (3,)."""

    force: GaussianProcess
    torque: GaussianProcess

    def mean(self, inputs: Array) -> Array:
        """Both means, (n, 6)."""
        return np.concatenate([self.force.mean(inputs), self.torque.mean(inputs)], axis=1)


class _WithForce:
    """A model's response with a process on its specific force; the one on the torque is inverted by `invert`."""

    def __init__(self, instant: Instant, force: GaussianProcess) -> None:
        self._instant, self._force = instant, force
        self._scale = rigid_body.scale(instant.vehicle)
        self._plain = Instant(Model(instant.vehicle))

    def accelerations(self, time: float, state: Array, rotor: Array, tilt: Array) -> Array:
        found = self._instant.accelerations(time, state, rotor, tilt)
        command = self._plain.wrench(rotor, tilt) / self._scale
        found[:3] += self._force.mean(command[None])[0]
        return found


def controller(
    model: Model, reference: Reference, gains: Gains, residual: Residual | None = None
) -> TrackingController:
    """The controller that inverts the model with its effects, and what was learned beside it."""
    instant = Instant(model)
    if residual is None:
        return TrackingController(model.vehicle, reference, None, gains, instant)
    return TrackingController(model.vehicle, reference, residual.torque, gains, _WithForce(instant, residual.force))


def residual_data(model: Model, flights: Sequence[Flight], learning: Learning) -> LearningData:
    """Inputs (n, 6) as in `learning_data`, outputs (n, 6): measured minus predicted specific force and angular
    acceleration, m/s^2 and rad/s^2, both sides under the window of the rate's slope. Thinned; flights joined."""
    parts = [_of_flight(model, flight, learning) for flight in flights]
    return LearningData(*(np.concatenate([getattr(p, name) for p in parts]) for name in ("t", "inputs", "outputs")))


def _of_flight(model: Model, flight: Flight, learning: Learning) -> LearningData:
    vehicle: Vehicle = model.vehicle
    slope, t, achieved = angular_acceleration(flight, vehicle, learning.window)
    wrench = response.wrench_of_rows(vehicle, flight.t, flight.numbered("cmd_rotor_"), flight.numbered("cmd_tilt_"))
    scale, inertia, rate = rigid_body.scale(vehicle), vehicle.inertia_matrix(), flight.get("wx", "wy", "wz")
    predicted = model.predict(flight)
    measured = flight.get(*SPECIFIC_FORCE)
    held = np.minimum(np.arange(len(flight.t)), len(flight.t) - 2)
    force = 0.5 * (measured[held] + measured[held + 1]) - predicted.specific_force_mean[held]
    # `achieved` holds the gyroscopic torque by the vehicle file; what is predicted gets the same one.
    torque = (predicted.angular_acceleration_mean[held] @ inertia + np.cross(rate, rate @ inertia)) / scale[3:]
    outputs = np.concatenate([slope.mean(force), achieved - slope.mean(torque)], axis=1)
    keep = np.flatnonzero(t >= flight.t[0] + SETTLING)[::STEP]
    return LearningData(t[keep], slope.mean(wrench / scale)[keep], outputs[keep])


def learn(data: LearningData, points: int, learning: Learning, rng: np.random.Generator) -> Residual:
    """Both processes from `points` k-medoids of the data."""
    chosen = k_medoids(data.inputs, points, rng)
    inputs, outputs = data.inputs[chosen], data.outputs[chosen]
    made = [
        hyperparameters.fit(inputs, part, rng, restarts=learning.restarts, **options(learning))
        for part in (outputs[:, :3], outputs[:, 3:])
    ]
    return Residual(*made)
