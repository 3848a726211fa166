"""Numbers that are not of the unit which a mapping declares: a topic keeps its name while its firmware changes what it
writes there (PX4's `actuator_outputs` are pulses in us, or steps of DShot)."""

from __future__ import annotations

import numpy as np

from infotraj.importing.channel_map import ChannelMap
from infotraj.rotations import Array

# Unit: its least and greatest number, those that no setting of a firmware allows, what else such fields hold, and the
# settings that read that.
_RANGES = {
    "pwm_us": (
        (1000.0, 2000.0),
        (800.0, 2200.0),
        "DShot as PX4 writes it (1 to 1999)",
        ("unit=counts", "scale=0.00050025"),
    ),
}
# Limits are calibrated by some per cent, and a motor is off at one number or two outside them, from which it is led up
# in half a second: more different numbers than that are of another unit.
_MARGIN = 0.05
_SHARE = 0.1
_OFF = 3


def outside_unit(name: str, mapped: ChannelMap, logged: Array) -> str | None:
    """Why numbers as logged (n, k) cannot be of the channel's unit, and the settings that read them; else None.

    Judged are the columns that change, each by its different numbers other than 0: most of them have to be outside.
    """
    if mapped.unit not in _RANGES:
        return None
    (low, high), (lowest, highest), otherwise, settings = _RANGES[mapped.unit]
    margin = _MARGIN * (high - low)
    columns = [np.unique(x[np.isfinite(x) & (x != 0.0)]) for x in logged.T]
    moving = [x for x in columns if x.size > 1]
    outside = [
        x
        for x in moving
        if np.sum((x < lowest) | (x > highest)) > _OFF or np.mean((x < low - margin) | (x > high + margin)) > _SHARE
    ]
    if 2 * len(outside) <= len(moving):
        return None
    least, most = min(x[0] for x in outside), max(x[-1] for x in outside)
    remedy = " ".join(f"--set {name}.{setting}" for setting in settings)
    return (
        f"{mapped.fields[0]} runs from {least:.4g} to {most:.4g}, but {mapped.unit} from {low:g} to {high:g}; "
        f"{otherwise} is read with {remedy}"
    )
