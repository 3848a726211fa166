"""Velocity of a rotor through the air."""

from __future__ import annotations

from numba import njit


@njit(cache=True, error_model="numpy")
def rotor_air(velocity, rate, position, direction):
    """x, y, z of v + rate x position (m/s, body axes), and its part along `direction`, each a number.

    velocity (3,) m/s of the body's origin through the air; rate (3,) rad/s; position (3,) m and direction (3,), the
    thrust axis, of the rotor.
    """
    p, d = position, direction
    vx = velocity[0] + rate[1] * p[2] - rate[2] * p[1]
    vy = velocity[1] + rate[2] * p[0] - rate[0] * p[2]
    vz = velocity[2] + rate[0] * p[1] - rate[1] * p[0]
    return vx, vy, vz, vx * d[0] + vy * d[1] + vz * d[2]
