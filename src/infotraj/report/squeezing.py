"""Columns of numbers as short text: whole steps, what changes from row to row, and no more bits than that takes."""

from __future__ import annotations

import base64
import zlib

import numpy as np

from infotraj.rotations import Array

_MISSING = -(2**31)
_FINEST = 2.0**-20  # of a column's largest value: what single precision holds there


def step(values: Array, wanted: float) -> float:
    """A step for these values: the wanted one, or the coarser one that a number of 32 bits needs."""
    size = np.abs(values[np.isfinite(values)])
    return float(max(wanted if np.isfinite(wanted) else 0.0, _FINEST * np.max(size, initial=0.0), 1e-30))


def squeezed(columns: Array, steps: Array) -> str:
    """Columns (c, n) rounded to whole steps (c,), as base64 of a zlib stream; NaN stays NaN.

    In it stand differences from row to row, of the first row to zero, modulo 2^32, those of either sign by turns
    (0, -1, 1, -2, ..: zigzag), and of all columns first the lowest bytes, then the next: the higher ones are nearly all
    zero. assets/unpacking.js reads it.
    """
    found = np.isfinite(columns)
    whole = np.where(found, np.round(np.where(found, columns, 0.0) / np.asarray(steps)[:, None]), _MISSING)
    change = np.diff(whole.astype(np.int64), axis=1, prepend=0).astype(np.uint32).view(np.int32)
    turned = ((change << 1) ^ (change >> 31)).astype("<u4")
    planes = np.ascontiguousarray(turned).view(np.uint8).reshape(*turned.shape, 4).transpose(2, 0, 1)
    return deflated(planes.tobytes())


def unsqueezed(text: str, steps: Array) -> Array:
    """(c, n): what `squeezed` wrote with these steps (c,)."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(4, len(steps), -1)
    turned = np.ascontiguousarray(planes.transpose(1, 2, 0)).view("<u4")[..., 0]
    change = (turned >> 1).astype(np.int64) ^ -(turned & 1).astype(np.int64)
    whole = np.cumsum(change, axis=1).astype(np.uint32).view(np.int32)
    return np.where(whole == _MISSING, np.nan, whole * np.asarray(steps)[:, None])


def deflated(content: bytes) -> str:
    """Bytes as base64 of a zlib stream, which browsers read themselves."""
    return base64.b64encode(zlib.compress(content, 9)).decode()
