"""Vectors, matrices and rotations of the exact simulation, compiled.

Small functions instead of array expressions: numba compiles every expression anew, and a test run waits for it.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def cross(a, b):
    out = np.empty(3)
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return out


@njit(cache=True)
def dot(a, b):
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@njit(cache=True)
def plus(a, scale, b):
    """a + scale b"""
    out = np.empty(len(a))
    for i in range(len(a)):
        out[i] = a[i] + scale * b[i]
    return out


@njit(cache=True)
def times(matrix, x):
    out = np.zeros(matrix.shape[0])
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            out[i] += matrix[i, j] * x[j]
    return out


@njit(cache=True)
def transposed_times(matrix, x):
    """The transpose of a matrix times x."""
    out = np.zeros(matrix.shape[1])
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            out[j] += matrix[i, j] * x[i]
    return out


@njit(cache=True)
def product(a, b):
    out = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                out[i, j] += a[i, k] * b[k, j]
    return out


@njit(cache=True)
def solve(system, right):
    """Gauss' elimination with row exchanges."""
    a, x, n = system.copy(), right.copy(), len(right)
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[best, k]):
                best = i
        for j in range(n):
            a[k, j], a[best, j] = a[best, j], a[k, j]
        x[k], x[best] = x[best], x[k]
        for i in range(k + 1, n):
            share = a[i, k] / a[k, k]
            for j in range(k, n):
                a[i, j] -= share * a[k, j]
            x[i] -= share * x[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            x[k] -= a[k, j] * x[j]
        x[k] /= a[k, k]
    return x


@njit(cache=True)
def turned_about(v, axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    across, along = cross(axis, v), dot(axis, v) * (1.0 - c)
    out = np.empty(3)
    for i in range(3):
        out[i] = v[i] * c + across[i] * s + axis[i] * along
    return out


@njit(cache=True)
def attitude(q):
    w, x, y, z = q[0], q[1], q[2], q[3]
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )
