"""What the catalogue's effects would add to the torque, as functions of the commanded wrench alone: a prior on them.

Column k is the change of the angular acceleration by a usual size of one number of one effect, of a vehicle at rest and
level whose actuators have reached their commands. The effects' own code is evaluated (`models.instant`), and the column
linearised in the wrench at hover. Over 30 degrees of tilt the omav's columns are affine to 0.001 rad/s^2 (rms) but for
two: rotors' interference leaves 0.11 of 1.1, the thrust's exponent 0.05 of 0.14. An effect that does nothing at rest
(drag, lags) has no column: it is no function of the command.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from infotraj.dynamics import rigid_body
from infotraj.dynamics.allocation import Allocation
from infotraj.effects.base import Effect
from infotraj.effects.registry import catalogue
from infotraj.errors import InputError
from infotraj.models.instant import Instant
from infotraj.models.model import Model
from infotraj.residual.affine_prior import AffinePrior
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_AT_REST = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])  # 1 m above the ground, level
_STEP = 0.5  # m/s^2 and rad/s^2, of the central differences


def affine_effects(vehicle: Vehicle) -> tuple[list[str], Array]:
    """Names (k,) and weights (k, 3, 7): the change of the angular acceleration (rad/s^2) about x, y, z by a usual size.

    A column is weights . [1, u - hover], u being the wrench by mass and inertia (m/s^2, rad/s^2).
    """
    allocation, scale = Allocation(vehicle), rigid_body.scale(vehicle)
    steps = _STEP * np.concatenate([np.eye(6), -np.eye(6)])
    wrenches = hover(vehicle) + np.concatenate([np.zeros((1, 6)), steps])
    commands = [allocation.actuators(u * scale) for u in wrenches]

    def angular(effects: list[Effect]) -> Array:
        instant = Instant(Model(vehicle, effects))
        return np.array([instant.accelerations(0.0, _AT_REST, *command)[3:] for command in commands])

    before = angular([])
    names, weights = [], []
    for name, effect in _of_usual_size(vehicle):
        try:
            change = angular([effect]) - before
        except InputError:
            continue  # no single state says what it does (a hanging load)
        if np.isfinite(change).all() and change.any():
            slopes = (change[1:7] - change[7:]) / (2.0 * _STEP)
            names.append(name)
            weights.append(np.column_stack([change[0], slopes.T]))
    return names, np.stack(weights)


def affine_prior(vehicle: Vehicle) -> AffinePrior:
    """The residual torque's prior: a sum of the columns, each with a weight of mean 0 and variance 1, rad/s^2."""
    _, weights = affine_effects(vehicle)
    return AffinePrior(hover(vehicle), np.einsum("koi,koj->oij", weights, weights))


def hover(vehicle: Vehicle) -> Array:
    """The wrench by mass and inertia (6,) that holds the vehicle level."""
    return np.array([0.0, 0.0, vehicle.gravity, 0.0, 0.0, 0.0])


def _of_usual_size(vehicle: Vehicle) -> Iterator[tuple[str, Effect]]:
    """Every effect on what moves, one number at a time: a usual size away from what changes nothing."""
    for name, cls in catalogue().items():
        if cls.place == "measurement" or (cls.place == "actuators" and not cls.shifts):
            continue
        # What has several forms (battery_sag, gyroscopic) acts through time or rates, which a state at rest has not.
        form = [p for p in cls.parameters if not p.index and not p.optional]
        index = [p.name for p in cls.parameters if p.index]
        for fixed in [{index[0]: i} for i in range(len(vehicle.rotors))] if index else [{}]:
            for p in form:
                for i in range(p.count(vehicle)):
                    value = np.array(cls.absent(vehicle, p), dtype=float)
                    value[i] += np.broadcast_to(cls.scale(vehicle, p), value.shape)[i]
                    label = " ".join([name, *map(str, fixed.values()), f"{p.name} {i}"])
                    yield label, cls(**fixed, **{p.name: float(value[0]) if p.size == 1 else value.tolist()})
