"""Gusts after Dryden, in the low-altitude form of MIL-F-8785C (1980), 3.7.2 and 3.7.3.4, as a frozen field passes by.

Along the mean wind sigma_u sqrt(2 L_u / (pi V)) / (1 + T s), across it and upward sigma sqrt(L / (pi V))
(1 + sqrt(3) T s) / (1 + T s)^2, T = L / V; their correlations are exp(-t / T) and exp(-t / T) (1 - t / (2 T)).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm, solve_continuous_lyapunov

from infotraj.robots.plant.hidden import Gusts
from infotraj.rotations import Array

FOOT = 0.3048  # m
LOWEST = 10.0  # ft, below which the standard says nothing


def scales(gusts: Gusts) -> tuple[Array, Array]:
    """Standard deviations (m/s) and lengths (m) along the wind, across it and upward, (3,) each."""
    height = max(gusts.height / FOOT, LOWEST)
    shear = 0.177 + 0.000823 * height
    upward = 0.1 * gusts.speed
    along = upward / shear**0.4
    length = FOOT * height / shear**1.2
    return np.array([along, along, upward]), np.array([length, length, FOOT * height])


def velocities(gusts: Gusts, rows: int, period: float, rng: np.random.Generator) -> Array:
    """Velocity of the air (m/s, world axes, (rows, 3)) beside its mean, stationary from the first row.

    The field passes with the mean wind: the vehicle's own motion through it is left out.
    """
    sigma, length = scales(gusts)
    out = np.empty((rows, 3))
    for axis in range(3):
        out[:, axis] = _passed(sigma[axis], length[axis] / gusts.speed, axis > 0, rows, period, rng)
    c, s = np.cos(gusts.heading), np.sin(gusts.heading)
    return out @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def _passed(sigma: float, time: float, transverse: bool, rows: int, period: float, rng: np.random.Generator) -> Array:
    """White noise through one of the two filters, exact at the rows whatever their period."""
    if transverse:
        a = np.array([[0.0, 1.0], [-1.0 / time**2, -2.0 / time]])
        seen = sigma * np.sqrt(1.0 / time) * np.array([1.0, np.sqrt(3.0) * time]) / time
    else:
        a, seen = np.array([[-1.0 / time]]), np.array([sigma * np.sqrt(2.0 / time)])
    into = np.zeros((len(a), 1))
    into[-1] = 1.0
    steady = solve_continuous_lyapunov(a, -into @ into.T)
    keep = expm(a * period)
    fresh = np.linalg.cholesky(steady - keep @ steady @ keep.T + 1e-15 * np.trace(steady) * np.eye(len(a)))
    state = np.linalg.cholesky(steady) @ rng.standard_normal(len(a))
    noise = rng.standard_normal((rows, len(a))) @ fresh.T
    out = np.empty(rows)
    for k in range(rows):
        out[k] = seen @ state
        state = keep @ state + noise[k]
    return out
