"""The channels of a flight table: which columns belong together, in which dimension, and how they come onto one clock.

A channel's rule (`resample`) says how samples at other times become a value in row k:

- linear: between the two neighbours, where they are no further apart than the stream's gap limit;
- slerp: the same for attitudes, along the geodesic (K. Shoemake, SIGGRAPH 1985);
- mean: the mean over [t_k, t_k+1) of the value held since its sample: what a command did in the row;
- hold: the last value at or before t_k, no older than the gap limit;
- sample: the sample itself in the row nearest to it, and no value in the other rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from infotraj import flight

Resample = Literal["linear", "slerp", "mean", "hold", "sample"]
Frame = Literal["world", "body", "attitude", "none"]


@dataclass(frozen=True)
class Channel:
    """One channel: its columns (for a numbered one the prefix), dimension, frame in the table and rule."""

    name: str
    columns: tuple[str, ...]
    dimension: str
    frame: Frame
    resample: Resample
    numbered: bool = False
    needed_for: str = ""

    def names(self, count: int) -> tuple[str, ...]:
        """The columns' names; `count` is how many a numbered channel has."""
        return tuple(f"{self.columns[0]}{k}" for k in range(count)) if self.numbered else self.columns


_ALL = (
    Channel(
        "position",
        flight.POSITION,
        "length",
        "world",
        "linear",
        needed_for="rollouts, and anything that depends on place or wind",
    ),
    Channel(
        "attitude", flight.ATTITUDE, "number", "attitude", "slerp", needed_for="attitude, and everything in world axes"
    ),
    Channel("velocity", flight.VELOCITY, "speed", "world", "linear", needed_for="drag and rollouts"),
    Channel("rate", flight.RATE, "rate", "body", "linear", needed_for="torque errors"),
    Channel("specific_force", flight.SPECIFIC_FORCE, "acceleration", "body", "linear", needed_for="force errors"),
    Channel("commanded_force", flight.COMMANDED_FORCE, "force", "body", "mean", needed_for="experiments on the wrench"),
    Channel(
        "commanded_torque", flight.COMMANDED_TORQUE, "torque", "body", "mean", needed_for="experiments on the wrench"
    ),
    Channel("rotor_command", ("cmd_rotor_",), "rotor", "none", "mean", numbered=True, needed_for="the prediction"),
    Channel("tilt_command", ("cmd_tilt_",), "angle", "none", "mean", numbered=True, needed_for="tilting rotors"),
    Channel("rotor", ("rotor_",), "rotor", "none", "linear", numbered=True, needed_for="measured rotor speeds"),
    Channel("tilt", ("tilt_",), "angle", "none", "linear", numbered=True, needed_for="measured tilts"),
    Channel("reference_position", flight.REFERENCE_POSITION, "length", "world", "hold", needed_for="tracking"),
    Channel("reference_attitude", flight.REFERENCE_ATTITUDE, "number", "attitude", "hold", needed_for="tracking"),
    Channel("battery", ("battery",), "voltage", "none", "sample", needed_for="battery sag by voltage"),
    Channel("airborne", ("airborne",), "number", "none", "hold"),
)

CHANNELS: dict[str, Channel] = {channel.name: channel for channel in _ALL}
