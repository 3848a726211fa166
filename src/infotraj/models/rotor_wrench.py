"""Wrench of the rotors at many instants, thrust and reaction torque with what effects add to them."""

from __future__ import annotations

import numpy as np
from numba import njit

from infotraj.rotations import Array


def rotor_wrench(position: Array, axis: Array, thrust: Array, reaction: Array) -> Array:
    """Force (N) and torque (N m) about the body's origin, body axes, (N, 6).

    position, axis (N, rotors, 3); thrust (N, rotors) N; reaction (N, rotors) N m: the reaction torque on the body
    along the axis, -spin x moment_constant x thrust.
    """
    return _rotor_wrench(position, axis, thrust, reaction)


def forces_at_rotors(position: Array, force: Array) -> Array:
    """Wrench about the body's origin (N, 6) of a force (N, rotors, 3) at every rotor."""
    return _forces_at_rotors(position, np.ascontiguousarray(force))


@njit(cache=True)
def _rotor_wrench(position, axis, thrust, reaction):
    count, rotors = thrust.shape
    out = np.zeros((count, 6))
    for n in range(count):
        for r in range(rotors):
            x, y, z = position[n, r, 0], position[n, r, 1], position[n, r, 2]
            a, b, c = axis[n, r, 0], axis[n, r, 1], axis[n, r, 2]
            push, turn = thrust[n, r], reaction[n, r]
            out[n, 0] += push * a
            out[n, 1] += push * b
            out[n, 2] += push * c
            out[n, 3] += push * (y * c - z * b) + turn * a
            out[n, 4] += push * (z * a - x * c) + turn * b
            out[n, 5] += push * (x * b - y * a) + turn * c
    return out


@njit(cache=True)
def _forces_at_rotors(position, force):
    count, rotors = force.shape[:2]
    out = np.zeros((count, 6))
    for n in range(count):
        for r in range(rotors):
            x, y, z = position[n, r, 0], position[n, r, 1], position[n, r, 2]
            a, b, c = force[n, r, 0], force[n, r, 1], force[n, r, 2]
            out[n, 0] += a
            out[n, 1] += b
            out[n, 2] += c
            out[n, 3] += y * c - z * b
            out[n, 4] += z * a - x * c
            out[n, 5] += x * b - y * a
    return out
