"""How often a table has a row, against how often the log has what the table is needed for: motion and actuators."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from infotraj.rotations import Array

SLOW = 0.02  # s between rows: what moves and what is commanded in between is missed
_TIMES = 1.5  # as many samples as rows, at least: fewer are the same rate, but for jitter
_NEEDED = (
    *("rate", "specific_force", "rotor_command", "tilt_command"),
    *("commanded_force", "commanded_torque", "rotor", "tilt"),
)


def denser(meta: Mapping[str, Any], t: Array) -> dict[str, float]:
    """Where rows are far apart: s between the log's samples of each needed channel that it has more often."""
    step, channels = _step(t), meta.get("channels")
    if round(step, 6) <= SLOW or not isinstance(channels, dict):
        return {}
    rates = {c: channels[c].get("rate_hz") for c in _NEEDED if isinstance(channels.get(c), dict)}
    return {c: 1.0 / hz for c, hz in rates.items() if isinstance(hz, float) and hz * step > _TIMES}


def in_words(found: Mapping[str, float], t: Array) -> str:
    """How often the table has a row, and the log a sample."""
    every = ", ".join(f"{channel} every {1000 * step:.3g} ms" for channel, step in found.items())
    return f"the table has a row every {1000 * _step(t):.3g} ms, where the log has {every}"


def rows_option(found: Mapping[str, float]) -> str:
    """The option of `infotraj import` that makes a row of each sample of the densest of these channels."""
    return f"--rows {min(found, key=lambda channel: found[channel])}"


def _step(t: Array) -> float:
    """The usual time between rows, s; 0 where there is no other row."""
    return float(np.median(np.diff(t))) if len(t) > 1 else 0.0
