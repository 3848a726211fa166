"""Unit quaternions (w, x, y, z), body to world, in vectorised form.

Every function takes arrays whose last axis holds the components and broadcasts over the others. The formulas
are those of J. Sola, "Quaternion kinematics for the error-state Kalman filter" (2017), Hamilton convention.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def normalize(q: ArrayLike) -> Array:
    """q / |q|, (..., 4)."""
    q = np.asarray(q, dtype=float)
    return q / np.sqrt(np.einsum("...i,...i->...", q, q))[..., None]


def conjugate(q: ArrayLike) -> Array:
    """The inverse rotation, (..., 4)."""
    return np.asarray(q, dtype=float) * np.array([1.0, -1.0, -1.0, -1.0])


def multiply(p: ArrayLike, q: ArrayLike) -> Array:
    """Hamilton product p q, (..., 4): first q, then p, when both rotate vectors."""
    pw, px, py, pz = np.moveaxis(np.asarray(p, dtype=float), -1, 0)
    qw, qx, qy, qz = np.moveaxis(np.asarray(q, dtype=float), -1, 0)
    return np.stack(
        [
            pw * qw - px * qx - py * qy - pz * qz,
            pw * qx + px * qw + py * qz - pz * qy,
            pw * qy - px * qz + py * qw + pz * qx,
            pw * qz + px * qy - py * qx + pz * qw,
        ],
        axis=-1,
    )


def matrix(q: ArrayLike) -> Array:
    """Rotation matrix of a unit quaternion, (..., 3, 3); maps body vectors to the world."""
    w, x, y, z = np.moveaxis(np.asarray(q, dtype=float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def to_world(q: ArrayLike, v_body: ArrayLike) -> Array:
    """Body vectors v_body (..., 3) expressed in the world frame."""
    return np.einsum("...ij,...j->...i", matrix(q), np.asarray(v_body, dtype=float))


def to_body(q: ArrayLike, v_world: ArrayLike) -> Array:
    """World vectors v_world (..., 3) expressed in the body frame."""
    return np.einsum("...ji,...j->...i", matrix(q), np.asarray(v_world, dtype=float))


def exp(rotvec: ArrayLike) -> Array:
    """Quaternion of a rotation vector (rad), (..., 3) to (..., 4)."""
    rotvec = np.asarray(rotvec, dtype=float)
    half = 0.5 * np.linalg.norm(rotvec, axis=-1, keepdims=True)
    return np.concatenate([np.cos(half), 0.5 * rotvec * np.sinc(half / np.pi)], axis=-1)


def log(q: ArrayLike) -> Array:
    """Rotation vector (rad) of a unit quaternion, the short way round, (..., 4) to (..., 3)."""
    q = np.asarray(q, dtype=float)
    q = np.where(q[..., :1] < 0, -q, q)
    s = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(s, q[..., :1])
    scale = np.where(s > 1e-12, angle / np.where(s > 1e-12, s, 1.0), 2.0)
    return scale * q[..., 1:]


def angle_between(p: ArrayLike, q: ArrayLike) -> Array:
    """Geodesic distance (rad, 0 to pi) between two attitudes, (...)."""
    return np.linalg.norm(log(multiply(conjugate(p), q)), axis=-1)


def from_euler(roll: ArrayLike, pitch: ArrayLike, yaw: ArrayLike) -> Array:
    """Quaternion of roll, pitch, yaw (rad): R = Rz(yaw) Ry(pitch) Rx(roll), (...) to (..., 4)."""
    x, y, z = np.eye(3)
    roll, pitch, yaw = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in (roll, pitch, yaw)))
    return multiply(multiply(exp(yaw[..., None] * z), exp(pitch[..., None] * y)), exp(roll[..., None] * x))


def to_euler(q: ArrayLike) -> Array:
    """Roll, pitch, yaw (rad) of a unit quaternion, (..., 4) to (..., 3); R = Rz(yaw) Ry(pitch) Rx(roll)."""
    w, x, y, z = np.moveaxis(np.asarray(q, dtype=float), -1, 0)
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.stack([roll, pitch, yaw], axis=-1)


def continuous(q: ArrayLike) -> Array:
    """The same attitudes (n, 4) with the signs chosen so that neighbours in time lie close."""
    q = np.array(q, dtype=float)
    dots = np.einsum("ij,ij->i", q[1:], q[:-1])
    q[1:] *= np.cumprod(np.where(dots < 0, -1.0, 1.0))[:, None]
    return q
