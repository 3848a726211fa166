"""How well a vehicle file explains a flight once its numbers may be off by as much as files are.

Thrust, place and moment constant of each rotor, mass, centre of mass, moments of inertia and the tilts' zeros are
fitted together. How far all of them are off beforehand, from exact to ten percent, is what makes the flight most
probable (marginal likelihood; MacKay 1992): an exact file with one wrong entry is not a file that is wrong everywhere.
What is steady is forgiven: it may be a steady force or torque. Forces are fitted along with torques: a tilt's zero
turns its arm as a reversed spin does, and shows as a force.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from infotraj.comparing.equation_error import EquationError
from infotraj.dynamics.actuators import body_wrench, rotor_frames, thrusts
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_OFF = 0.01  # of each number, of the longest arm for places, in a file that is right to 1 %
_ZERO = 0.01  # rad, of a tilt
_SCALES = (0.05, 0.3, 1.0, 3.0, 10.0)  # of all numbers together, times the above
_ROUNDS = 10  # noise and numbers in turn; they stand still after five


def nats_against(vehicle: Vehicle, rotor: Array, tilt: Array, error: EquationError, width: int) -> float:
    """Minus the logarithm of how probable the flight's wrench is with such a file, the constant left out.

    rotor (n, rotors), tilt (n, tilts): inputs at the rows of `error`, lags included; width: rows of its window.
    """
    columns = uniform_filter1d(_columns(vehicle, rotor, tilt), width, axis=1)
    inertial = np.zeros((4, *error.measured.shape))
    inertial[0, :, :3] = -_OFF * error.measured[:, :3]
    for i in range(3, 6):
        inertial[i - 2, :, i] = -_OFF * error.measured[:, i]
    columns = np.concatenate([columns, inertial])
    rows = np.isfinite(error.residual)
    axes = [i for i in range(6) if rows[:, i].sum() > width]
    targets, tables, counts = [], [], []
    for i in axes:
        y, x = error.residual[rows[:, i], i], columns[:, rows[:, i], i].T
        targets.append(y - y.mean())
        tables.append(x - x.mean(axis=0))
        counts.append(rows[:, i].sum() / width)
    floor = [float(np.nan_to_num(error.floor[i])) ** 2 for i in axes]
    tiny = [1e-12 * float(np.mean(np.square(error.measured[rows[:, i], i]))) + 1e-300 for i in axes]
    square = [float(y @ y) / len(y) for y in targets]
    best = np.inf if axes else 0.0
    for scale in _SCALES if axes else ():
        now = square
        for _ in range(_ROUNDS):
            noise = [v + f + t for v, f, t in zip(now, floor, tiny, strict=True)]
            share = [c / (len(y) * v) for c, y, v in zip(counts, targets, noise, strict=True)]
            gram = np.eye(len(columns)) + scale**2 * sum(w * x.T @ x for w, x in zip(share, tables, strict=True))
            pull = scale * sum(w * x.T @ y for w, x, y in zip(share, tables, targets, strict=True))
            theta = np.linalg.solve(gram, pull)
            now = [float(np.mean((y - scale * x @ theta) ** 2)) for x, y in zip(tables, targets, strict=True)]
        noise = [v + f + t for v, f, t in zip(now, floor, tiny, strict=True)]
        misfit = sum(c * (np.log(n) + v / n) for c, n, v in zip(counts, noise, now, strict=True))
        best = min(best, 0.5 * float(misfit + theta @ theta + np.linalg.slogdet(gram)[1]))
    return best


def _columns(vehicle: Vehicle, rotor: Array, tilt: Array) -> Array:
    """What each number changes of the wrench when it is off by one standard deviation, (numbers, n, 6)."""
    places, axes = rotor_frames(vehicle, tilt)
    places, axes = (np.broadcast_to(x, (len(rotor), *x.shape[-2:])) for x in (places, axes))
    force = thrusts(vehicle, rotor)[..., None] * axes
    spin = np.array([r.spin * r.moment_constant for r in vehicle.rotors])
    reaction = -spin[:, None] * force
    thrust = np.concatenate([force, np.cross(places, force) + reaction], axis=2)
    far = _OFF * float(np.max(np.linalg.norm([r.position for r in vehicle.rotors], axis=1)))
    shifts = [far * np.cross(e, force) for e in np.eye(3)]
    torques = [_OFF * reaction, *shifts]
    found = [_OFF * np.moveaxis(thrust, 1, 0)]
    found += [np.moveaxis(np.concatenate([0.0 * x, x], axis=2), 1, 0) for x in torques]
    # The centre of mass moves all rotors alike.
    found += [np.concatenate([0.0 * x, x], axis=2).sum(axis=1)[None] for x in shifts]
    before, step = body_wrench(vehicle, rotor, tilt), 1e-3
    for i in range(len(vehicle.tilts)):
        turned = tilt.copy()
        turned[:, i] += step
        found.append(_ZERO / step * (body_wrench(vehicle, rotor, turned) - before)[None])
    return np.concatenate(found)
