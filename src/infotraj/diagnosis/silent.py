"""Axes of rotation on which the recorded actuators and the recorded motion have nothing to do with each other.

Where the prediction makes the error larger than no prediction would, and where not even all effects of the catalogue
together bring it far below, no effect can be named from that axis: clocks that drift, filtered or coarse actuator logs.
What little a fit explains there is chance, and the fit pays for it with absurd numbers.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.diagnosis.plain import binned
from infotraj.diagnosis.residual import FlightSamples, measured_change
from infotraj.rotations import Array

LEAST = 0.5  # of the variance of the measured change of rate, by all effects together
_PRIOR = 3.0  # usual sizes


def silent_axes(samples: Sequence[FlightSamples], joint: Sequence[list[Array]]) -> dict[str, str]:
    """Axes tx, ty, tz that no set of effects explains, with the reason.

    joint: residual and columns of all effects, one (m, 3, 1 + p) a channel of a flight, not whitened.
    """
    found = {}
    for i, axis in enumerate(("tx", "ty", "tz")):
        parts = []
        for s, flight in zip(samples, joint, strict=True):
            for channel, x in zip(s.channels, flight, strict=True):
                if channel.name == "rate":
                    y = measured_change(s, channel)[:, i, None]
                    both = np.concatenate([y, x[:, i]], axis=1)
                    empty = [np.zeros((len(c.last), 1, both.shape[1])) for c in s.channels]
                    empty[s.channels.index(channel)] = both[:, None, :]
                    parts.append(binned([s], [empty])[0][s.channels.index(channel)][:, 0])
        if not parts:
            continue
        share = _explained(np.concatenate(parts))
        if share is not None:
            found[axis] = (
                f"all effects together explain {max(share, 0.0):.0%} of the measured torque about {axis[1]}: these "
                "flights and actuators do not agree there"
            )
    return found


def _explained(x: Array) -> float | None:
    """Share of the measured variance that all columns explain; None where the axis can be used.

    x (N, 2 + p): measured, residual, columns, over bins.
    """
    y, r, columns = x[:, 0], x[:, 1], x[:, 2:]
    variance = float(np.var(y))
    if np.mean(r**2) < variance:
        return None
    gram = columns.T @ columns
    ridge = np.mean(r**2) * np.eye(len(gram)) / _PRIOR**2
    left = r - columns @ np.linalg.solve(gram + ridge, columns.T @ r)
    share = 1.0 - float(np.mean(left**2)) / max(variance, 1e-300)
    return share if share < LEAST else None
