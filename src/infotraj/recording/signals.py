"""What a recording shows of a flight, as arrays: pose, wrench, errors and the learned residual."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from infotraj import rotations
from infotraj.control.tracking import DEMAND
from infotraj.dynamics import rigid_body
from infotraj.errors import InputError, problem
from infotraj.flight import (
    ATTITUDE,
    COMMANDED_WRENCH,
    POSITION,
    RATE,
    REFERENCE_ATTITUDE,
    REFERENCE_POSITION,
    SPECIFIC_FORCE,
    Flight,
)
from infotraj.residual.learning_data import WINDOW, LearningData, Slope
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


class Residual(Protocol):
    """A learned residual: angular acceleration (k, 3) rad/s^2 at scaled wrenches (k, 6), and its variance."""

    def mean(self, U: Array) -> Array: ...

    def variance(self, U: Array) -> Array: ...


@dataclass(frozen=True)
class Samples:
    """A channel where it has samples: t (n,) s and values (n, width)."""

    t: Array
    values: Array


@dataclass(frozen=True)
class Band:
    """Predicted residual torque along the flight: t (n,) s; mean and two standard deviations (n, 3) N m."""

    t: Array
    mean: Array
    two_sigma: Array


def estimated(flight: Flight, columns: tuple[str, ...]) -> Samples | None:
    """The estimator's channel (est_px, ...) where the flight has it, else the sensor's; None where neither is."""
    for names in (tuple(f"est_{c}" for c in columns), columns):
        found = channel(flight, names)
        if found is not None:
            return found
    return None


def channel(flight: Flight, columns: tuple[str, ...]) -> Samples | None:
    """The rows in which every one of the columns has a number; None where there is no such row."""
    if not flight.has(*columns):
        return None
    values = flight.get(*columns)
    there = np.isfinite(values).all(axis=1)
    return Samples(flight.t[there], values[there]) if there.any() else None


def actuators(flight: Flight, kind: str, count: int) -> Samples | None:
    """Commands cmd_KIND_0.. of all `count` rotors or tilts, else the measured ones; None where neither is complete."""
    if count == 0:
        return None
    for prefix in (f"cmd_{kind}_", f"{kind}_"):
        found = channel(flight, tuple(f"{prefix}{i}" for i in range(count)))
        if found is not None:
            return found
    return None


@dataclass(frozen=True)
class Achieved:
    """Achieved torque (N m) about the body's origin, and the mean over time that its filter amounts to."""

    torque: Samples
    slope: Slope

    def less(self, asked: Samples) -> Samples:
        """The torque minus what was asked for (n, 3), N m, both through the same mean."""
        t = self.torque.t
        half, dt = self.slope.half, self.slope.dt
        grid = t[0] + dt * np.arange(-half, len(t) + half)
        return Samples(t, self.torque.values - self.slope.mean(held(asked, grid)))


def achieved_torque(flight: Flight, vehicle: Vehicle) -> Achieved | None:
    """Achieved torque: J dw + w x J w + r x f.

    dw is the slope of the measured, else estimated, rate over the window that the residual is learned with. None where
    the flight has no rate or the vehicle no inertia.
    """
    rate = channel(flight, RATE) or estimated(flight, RATE)
    if rate is None or vehicle.inertia is None or len(rate.t) < 2:
        return None
    step = float(np.median(np.diff(rate.t)))
    slope = Slope.over(WINDOW, step)
    t = rate.t[0] + step * np.arange(int((rate.t[-1] - rate.t[0]) / step + 1e-6) + 1)
    if len(t) <= 2 * slope.half:
        return None
    even, inertia = at(rate, t), vehicle.inertia_matrix()
    torque = slope.derivative(even) @ inertia + slope.mean(np.cross(even, even @ inertia))
    force = achieved_force(flight, vehicle)
    if force is not None and any(vehicle.center_of_mass):
        torque = torque + np.cross(vehicle.center_of_mass, slope.mean(at(force, t)))
    return Achieved(Samples(t[slope.half : -slope.half], torque), slope)


def achieved_force(flight: Flight, vehicle: Vehicle) -> Samples | None:
    """Achieved force (N), body frame: mass times specific force; None where either is unknown."""
    found = channel(flight, SPECIFIC_FORCE)
    return None if found is None or vehicle.mass is None else Samples(found.t, vehicle.mass * found.values)


