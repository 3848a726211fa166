"""Crazyflie micro-SD logs, written as the firmware lays them out."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np


def micro_sd(path: Path, t: np.ndarray, columns: dict[str, tuple[str, np.ndarray]]) -> Path:
    """A log of version 2 (us stamps) with one event at t (s): name of the variable, its type letter and values."""
    head = b"\xbc" + struct.pack("<HH", 2, 1) + struct.pack("<H", 7) + b"fixedFrequency\0"
    head += struct.pack("<H", len(columns)) + b"".join(f"{n}({kind})\0".encode() for n, (kind, _) in columns.items())
    form = "<HQ" + "".join(kind for kind, _ in columns.values())
    values = [v if kind in "fd" else np.rint(v).astype(np.int64) for kind, v in columns.values()]
    rows = zip(t, *values, strict=True)
    data = head + b"".join(struct.pack(form, 7, round(t * 1e6), *row) for t, *row in rows)
    path.write_bytes(data + struct.pack("<I", zlib.crc32(data)))
    return path


def floats(prefix: str, names: str, values: np.ndarray) -> dict[str, tuple[str, np.ndarray]]:
    return {f"{prefix}{name}": ("f", column) for name, column in zip(names.split(), values.T, strict=True)}
