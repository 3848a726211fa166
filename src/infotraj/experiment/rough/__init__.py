"""Log profiles: what is done to a clean flight so that it reads as users' logs do. Pure functions, one kind a file.

Each takes (flight, vehicle, generator) and returns the flight as logged; its numbers are drawn anew for every flight.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from infotraj.experiment.rough.actuators import signed_speeds, wrench
from infotraj.experiment.rough.autopilot import autopilot
from infotraj.experiment.rough.filters import filters
from infotraj.experiment.rough.motion_capture import motion_capture
from infotraj.experiment.rough.nanodrone import nanodrone
from infotraj.experiment.rough.streams import held_streams
from infotraj.experiment.rough.vibration import vibration
from infotraj.flight import Flight
from infotraj.vehicle import Vehicle


@dataclass(frozen=True)
class Profile:
    """A log profile, the codes of what is truly so in its logs (drop-outs are gaps, swapped markers spikes and jumps),
    the row rates (Hz) that it is found with (none: all), and between what (s) its IMU truly lags its pose: filters
    delay the one, holding the other.
    """

    log: Callable[[Flight, Vehicle, np.random.Generator], Flight]
    true: tuple[str, ...] = ()
    rates: tuple[float, ...] = ()
    lag: tuple[float, float] = (0.0, 0.0)


PROFILES: dict[str, Profile] = {
    "autopilot": Profile(autopilot, rates=(100.0, 125.0, 200.0, 250.0), lag=(0.0, 0.02)),
    "motion_capture": Profile(
        motion_capture, ("gaps", "jitter", "spikes", "pose_jump"), rates=(100.0, 125.0, 200.0, 250.0)
    ),
    "held": Profile(held_streams, rates=(500.0, 1000.0), lag=(-0.012, 0.0)),
    "nanodrone": Profile(nanodrone, rates=(100.0,)),
    "vibration": Profile(vibration),
    "filters": Profile(filters, lag=(0.0, 0.025)),
    "signed_speeds": Profile(signed_speeds),
    "wrench": Profile(wrench),
}
