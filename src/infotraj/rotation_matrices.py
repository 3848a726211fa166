"""Rotation matrices of many attitudes, and vectors turned by them, compiled: what a prediction does at every instant.

Apart from `rotations`, which starts at once.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from infotraj.rotations import Array


def matrices(q: Array) -> Array:
    """Rotation matrices (N, 3, 3) of unit quaternions (N, 4): body vectors to the world."""
    return _matrices(np.ascontiguousarray(q))


@njit(cache=True)
def _matrices(q):
    out = np.empty((len(q), 3, 3))
    for n in range(len(q)):
        w, x, y, z = q[n, 0], q[n, 1], q[n, 2], q[n, 3]
        out[n, 0, 0], out[n, 0, 1], out[n, 0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
        out[n, 1, 0], out[n, 1, 1], out[n, 1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
        out[n, 2, 0], out[n, 2, 1], out[n, 2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    return out


def turned(matrices: Array, v: Array) -> Array:
    """Body vectors v (N, 3) expressed in the world frame by rotation matrices (N, 3, 3)."""
    return _turned(matrices, np.ascontiguousarray(v), False)


def turned_back(matrices: Array, v: Array) -> Array:
    """World vectors v (N, 3), or one (3,), expressed in the body frame by rotation matrices (N, 3, 3)."""
    return _turned(matrices, np.ascontiguousarray(np.atleast_2d(v)), True)


@njit(cache=True)
def _turned(matrices, v, back):
    out = np.empty((len(matrices), 3))
    for n in range(len(matrices)):
        m = min(n, len(v) - 1)
        for i in range(3):
            total = 0.0
            for j in range(3):
                total += (matrices[n, j, i] if back else matrices[n, i, j]) * v[m, j]
            out[n, i] = total
    return out
