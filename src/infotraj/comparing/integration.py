"""The compiled time loop of the rollouts: the classical Runge-Kutta method, of fourth order, on the rigid body.

Position, velocity (world), attitude quaternion and rate (body) are integrated together; the quaternion is normalised
after each step. The wrench is given at the beginning, the middle and the end of every interval, just after and just
before the commands that bound it, so that no interval reaches over a jump.
"""

from __future__ import annotations

import numpy as np
from numba import njit

ORDER = 4


@njit(cache=True, error_model="numpy")
def roll(first, step, fixed, parts, active, mass, inertia, inverse, center, gravity, states, horizons, out):
    """Rolls every start forward and writes the state after each of the horizons.

    first (s,): interval of each start; step (i,) s: length of each interval; fixed (i, 3, 6), parts (i, 3, a, 6),
    active (a,): the wrench as state_wrench.LinearForm at the beginning, middle and end of each interval; states (s,
    13): position, velocity (world), quaternion, rate; horizons (s, h): intervals from each start, 0 for none; out (s,
    h, 13).
    """
    current, end = np.empty(13), np.empty(13)
    slopes = np.empty((4, 13))
    values = np.empty(18)
    for s in range(len(first)):
        current[:] = states[s]
        for done in range(horizons[s].max()):
            i = first[s] + done
            dt = step[i]
            _slope(
                current, fixed[i, 0], parts[i, 0], active, mass, inertia, inverse, center, gravity, values, slopes[0]
            )
            for c in range(13):
                end[c] = current[c] + 0.5 * dt * slopes[0, c]
            _slope(end, fixed[i, 1], parts[i, 1], active, mass, inertia, inverse, center, gravity, values, slopes[1])
            for c in range(13):
                end[c] = current[c] + 0.5 * dt * slopes[1, c]
            _slope(end, fixed[i, 1], parts[i, 1], active, mass, inertia, inverse, center, gravity, values, slopes[2])
            for c in range(13):
                end[c] = current[c] + dt * slopes[2, c]
            _slope(end, fixed[i, 2], parts[i, 2], active, mass, inertia, inverse, center, gravity, values, slopes[3])
            for c in range(13):
                current[c] += dt / 6.0 * (slopes[0, c] + 2.0 * (slopes[1, c] + slopes[2, c]) + slopes[3, c])
            norm = np.sqrt(current[6] ** 2 + current[7] ** 2 + current[8] ** 2 + current[9] ** 2)
            for c in range(6, 10):
                current[c] /= norm
            for h in range(horizons.shape[1]):
                if horizons[s, h] == done + 1:
                    out[s, h] = current


@njit(cache=True, error_model="numpy", inline="always")
def _slope(x, fixed, parts, active, mass, inertia, inverse, center, gravity, values, out):
    w, a, b, c = x[6], x[7], x[8], x[9]
    scale = 2.0 / (w * w + a * a + b * b + c * c)
    r00, r01, r02 = 1.0 - scale * (b * b + c * c), scale * (a * b - w * c), scale * (a * c + w * b)
    r10, r11, r12 = scale * (a * b + w * c), 1.0 - scale * (a * a + c * c), scale * (b * c - w * a)
    r20, r21, r22 = scale * (a * c - w * b), scale * (b * c + w * a), 1.0 - scale * (a * a + b * b)
    p, q, r = x[10], x[11], x[12]
    f0, f1, f2, m0, m1, m2 = fixed[0], fixed[1], fixed[2], fixed[3], fixed[4], fixed[5]
    if len(active) > 0:
        values[0] = r00 * x[3] + r10 * x[4] + r20 * x[5]
        values[1] = r01 * x[3] + r11 * x[4] + r21 * x[5]
        values[2] = r02 * x[3] + r12 * x[4] + r22 * x[5]
        values[3], values[4], values[5] = p, q, r
        for k in range(3):
            values[6 + k] = abs(values[k]) * values[k]
        values[9], values[10], values[11] = r00, r01, r02
        values[12], values[13], values[14] = r10, r11, r12
        values[15], values[16], values[17] = r20, r21, r22
        for k in range(len(active)):
            v = values[active[k]]
            f0 += parts[k, 0] * v
            f1 += parts[k, 1] * v
            f2 += parts[k, 2] * v
            m0 += parts[k, 3] * v
            m1 += parts[k, 4] * v
            m2 += parts[k, 5] * v
    # J w' = tau - c x F - w x J w; then the origin's specific force is F / m - w' x c - w x (w x c).
    j0 = inertia[0, 0] * p + inertia[0, 1] * q + inertia[0, 2] * r
    j1 = inertia[1, 0] * p + inertia[1, 1] * q + inertia[1, 2] * r
    j2 = inertia[2, 0] * p + inertia[2, 1] * q + inertia[2, 2] * r
    c0, c1, c2 = center[0], center[1], center[2]
    m0 -= c1 * f2 - c2 * f1 + q * j2 - r * j1
    m1 -= c2 * f0 - c0 * f2 + r * j0 - p * j2
    m2 -= c0 * f1 - c1 * f0 + p * j1 - q * j0
    d0 = inverse[0, 0] * m0 + inverse[0, 1] * m1 + inverse[0, 2] * m2
    d1 = inverse[1, 0] * m0 + inverse[1, 1] * m1 + inverse[1, 2] * m2
    d2 = inverse[2, 0] * m0 + inverse[2, 1] * m1 + inverse[2, 2] * m2
    along = p * c0 + q * c1 + r * c2
    square = p * p + q * q + r * r
    s0 = f0 / mass - (d1 * c2 - d2 * c1) - (p * along - square * c0)
    s1 = f1 / mass - (d2 * c0 - d0 * c2) - (q * along - square * c1)
    s2 = f2 / mass - (d0 * c1 - d1 * c0) - (r * along - square * c2)
    out[0], out[1], out[2] = x[3], x[4], x[5]
    out[3] = r00 * s0 + r01 * s1 + r02 * s2
    out[4] = r10 * s0 + r11 * s1 + r12 * s2
    out[5] = r20 * s0 + r21 * s1 + r22 * s2 - gravity
    out[6] = -0.5 * (a * p + b * q + c * r)
    out[7] = 0.5 * (w * p + b * r - c * q)
    out[8] = 0.5 * (w * q + c * p - a * r)
    out[9] = 0.5 * (w * r + a * q - b * p)
    out[10], out[11], out[12] = d0, d1, d2
