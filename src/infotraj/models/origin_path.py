"""The specific force of the body's origin along a recorded flight, in world axes."""

from __future__ import annotations

from functools import partial

import numpy as np

from infotraj import rotation_matrices, rotations
from infotraj.effects.along import OriginPath
from infotraj.models.interpolation import interpolate
from infotraj.models.recorded import Recorded, Samples
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_SMOOTHED = 0.25  # s: a cubic over it keeps 94 % of what a vehicle does at 3 Hz, 70 % at 5 Hz
_PARALLEL = 1e-3  # rad between axes of thrust that are one


def origin_path(vehicle: Vehicle, r: Recorded, force: Samples | None, start: float) -> OriginPath | None:
    """The path of a flight that begins at `start` (s); from the velocity where no specific force (body) is known."""
    across = None
    if r.attitude is not None and force is not None:
        times = force.times
        turned = rotations.matrix(rotations.normalize(_at(r.attitude, times)))
        values = force.values
        if r.velocity is not None:
            values = values - _constant_error(times, turned, values, r.velocity, vehicle.gravity)
        world = rotation_matrices.turned(turned, values)
        sideways = _across_thrust(vehicle)
        if sideways is not None and r.velocity is not None:
            across = partial(_across, r.attitude, r.velocity, Samples(times, world), sideways, start)
    elif r.velocity is not None:
        times, up = r.velocity.times, np.array([0.0, 0.0, vehicle.gravity])
        world = _slope(r.velocity) + up
    else:
        return None
    speed = np.linalg.norm(r.velocity.values[:5].mean(axis=0)) if r.velocity is not None else np.nan
    times = times - start
    return OriginPath(float(times[0]), float(times[-1]), float(speed), partial(interpolate, times, world), across)


def _constant_error(times: Array, turned: Array, force: Array, velocity: Samples, gravity: float) -> Array:
    """The constant (3,) m/s^2, body axes, by which a measured force does not integrate to the measured velocity."""
    until = (velocity.times >= times[0]) & (velocity.times <= times[-1])
    if until.sum() < 3:
        return np.zeros(3)
    world = rotation_matrices.turned(turned, force) - np.array([0.0, 0.0, gravity])
    gained = _integral(times, world)
    along = _integral(times, turned.reshape(-1, 9))
    at = velocity.times[until]
    left = np.stack([np.interp(at, times, x) for x in gained.T], axis=1) - velocity.values[until]
    columns = np.stack([np.interp(at, times, x) for x in along.T], axis=1).reshape(-1, 3, 3)
    first = np.broadcast_to(-np.eye(3), columns.shape)
    found = np.linalg.lstsq(np.concatenate([columns, first], axis=2).reshape(-1, 6), left.ravel(), rcond=None)[0]
    return found[:3]


def _integral(times: Array, values: Array) -> Array:
    """Integral (m, c) of values (m, c) from the first sample to each, by trapezia."""
    gained = 0.5 * (values[1:] + values[:-1]) * np.diff(times)[:, None]
    return np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(gained, axis=0)])


def _across_thrust(vehicle: Vehicle) -> Array | None:
    """Two directions (2, 3), body axes, along which no rotor pushes; None where there are none."""
    if vehicle.tilts:
        return None
    axes = np.array([r.axis for r in vehicle.rotors] or [vehicle.thrust_axis or (np.nan,) * 3], dtype=float)
    if not np.isfinite(axes).all() or np.linalg.norm(np.cross(axes, axes[0]), axis=1).max() > _PARALLEL:
        return None
    return np.linalg.svd(axes[:1])[2][1:]


def _across(
    attitude: Samples, velocity: Samples, force: Samples, sideways: Array, start: float, time: Array
) -> tuple[Array, Array, Array]:
    """`OriginPath.across` at time (N,) s since `start`."""
    at = time + start
    turned = rotations.matrix(rotations.normalize(attitude.at(at)))
    directions = np.einsum("nij,kj->nki", turned, sideways)
    along = [s.at(at) for s in (force, velocity)]
    return directions, *(np.einsum("nki,ni->nk", directions, x) for x in along)


def _at(samples: Samples, time: Array) -> Array:
    return samples.at(time)


def _slope(velocity: Samples) -> Array:
    """Acceleration (m, 3), smoothed (Savitzky and Golay 1964) where the velocity itself is the slope of positions."""
    times, values = velocity.times, velocity.values
    step = float(np.median(np.diff(times)))
    even = np.arange(times[0], times[-1] + step / 2, step)
    width = 2 * int(_SMOOTHED / step / 2) + 1
    if not velocity.derived or width < 5 or len(even) < width:
        return velocity.slopes
    from scipy.signal import savgol_filter  # late: it takes as long to import as all the rest

    # Frames that are missing or late are put on an even grid.
    gridded = np.stack([np.interp(even, times, x) for x in values.T], axis=1)
    smooth = savgol_filter(gridded, width, 3, deriv=1, delta=step, axis=0)
    return np.stack([np.interp(times, even, x) for x in smooth.T], axis=1)
