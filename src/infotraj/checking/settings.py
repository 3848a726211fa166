"""What would mend a finding on import, as the command that does it: `infotraj import LOG --set CHANNEL.KEY=VALUE`."""

from __future__ import annotations

import shlex

import numpy as np

from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY
from infotraj.rotations import Array

CHANNEL_OF = {
    POSITION: "position",
    ATTITUDE: "attitude",
    VELOCITY: "velocity",
    RATE: "rate",
    SPECIFIC_FORCE: "specific_force",
}


def command(settings: tuple[str, ...]) -> str:
    """The import that applies the settings, as a shell takes it."""
    return " ".join(["infotraj import LOG", *(f"--set {shlex.quote(s)}" for s in settings), "-o NEW.parquet"])


def axes_setting(channel: str, axes: Array) -> str:
    """The setting for a channel that was declared as `axes` (3, 3) times its true value: a signed permutation."""
    along = []
    for column in axes.T:
        k = int(np.argmax(np.abs(column)))
        along.append(("-" if column[k] < 0 else "") + "xyz"[k])
    return f"{channel}.axes=[{', '.join(along)}]"


def scale_setting(channel: str, times: float) -> str:
    """The setting for a channel that is `times` too large."""
    return f"{channel}.scale={1 / times:.6g}"


def shift_setting(channel: str, late: float) -> str:
    """The setting for a channel that is stamped `late` (s)."""
    return f"{channel}.shift={-late:.4f}"
