"""How often a table has a row, against how often the log has what the table is needed for: motion and actuators."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from infotraj.rotations import Array

SLOW = 0.02  # s between rows: what moves and what is commanded in between is missed
_TIMES = 1.5  # as many samples as rows, at least: fewer are the same rate, but for jitter
_COMMANDED = ("rotor_command", "tilt_command", "commanded_force", "commanded_torque")
_NEEDED = ("rate", "specific_force", *_COMMANDED, "rotor", "tilt")
_RARE = 0.0075  # s between commands: a controller of more than 133 Hz is usual


def denser(meta: Mapping[str, Any], t: Array) -> dict[str, float]:
    """Where rows are far apart: s between the log's samples of each needed channel that it has more often."""
    step = _step(t)
    if round(step, 6) <= SLOW:
        return {}
    return {c: logged for c, logged in _logged(meta, _NEEDED).items() if step > _TIMES * logged}


def held(meta: Mapping[str, Any], t: Array) -> dict[str, float]:
    """s between the log's samples of each command that comes rarely, and is held over rows that come more often."""
    step = _step(t)
    return {c: logged for c, logged in _logged(meta, _COMMANDED).items() if logged > max(_TIMES * step, _RARE)}


def averaged(meta: Mapping[str, Any], t: Array) -> bool:
    """Whether a row holds the mean of the commands up to the next: the log has more of them than the table."""
    return any(_step(t) > _TIMES * logged for logged in _logged(meta, _COMMANDED).values())


def in_words(found: Mapping[str, float], t: Array) -> str:
    """How often the table has a row, and the log a sample."""
    every = ", ".join(f"{channel} every {1000 * step:.3g} ms" for channel, step in found.items())
    return f"the table has a row every {1000 * _step(t):.3g} ms, where the log has {every}"


def rows_option(found: Mapping[str, float]) -> str:
    """The option of `infotraj import` that makes a row of each sample of the densest of these channels."""
    return f"--rows {min(found, key=lambda channel: found[channel])}"


def _logged(meta: Mapping[str, Any], names: tuple[str, ...]) -> dict[str, float]:
    """s between the log's samples of these channels, as far as the metadata say it."""
    channels = meta.get("channels")
    known = channels if isinstance(channels, dict) else {}
    said = {c: known[c].get("rate_hz") for c in names if isinstance(known.get(c), dict)}
    return {c: 1.0 / hz for c, hz in said.items() if isinstance(hz, float) and hz > 0.0}


def _step(t: Array) -> float:
    """The usual time between rows, s; 0 where there is no other row."""
    return float(np.median(np.diff(t))) if len(t) > 1 else 0.0
