"""What a recording shows of a flight, as arrays: pose, wrench, errors and the learned residual."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pandas as pd
from scipy.signal import savgol_filter

from infotraj import rotations
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
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

ACHIEVED_TORQUE = ("tx", "ty", "tz")
DERIVATIVE_WINDOW = 0.1  # s, of the local parabola that differentiates the rate where no achieved torque is handed in


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


def achieved_torque(flight: Flight, vehicle: Vehicle, given: pd.DataFrame | None) -> Samples | None:
    """Achieved torque (N m) about the body's origin: the columns t, tx, ty, tz of `given`, else J dw + w x J w + r x f.

    dw is the derivative of a parabola over DERIVATIVE_WINDOW through the estimated, else measured, rate. None where
    the flight has no rate or the vehicle no inertia.
    """
    if given is not None:
        missing = [c for c in ("t", *ACHIEVED_TORQUE) if c not in given]
        if missing:
            raise InputError(
                problem(f"achieved torque: no columns {', '.join(missing)}", "t, tx, ty, tz (s, N m)", "Add them.")
            )
        values = given[list(ACHIEVED_TORQUE)].to_numpy(dtype=float)
        there = np.isfinite(values).all(axis=1)
        return Samples(given["t"].to_numpy(dtype=float)[there], values[there]) if there.any() else None
    rate = estimated(flight, RATE)
    if rate is None or vehicle.inertia is None:
        return None
    step = float(np.median(np.diff(rate.t)))
    window = max(5, 2 * round(0.5 * DERIVATIVE_WINDOW / step) + 1)
    if len(rate.t) < window:
        return None
    inertia = vehicle.inertia_matrix()
    slope = savgol_filter(rate.values, window, 2, deriv=1, delta=step, axis=0)
    smooth = savgol_filter(rate.values, window, 2, axis=0)
    torque = slope @ inertia + np.cross(smooth, smooth @ inertia)
    force = achieved_force(flight, vehicle)
    if force is not None and any(vehicle.center_of_mass):
        torque = torque + np.cross(vehicle.center_of_mass, at(force, rate.t))
    return Samples(rate.t, torque)


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


def residual_torque(flight: Flight, achieved: Samples | None) -> Samples | None:
    """Achieved minus commanded torque (N m): what the model does not explain, (n, 3)."""
    commanded = channel(flight, COMMANDED_WRENCH)
    if achieved is None or commanded is None:
        return None
    return Samples(achieved.t, achieved.values - held(commanded, achieved.t)[:, 3:])


def predicted_residual(flight: Flight, vehicle: Vehicle, gp: Residual, rate: float) -> Band | None:
    """The learned residual at the commanded wrench, at most `rate` times a second; None without a command."""
    commanded = channel(flight, COMMANDED_WRENCH)
    if commanded is None:
        return None
    if vehicle.mass is None or vehicle.inertia is None:
        raise InputError(
            problem(f"vehicle {vehicle.name}: mass or inertia left out", "both, to scale the residual", "Add them.")
        )
    keep = thinned(commanded.t, rate)
    scale = rigid_body.scale(vehicle)
    inputs = commanded.values[keep] / scale
    mean, variance = gp.mean(inputs), gp.variance(inputs)
    return Band(commanded.t[keep], mean * scale[3:], 2.0 * np.sqrt(variance) * scale[3:])


def at(samples: Samples, t: Array) -> Array:
    """The channel at times t, linear between its samples, (n, width)."""
    return np.stack([np.interp(t, samples.t, column) for column in samples.values.T], axis=1)


def held(samples: Samples, t: Array) -> Array:
    """The channel at times t, each sample held until the next: a command acts until the next one."""
    return samples.values[np.clip(np.searchsorted(samples.t, t, side="right") - 1, 0, None)]


def thinned(t: Array, rate: float) -> Array:
    """Indices of t (s) that leave at most one sample in each 1/rate seconds, (m,)."""
    slot = np.floor((t - t[0]) * rate + 1e-6)
    return np.unique(slot, return_index=True)[1]
