"""Newton and Euler about a body's origin that need not be its centre of mass, with loads that hang from it.

Featherstone, "Rigid Body Dynamics Algorithms" (2008), 2.13, written for the origin: with the centre of mass at r and
the inertia J about it, J dw = tau - r x F - w x J w and f = F / m - dw x r - w x (w x r).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit

from infotraj.effects.base import Load
from infotraj.effects.laws import BodyLaw
from infotraj.rotations import Array


def cross(a: Array, b: Array) -> Array:
    """a x b for (N, 3) or (3,), without numpy's overhead for short vectors."""
    if a.ndim == b.ndim == 1:
        return _cross(a[None], b[None])[0]
    return _cross(np.atleast_2d(a), np.atleast_2d(b))


@njit(cache=True)
def _cross(a, b):
    count = max(len(a), len(b))
    out = np.empty((count, 3))
    for n in range(count):
        i, j = min(n, len(a) - 1), min(n, len(b) - 1)
        out[n, 0] = a[i, 1] * b[j, 2] - a[i, 2] * b[j, 1]
        out[n, 1] = a[i, 2] * b[j, 0] - a[i, 0] * b[j, 2]
        out[n, 2] = a[i, 0] * b[j, 1] - a[i, 1] * b[j, 0]
    return out


def angular_acceleration(law: BodyLaw, force: Array, torque: Array, rate: Array) -> Array:
    """Angular acceleration (N, 3) rad/s^2, body axes, of force and torque (N, 3) about the origin."""
    assert law.inertia is not None  # nobody asks where the vehicle file leaves it out; below the same of the mass
    return _turning(force, torque, rate, law.inertia, np.linalg.inv(law.inertia), law.center_of_mass)


@njit(cache=True)
def _turning(force, torque, rate, inertia, inverse, place):
    out, moment = np.empty_like(rate), np.empty(3)
    beside = place.any()  # of a force that is not known nothing is asked else
    for n in range(len(rate)):
        f, w = force[n], rate[n]
        h0 = inertia[0, 0] * w[0] + inertia[0, 1] * w[1] + inertia[0, 2] * w[2]
        h1 = inertia[1, 0] * w[0] + inertia[1, 1] * w[1] + inertia[1, 2] * w[2]
        h2 = inertia[2, 0] * w[0] + inertia[2, 1] * w[1] + inertia[2, 2] * w[2]
        moment[0] = torque[n, 0] - (w[1] * h2 - w[2] * h1)
        moment[1] = torque[n, 1] - (w[2] * h0 - w[0] * h2)
        moment[2] = torque[n, 2] - (w[0] * h1 - w[1] * h0)
        if beside:
            moment[0] -= place[1] * f[2] - place[2] * f[1]
            moment[1] -= place[2] * f[0] - place[0] * f[2]
            moment[2] -= place[0] * f[1] - place[1] * f[0]
        for i in range(3):
            out[n, i] = inverse[i, 0] * moment[0] + inverse[i, 1] * moment[1] + inverse[i, 2] * moment[2]
    return out


def specific_force(law: BodyLaw, force: Array, rate: Array | None, angular: Array) -> Array:
    """Specific force (N, 3) m/s^2 of the body's origin, body axes; NaN where it hangs on a rate that is not known."""
    assert law.mass is not None
    result = force / law.mass
    r = law.center_of_mass
    if r.any():
        if rate is None:
            return np.full_like(result, np.nan)
        result = result - lever(r, rate, angular)
    return result


def lever(place: Array, rate: Array | None, angular: Array) -> Array:
    """Specific force (N, 3) by which a point `place` (3,) of the body differs from its origin; NaN without a rate."""
    if rate is None:
        return np.full_like(angular, np.nan)
    return _lever(place, rate, angular)


@njit(cache=True)
def _lever(r, rate, angular):
    out = np.empty_like(angular)
    for n in range(len(angular)):
        w, a = rate[n], angular[n]
        # w x (w x r) = w (w . r) - r (w . w)
        along, square = w[0] * r[0] + w[1] * r[1] + w[2] * r[2], w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
        out[n, 0] = a[1] * r[2] - a[2] * r[1] + w[0] * along - r[0] * square
        out[n, 1] = a[2] * r[0] - a[0] * r[2] + w[1] * along - r[1] * square
        out[n, 2] = a[0] * r[1] - a[1] * r[0] + w[2] * along - r[2] * square
    return out


def response_to_force(law: BodyLaw, direction: Array) -> tuple[Array, Array]:
    """Specific force and angular acceleration, each (N, 3), that 1 N along `direction` (N, 3) at the origin makes."""
    assert law.mass is not None
    r = law.center_of_mass
    if not r.any() or law.inertia is None:
        return direction / law.mass, np.zeros_like(direction)
    angular = -cross(r, direction) @ np.linalg.inv(law.inertia)
    return direction / law.mass - cross(angular, r), angular


def pulls(law: BodyLaw, loads: Sequence[Load], free: Array) -> Array:
    """Force (N) with which each load pulls, (loads, N), for the specific force `free` (N, 3) without them.

    A load pulls with mass x (swing - direction . f), and f itself changes with the pull: f = free + sum of the
    responses. Linear in the pulls, solved at every instant.
    """
    responses = [response_to_force(law, load.direction)[0] for load in loads]
    system = np.empty((len(free), len(loads), len(loads)))
    right = np.empty((len(free), len(loads), 1))
    for i, load in enumerate(loads):
        right[:, i, 0] = load.mass * (load.swing - np.einsum("ni,ni->n", load.direction, free))
        for j, response in enumerate(responses):
            system[:, i, j] = load.mass * np.einsum("ni,ni->n", load.direction, response) + (i == j)
    return np.asarray(np.linalg.solve(system, right)[..., 0].T, dtype=float)
