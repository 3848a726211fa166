"""The attitude of a vehicle that pushes along body z: what its acceleration and yaw ask for (Mellinger, Kumar 2011)."""

from __future__ import annotations

import numpy as np

from infotraj import rotations
from infotraj.rotations import Array


def thrust_attitude(force: Array, yaw: float | Array) -> Array:
    """The attitude (..., 4) with body z along `force` (..., 3), world axes, and body x towards `yaw` (...,) rad."""
    z = force / np.linalg.norm(force, axis=-1, keepdims=True)
    ahead = np.stack([np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)], axis=-1)
    y = np.cross(z, ahead)
    y /= np.linalg.norm(y, axis=-1, keepdims=True)
    return _quaternion(np.stack([np.cross(y, z), y, z], axis=-1))


def _quaternion(R: Array) -> Array:
    """Unit quaternion (..., 4) of rotation matrices (..., 3, 3) that turn by less than a half circle about x or y."""
    w = 0.5 * np.sqrt(np.maximum(1.0 + R[..., 0, 0] + R[..., 1, 1] + R[..., 2, 2], 1e-12))
    other = 0.5 * np.sqrt(np.maximum(1.0 - R[..., 0, 0] - R[..., 1, 1] + R[..., 2, 2], 1e-12))
    by_w = np.stack(
        [
            w,
            (R[..., 2, 1] - R[..., 1, 2]) / (4 * w),
            (R[..., 0, 2] - R[..., 2, 0]) / (4 * w),
            (R[..., 1, 0] - R[..., 0, 1]) / (4 * w),
        ],
        axis=-1,
    )
    by_z = np.stack(
        [
            (R[..., 1, 0] - R[..., 0, 1]) / (4 * other),
            (R[..., 0, 2] + R[..., 2, 0]) / (4 * other),
            (R[..., 1, 2] + R[..., 2, 1]) / (4 * other),
            other,
        ],
        axis=-1,
    )
    return rotations.normalize(np.where((w > other)[..., None], by_w, by_z))
