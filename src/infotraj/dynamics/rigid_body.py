"""Newton and Euler: what a wrench does to a rigid body. The l(x) of eq. 19 and the h of eq. 3."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from infotraj import rotations
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


def accelerations(vehicle: Vehicle, attitude: ArrayLike, rate: ArrayLike, wrench: ArrayLike) -> tuple[Array, Array]:
    """Acceleration of the body's origin (..., 3) m/s^2, world, and angular acceleration (..., 3) rad/s^2, body.

    attitude (..., 4) body to world; rate (..., 3) rad/s, body; wrench (..., 6) N and N m about the body's origin,
    body frame. With the centre of mass at r and the inertia J about it:
    J dw = tau - r x f - w x J w and a = R (f/m - dw x r - w x (w x r)) + g.
    """
    rate = np.asarray(rate, dtype=float)
    wrench = np.asarray(wrench, dtype=float)
    inertia = vehicle.inertia_matrix()
    r = np.asarray(vehicle.center_of_mass)
    force, torque = wrench[..., :3], wrench[..., 3:]
    moment = torque - np.cross(np.broadcast_to(r, force.shape), force) - np.cross(rate, rate @ inertia)
    angular = moment @ np.linalg.inv(inertia)
    specific = force / vehicle.known_mass() - np.cross(angular, r) - np.cross(rate, np.cross(rate, r))
    return rotations.to_world(attitude, specific) - [0.0, 0.0, vehicle.gravity], angular


def scale(vehicle: Vehicle) -> Array:
    """What the wrench is divided by to become accelerations, (6,): mass (kg), then the diagonal of the inertia.

    The paper scales forces and moments by mass and inertia (footnote to eq. 19); the GP's input is in these units.
    """
    return np.concatenate([np.full(3, vehicle.known_mass()), np.diag(vehicle.inertia_matrix())])
