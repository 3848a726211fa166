"""Channels written in steps: how coarse they are against what they show."""

from __future__ import annotations

import numpy as np

from infotraj.checking.finding import Finding
from infotraj.checking.held import measured_groups
from infotraj.flight import Flight
from infotraj.rotations import Array, Mask

# Steps of this share of the channel's standard deviation are worth a note; as large as it, they hide the signal.
NOTED = 0.25
FEW_VALUES = 0.2  # a channel written in steps has fewer different values than this share of its samples


def step_size(x: Array) -> float | None:
    """The step in which the values x (n,) are written, or None where they are not written in steps."""
    values = np.unique(x[np.isfinite(x)])
    if len(values) < 2 or len(values) > FEW_VALUES * np.isfinite(x).sum():
        return None
    apart = np.diff(values)
    # single precision leaves differences of rounding between equal values
    apart = apart[apart > 1e-6 * max(float(np.abs(values).max()), 1e-12)]
    if not len(apart):
        return None
    step = float(apart.min())
    off = np.abs((values - values[0]) / step - np.round((values - values[0]) / step))
    return step if (off < 0.05).mean() > 0.9 else None


def quantised(flight: Flight, airborne: Mask) -> list[Finding]:
    """One finding about all measured columns whose steps are a good part of what they show in flight."""
    found = {}
    for columns in measured_groups(flight):
        for column in columns:
            x = flight.get(column)[airborne, 0]
            x = x[np.isfinite(x)]
            step = step_size(x) if len(x) > 100 else None
            if step is not None and step > NOTED * x.std():
                found[column] = (step, float(step / x.std()))
    if not found:
        return []
    worst = max(share for _, share in found.values())
    return [
        Finding(
            "quantised",
            "warning" if worst >= 1 else "note",
            "written in coarse steps: "
            + ", ".join(f"{c} of {step:.3g} ({share:.2g} of its spread)" for c, (step, share) in found.items()),
            "steps act as noise of 0.3 of their size; what moves by less is not seen",
            "log these channels with more digits" if worst >= 1 else "nothing, or log them with more digits",
            channels=tuple(found),
            values={c: {"step": step, "of_spread": share} for c, (step, share) in found.items()},
        )
    ]
