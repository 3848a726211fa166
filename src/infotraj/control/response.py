"""The inversion of a model whose response is known as a function: h with named effects, and a residual on top.

Eq. 20 with h + effects in the place of h: the command u is sought for which what the model says the vehicle would do,
plus mu(u), is what is demanded. The model is close to h, where u does exactly what it says, so u is corrected by the
acceleration that is still missing (a fixed point; the change of each step is the effects' share of the one before).
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from infotraj.control.inversion import invert
from infotraj.dynamics.allocation import Allocation
from infotraj.rotations import Array

_STEPS = 6
_CLOSE = 1e-3  # m/s^2 and rad/s^2, a tenth of what the sensors show


class Response(Protocol):
    """What a model says a vehicle does at one instant with its actuators at their commands."""

    def accelerations(self, time: float, state: Array, rotor: Array, tilt: Array) -> Array:
        """Specific force of the origin and angular acceleration (6,), m/s^2 and rad/s^2, body axes."""


def invert_response(
    wanted: Array,
    asked: Array,
    time: float,
    state: Array,
    response: Response,
    allocation: Allocation,
    scale: Array,
    process,
    max_correction: float,
    offset: Array,
    correction: Array,
    command: Array,
) -> float:
    """Writes the command (6,), scaled wrench, and returns the acceleration (largest of six) that is still missing.

    wanted (6,): the demand as h would be given it; asked (6,): the specific force and angular acceleration that it
    means. process: `GaussianProcess.mean_arrays`. offset (6,) and correction (3,): what the response and the process
    were found to need for the last command, start value and result. No step leaves `max_correction` about `wanted`.
    """
    missing = np.inf
    for _ in range(_STEPS):
        invert(wanted + offset, process, max_correction, correction, command)
        rotor, tilt = allocation.actuators(command * scale)
        # What the process adds to the command is accounted for in `invert`: it is no error of the response.
        gap = asked - response.accelerations(time, state, rotor, tilt)
        gap[3:] += correction
        step = np.clip(offset + gap, -max_correction, max_correction) - offset
        missing = float(np.abs(step).max())
        if missing < _CLOSE:
            break
        offset += step
    return missing