def position_error(flight: Flight) -> Samples | None:
    """Position minus its reference (m), world frame, (n, 3)."""
    position, reference = estimated(flight, POSITION), channel(flight, REFERENCE_POSITION)
    if position is None or reference is None:
        return None
    return Samples(position.t, position.values - at(reference, position.t))


def attitude_error(flight: Flight) -> Samples | None:
    """Rotation vector from the reference to the attitude (deg), in the reference's frame, (n, 3)."""
    attitude, reference = estimated(flight, ATTITUDE), channel(flight, REFERENCE_ATTITUDE)
    if attitude is None or reference is None:
        return None
    wanted = rotations.normalize(at(Samples(reference.t, rotations.continuous(reference.values)), attitude.t))
    apart = rotations.multiply(rotations.conjugate(wanted), rotations.normalize(attitude.values))
    return Samples(attitude.t, np.degrees(rotations.log(apart)))


def commanded(flight: Flight, first: int) -> Samples | None:
    """Three columns of the commanded wrench from `first` on: 0 force (N), 3 torque (N m)."""
    found = channel(flight, COMMANDED_WRENCH)
    return None if found is None else Samples(found.t, found.values[:, first : first + 3])


def angular_acceleration_error(flight: Flight, vehicle: Vehicle, achieved: Achieved | None) -> Samples | None:
    """Achieved minus demanded torque over the inertia's diagonal (rad/s^2), (n, 3); without a demand, minus commanded.

    The paper's tracking error (footnote in Sec. V-A). The demand is what the controller asked for before it inverted
    its model; a first-principles model commands what it demands.
    """
    if achieved is None or vehicle.inertia is None:
        return None
    inertia = np.diag(vehicle.inertia_matrix())
    demand = channel(flight, DEMAND[3:])
    asked = commanded(flight, 3) if demand is None else Samples(demand.t, demand.values * inertia)
    if asked is None:
        return None
    difference = achieved.less(asked)
    return Samples(difference.t, difference.values / inertia)


def seen_residual(
    flight: Flight, vehicle: Vehicle, achieved: Achieved | None, data: LearningData | None
) -> Samples | None:
    """What the model does not explain (N m), (n, 3): the outputs of `data`, else achieved minus commanded torque."""
    if data is not None:
        return Samples(data.t, data.outputs * rigid_body.scale(vehicle)[3:])
    asked = commanded(flight, 3)
    return None if achieved is None or asked is None else achieved.less(asked)


def predicted_residual(
    flight: Flight, vehicle: Vehicle, gp: Residual, data: LearningData | None, rate: float
) -> Band | None:
    """The learned residual at the inputs of `data`, else at the commanded wrench, at most `rate` times a second."""
    wrench = channel(flight, COMMANDED_WRENCH)
    if data is None and wrench is None:
        return None
    if vehicle.mass is None or vehicle.inertia is None:
        raise InputError(
            problem(f"vehicle {vehicle.name}: mass or inertia left out", "both, to scale the residual", "Add them.")
        )
    scale = rigid_body.scale(vehicle)
    if data is not None:
        t, inputs = data.t, data.inputs
    elif wrench is not None:
        t, inputs = wrench.t, wrench.values / scale
    keep = thinned(t, rate)
    mean, variance = gp.mean(inputs[keep]), gp.variance(inputs[keep])
    return Band(t[keep], mean * scale[3:], 2.0 * np.sqrt(variance) * scale[3:])


def at(samples: Samples, t: Array) -> Array:
    """The channel at times t, linear between its samples, (n, width)."""
    return np.stack([np.interp(t, samples.t, column) for column in samples.values.T], axis=1)


def held(samples: Samples, t: Array) -> Array:
    """The channel at times t, each sample held until the next: a command acts until the next one."""
    return samples.values[np.clip(np.searchsorted(samples.t, t, side="right") - 1, 0, None)]


def thinned(t: Array, rate: float) -> NDArray[np.intp]:
    """Indices of t (s) that leave at most one sample in each 1/rate seconds, (m,)."""
    slot = np.floor((t - t[0]) * rate + 1e-6)
    return np.unique(slot, return_index=True)[1]
