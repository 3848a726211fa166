"""Actuators of the first-principles model: what rotor speeds and tilts do to the body."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


@lru_cache(maxsize=64)
def turn_parts(axis: tuple[float, float, float]) -> Array:
    """Matrices (3, 3, 3) of a turn about the unit `axis`, right-handed: what it leaves, times cosine, times sine.

    Rodrigues' formula: a vector turned by an angle is (P0 + P1 cos + P2 sin) times the vector.
    """
    along = np.outer(axis, axis)
    x, y, z = axis
    parts = np.array([along, np.eye(3) - along, [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]])
    parts.setflags(write=False)
    return parts


def turned_about(axis: tuple[float, float, float], angle: ArrayLike, vector: ArrayLike) -> Array:
    """`vector` (3,) turned by `angle` (...) rad about the unit `axis`, right-handed: (..., 3)."""
    still, with_cosine, with_sine = turn_parts(axis) @ np.asarray(vector, dtype=float)
    angle = np.asarray(angle, dtype=float)[..., None]
    return np.asarray(still + np.cos(angle) * with_cosine + np.sin(angle) * with_sine)


def rotor_frames(vehicle: Vehicle, tilt: ArrayLike) -> tuple[Array, Array]:
    """Rotor positions (m) and thrust axes, each (..., rotors, 3), body frame, for tilts (..., tilts) in rad."""
    tilt = np.asarray(tilt, dtype=float)
    positions, axes = [], []
    for rotor in vehicle.rotors:
        if rotor.tilt is None:
            shape = (*tilt.shape[:-1], 3)
            positions.append(np.broadcast_to(rotor.position, shape))
            axes.append(np.broadcast_to(rotor.axis, shape))
        else:
            about, angle = vehicle.tilts[rotor.tilt].axis, tilt[..., rotor.tilt]
            positions.append(turned_about(about, angle, rotor.position))
            axes.append(turned_about(about, angle, rotor.axis))
    return np.stack(positions, axis=-2), np.stack(axes, axis=-2)


def thrusts(vehicle: Vehicle, rotor_input: ArrayLike) -> Array:
    """Thrust (N) of each rotor, (..., rotors), from its input as the vehicle says: rad/s, throttle (0..1) or N."""
    rotor_input = np.asarray(rotor_input, dtype=float)
    result = np.empty_like(rotor_input)
    for i, rotor in enumerate(vehicle.rotors):
        x = rotor_input[..., i]
        if rotor.input == "speed":
            result[..., i] = rotor.thrust_coefficient * x * x
        elif rotor.input == "thrust":
            result[..., i] = x
        elif rotor.thrust_polynomial is not None:  # which a rotor with a throttle has
            c0, c1, c2 = rotor.thrust_polynomial
            result[..., i] = c0 + (c1 + c2 * x) * x
    return result


def body_wrench(vehicle: Vehicle, rotor_input: ArrayLike, tilt: ArrayLike) -> Array:
    """Force (N) and torque (N m) about the body's origin, body frame, (..., 6), in steady state.

    Each rotor pushes with its thrust T along its axis d at its position p, and turns the body by its reaction
    torque -spin x moment_constant x T d.
    """
    positions, axes = rotor_frames(vehicle, tilt)
    spin = np.array([r.spin * r.moment_constant for r in vehicle.rotors])
    force = thrusts(vehicle, rotor_input)[..., None] * axes
    torque = np.cross(positions, force) - spin[:, None] * force
    return np.concatenate([force.sum(axis=-2), torque.sum(axis=-2)], axis=-1)
