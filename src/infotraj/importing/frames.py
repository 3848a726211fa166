"""Frames by name: signed permutations from a log's axes to the table's (world z up; body x forward, y left, z up).

A named frame is the list of the log's axes along the table's x, y and z: NED is (y, x, -z), because the table's x
(east) is the log's y, and so on. Any other right-handed arrangement is written out in a mapping, `[x, -z, y]`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.rotations import Array, conjugate, multiply, normalize

WORLD_FRAMES: dict[str, tuple[str, str, str]] = {
    "ENU": ("x", "y", "z"),
    "NWU": ("x", "y", "z"),  # any world with z up stays as it is: the table only says that z is up
    "NED": ("y", "x", "-z"),
}
BODY_FRAMES: dict[str, tuple[str, str, str]] = {
    "FLU": ("x", "y", "z"),
    "FRD": ("x", "-y", "-z"),
    "RFU": ("y", "-x", "z"),
}


def axes_matrix(axes: Sequence[str], mirrored: bool = False) -> Array:
    """(3, 3) matrix that takes a vector's components in the log to those in the table.

    ValueError unless it is a rotation, or with `mirrored` a reflection.
    """
    matrix = np.zeros((3, 3))
    for row, axis in enumerate(axes):
        name, sign = (axis[1:], -1.0) if axis.startswith("-") else (axis.removeprefix("+"), 1.0)
        if name not in ("x", "y", "z"):
            raise ValueError(f"axis {axis!r} is none of x, y, z, -x, -y, -z")
        matrix[row, "xyz".index(name)] = sign
    turn = round(float(np.linalg.det(matrix))) if len(axes) == 3 else 0
    if turn == 0:
        raise ValueError(f"axes {list(axes)} are not three axes (each of x, y, z once)")
    if turn < 0 and not mirrored:
        raise ValueError(f"axes {list(axes)} are not three right-handed axes (each of x, y, z once, determinant +1)")
    return matrix


def rotate_vectors(matrix: Array, values: Array) -> Array:
    """Vectors (n, 3) in the table's axes; exact, because every entry of `matrix` is 0 or +-1."""
    if np.array_equal(matrix, np.eye(3)):
        return values
    columns = []
    for row in matrix:
        axis = int(np.argmax(np.abs(row)))
        columns.append(values[:, axis] * row[axis])
    return np.stack(columns, axis=-1)


def rotate_attitudes(world: Array, body: Array, q: Array) -> Array:
    """Attitudes (n, 4) between the log's axes as attitudes between the table's: R' = W R B^T."""
    if np.array_equal(world, np.eye(3)) and np.array_equal(body, np.eye(3)):
        return q
    return multiply(multiply(_quaternion(world), q), conjugate(_quaternion(body)))


def _quaternion(matrix: Array) -> Array:
    """The unit quaternion of a rotation matrix, by the eigenvector of Bar-Itzhack (2000), exact for half turns too."""
    m = matrix
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0],
            [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
            [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], 0],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], np.trace(m)],
        ]
    )
    vector = np.linalg.eigh(k / 3.0)[1][:, -1]
    return normalize(np.array([vector[3], vector[0], vector[1], vector[2]]))
