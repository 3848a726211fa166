"""Effects on the actuators, beyond the declared response. Order: delay, lag with rate limit, play, bias."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from infotraj.dynamics.inputs import command_columns
from infotraj.effects.base import Declared, Effect, Parameter
from infotraj.effects.channels import tilt_columns
from infotraj.effects.laws import ActuatorLaw
from infotraj.errors import InputError, problem
from infotraj.flight import Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_LAG = 0.02  # of the declared time constant; a file that declares none is not off by some: its vehicle has no lag


class ActuationDelay(Effect):
    """Every command, of rotors and tilts or of the wrench, acts `delay` later: transport, bus and computing time."""

    name = "actuation_delay"
    place = "actuators"
    parameters = (Parameter("delay", "s", 0.015, (0.0, 0.2)),)
    delay: float
    needs = ("rotor commands", "moving command")
    source = "transport delay u(t - delay); Franklin et al., Feedback Control of Dynamic Systems, 5.6.3"
    hidden_when = "no commands are recorded, or none changes"
    declared = Declared("clock", 1 / 15, "commands, later by")  # 1 ms

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        return coarse(flight, command_columns(vehicle))

    def actuators(self, law: ActuatorLaw) -> ActuatorLaw:
        return replace(law, delay=law.delay + self.delay)


class RotorLag(Effect):
    """Rotors follow their commands with the time constant declared + extra: dw/dt = (command - w) / tau.

    w is the rotors' input: speed, throttle or thrust. A commanded wrench follows its command in the same way, as it
    does where all rotors' thrusts do.
    """

    name = "rotor_lag"
    place = "actuators"
    parameters = (Parameter("extra_time_constant", "s", 0.03, (0.0, 0.5)),)
    extra_time_constant: float
    needs = ("rotor commands", "moving command")
    source = "first-order lag of a speed-controlled motor; Bouabdallah (2007), 2.4"
    hidden_when = "no rotor command is recorded, or none changes"
    declared = Declared("time", _LAG, "time_constant of {follows}, more by", alone=True)

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        return coarse(flight, command_columns(vehicle))

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        """Down to no lag at all: the file may declare too much."""
        return -float(vehicle.input_time_constants.min()), parameter.bounds[1]

    @classmethod
    def declared_deviation(cls, vehicle: Vehicle, size: float) -> float:
        longest = max([vehicle.time_constant, *(r.time_constant for r in vehicle.rotors)])
        return _LAG * longest / abs(size)

    def actuators(self, law: ActuatorLaw) -> ActuatorLaw:
        return replace(law, rotor_time_constant=np.maximum(law.rotor_time_constant + self.extra_time_constant, 0.0))


class ServoLag(Effect):
    """Tilts follow their commands with the time constant declared + extra: da/dt = (command - a) / tau."""

    name = "servo_lag"
    place = "actuators"
    parameters = (Parameter("extra_time_constant", "s", 0.03, (0.0, 0.5)),)
    extra_time_constant: float
    needs = ("tilt commands",)
    source = "first-order lag of a position servo; Franklin et al., Feedback Control of Dynamic Systems, 3.3"
    declared = Declared("time", _LAG, "time_constant of the tilts, more by", alone=True)
    hidden_when = "no tilt command is recorded, or none changes"

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        return still_tilts(vehicle, flight) or coarse(flight, tilt_columns(vehicle))

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        """Down to no lag at all: the file may declare too much."""
        return -min((t.time_constant for t in vehicle.tilts), default=0.0), parameter.bounds[1]

    @classmethod
    def declared_deviation(cls, vehicle: Vehicle, size: float) -> float:
        return _LAG * max((t.time_constant for t in vehicle.tilts), default=0.0) / abs(size)

    def actuators(self, law: ActuatorLaw) -> ActuatorLaw:
        return replace(law, tilt_time_constant=np.maximum(law.tilt_time_constant + self.extra_time_constant, 0.0))


class ServoRateLimit(Effect):
    """Tilts are slower than declared: |da/dt| <= max_rate, within the lag: da/dt = clip((command - a) / tau)."""

    name = "servo_rate_limit"
    place = "actuators"
    parameters = (Parameter("max_rate", "rad/s", 3.0, (0.2, np.inf), absent=None, meaning="true greatest rate"),)
    max_rate: float | None
    needs = ("tilt commands",)
    source = "slew-rate limit of a servo; Bodie et al. (2019), measured tilt rates"
    hidden_when = "no tilt is commanded to move faster than the limit"

    @classmethod
    def absent(cls, vehicle: Vehicle, parameter: Parameter) -> Array:
        return np.array([max((a.max_rate for a in vehicle.tilts), default=np.inf)])

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        return 0.2, float(cls.absent(vehicle, parameter)[0])

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return -0.5 * min(8.0, float(cls.absent(vehicle, parameter)[0]))

    @classmethod
    def starts(cls, vehicle: Vehicle, parameters: tuple[Parameter, ...]) -> list[dict]:
        top = min(8.0, float(cls.absent(vehicle, cls.parameters[0])[0]))
        return [{"max_rate": share * top} for share in (0.75, 0.5, 0.25, 0.125)]

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        return still_tilts(vehicle, flight)

    def check(self, vehicle: Vehicle) -> None:
        super().check(vehicle)
        if self.max_rate is not None and self.max_rate <= 0:
            raise InputError(problem(f"{self.name}: max_rate {self.max_rate:g}", "more than 0 rad/s", "Correct it."))

    def is_absent(self, vehicle: Vehicle) -> bool:
        return self.max_rate is None or all(self.max_rate >= a.max_rate for a in vehicle.tilts)

    def actuators(self, law: ActuatorLaw) -> ActuatorLaw:
        return replace(
            law, tilt_max_rate=np.minimum(law.tilt_max_rate, np.inf if self.max_rate is None else self.max_rate)
        )


class ServoBacklash(Effect):
    """The arm follows its servo through play: it stays where it is until the servo has moved half_width past it.

    The play operator of Visintin, "Differential Models of Hysteresis" (1994), III.2; the arm starts in the middle.
    """

    name = "servo_backlash"
    place = "actuators"
    parameters = (Parameter("half_width", "rad", 0.015, (0.0, 0.15)),)
    half_width: float
    needs = ("tilt commands",)
    source = "Visintin, Differential Models of Hysteresis (1994), III.2 (play)"
    hidden_when = "no tilt command is recorded, or none changes"

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        return still_tilts(vehicle, flight)

    def actuators(self, law: ActuatorLaw) -> ActuatorLaw:
        return replace(law, tilt_play=law.tilt_play + self.half_width)


class ServoBias(Effect):
    """A constant offset of each tilt: a = what the servo and its play give, plus bias."""

    name = "servo_bias"
    place = "actuators"
    exact = True
    parameters = (Parameter("bias", "rad", 0.0175, (-0.1, 0.1), size="tilts"),)
    bias: Array
    needs = ("tilt commands",)
    source = "zero error of a position servo"
    shifts = True
    declared = Declared("angle", 1 / 10, "tilt_{place}, offset")  # 0.1 deg

    def actuators(self, law: ActuatorLaw) -> ActuatorLaw:
        return replace(law, tilt_bias=law.tilt_bias + self.bias)


def still_tilts(vehicle: Vehicle, flight: Flight) -> str | None:
    """The reason where no tilt is ever commanded to move."""
    tilts = flight.get(*(f"cmd_tilt_{i}" for i in range(len(vehicle.tilts))))
    moves = np.nanmax(tilts, axis=0) - np.nanmin(tilts, axis=0)
    return None if moves.max() > 1e-3 else "no tilt is commanded to move"


def coarse(flight: Flight, columns: Sequence[str], slowest: float = 0.05) -> str | None:
    """The reason where commands are recorded too seldom (every `slowest` s or more) to see how they are followed."""
    values = flight.get(*columns)
    known = np.isfinite(values).all(axis=1)
    t = flight.t[known]
    changes = t[1:][(np.diff(values[known], axis=0) != 0).any(axis=1)]
    if len(changes) < 2:
        return None
    interval = float(np.median(np.diff(changes)))
    if interval < slowest:
        return None
    return f"commands change every {interval * 1e3:.0f} ms only: what lies between two of them is not recorded"
