"""Values that no vehicle produces: a wrong unit or column, or damaged bytes. Everything subtler is `check`'s work."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from infotraj.errors import InputError, problem
from infotraj.importing.channels import CHANNELS, Channel
from infotraj.rotations import Array

# SI, far above anything that flies: the limit is against corruption, not against a bad flight.
_LIMITS = {
    "length": 1e7,
    "speed": 1e4,
    "rate": 1e4,
    "acceleration": 1e5,
    "force": 1e7,
    "torque": 1e7,
    "rotor": 1e6,
    "angle": 1e4,
    "voltage": 1e4,
    "number": 1e3,
}
_NORM_TOLERANCE = 0.1
_NORM_SHARE = 0.01


def require_plausible(values: dict[str, Array], names: dict[str, tuple[str, ...]], t: Array, path: Path) -> None:
    """InputError at the first channel with an impossible value, or attitudes that are no unit quaternions."""
    for name, data in values.items():
        channel = CHANNELS[name]
        _bounded(channel, data, names[name], t, path)
        if channel.frame == "attitude":
            _unit(channel, data, path)


def _bounded(channel: Channel, data: Array, columns: tuple[str, ...], t: Array, path: Path) -> None:
    limit = _LIMITS[channel.dimension]
    wrong = np.argwhere(np.isinf(data) | (np.abs(data) > limit))
    if wrong.size:
        row, column = (int(k) for k in wrong[0])
        raise InputError(
            problem(
                f"{path}: {columns[column]} is {data[row, column]:.4g} at t = {t[row]:.4f} s, {len(wrong)} such values",
                f"at most {limit:g} in SI",
                "Correct the unit or scale in a mapping, or cut the log with --from/--to.",
            )
        )


def _unit(channel: Channel, data: Array, path: Path) -> None:
    norm = np.linalg.norm(data[np.isfinite(data).all(axis=1)], axis=1)
    off = np.abs(norm - 1.0) > _NORM_TOLERANCE
    if norm.size and off.mean() > _NORM_SHARE:
        raise InputError(
            problem(
                f"{path}: {channel.name}: {100 * off.mean():.0f} % of the norms are not 1 "
                f"(median {np.median(norm):.3g})",
                "unit quaternions",
                "Are these other columns, or roll, pitch and yaw (`euler: true`)?",
            )
        )
