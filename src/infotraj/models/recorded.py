"""What a flight's table holds for a prediction: every channel on its own samples, commands as events."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from infotraj import rotations
from infotraj.dynamics.inputs import command_columns, input_columns
from infotraj.effects.channels import is_derived, tilt_columns
from infotraj.errors import InputError, problem
from infotraj.flight import (
    ATTITUDE,
    COMMANDED_WRENCH,
    POSITION,
    RATE,
    SPECIFIC_FORCE,
    VELOCITY,
    Flight,
    command_steps,
)
from infotraj.importing import derive
from infotraj.importing.resample import gap_limit
from infotraj.models.interpolation import interpolate
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_BATTERY_WINDOW = 21  # samples; a voltage further than a twentieth from their median is a logging error, not a sag
_BATTERY_JUMP = 0.05
_GAP = 4.0  # usual steps between commands; over a longer one they are held


@dataclass(frozen=True)
class Samples:
    """Samples (m, c) of a channel at `times` (m,) s; `derived` where they were computed from another channel.

    given: of commands, times (s) at which each channel is known: between them its last number is held.
    """

    times: Array
    values: Array
    derived: bool = False
    given: tuple[Array, ...] = ()

    @cached_property
    def usual(self) -> float:
        """The usual interval (s) between two of them."""
        return float(np.median(np.diff(self.times))) if len(self.times) > 1 else np.inf

    @cached_property
    def slopes(self) -> Array:
        """Derivative (m, c), per second, at the samples; zero at one that stands alone."""
        return np.nan_to_num(derive.slope(self.times, self.values, gap_limit(self.times)))

    def at(self, time: Array) -> Array:
        """Values (N, c) at sorted times (N,) s, between the samples."""
        return interpolate(self.times, self.values, time, self.usual)


@dataclass(frozen=True)
class Recorded:
    """A flight's channels for one vehicle; None for one that the flight neither holds nor implies.

    rotor: inputs of the rotors, or the commanded wrench (m, 6) of a vehicle that takes one; they, and tilts, are
    commands where the flight has them, else measured. Velocities are derived from the positions and rates from the
    attitudes (central differences over two samples) where the table does not hold them. Of a row with several channels
    each is used where it has a number.
    """

    t: Array
    attitude: Samples | None
    position: Samples | None
    velocity: Samples | None
    rate: Samples | None
    specific_force: Samples | None
    battery: Samples | None
    rotor: Samples
    tilt: Samples
    rotor_commanded: bool
    tilt_commanded: bool


def recorded(vehicle: Vehicle, flight: Flight) -> Recorded:
    """Reads the channels of a flight as `dynamics.inputs.for_vehicle` gives it.

    InputError where the flight lacks what every prediction needs: the vehicle's inputs, and tilts if any.
    """
    attitude = _samples(flight, ATTITUDE)
    if attitude is not None:
        unit = rotations.continuous(rotations.normalize(attitude.values))
        attitude = Samples(attitude.times, unit, attitude.derived)
    position = _samples(flight, POSITION)
    velocity = _samples(flight, VELOCITY)
    if (velocity is None or velocity.derived) and position is not None:
        velocity = _derived(position, derive.slope_rule) or velocity
    rate = _samples(flight, RATE)
    if (rate is None or rate.derived) and attitude is not None:
        rate = _derived(attitude, derive.rate_rule) or rate
    steps = command_steps(flight)
    columns = input_columns(vehicle, flight)
    if columns is None:
        raise _no_inputs(vehicle, flight)
    rotor_commanded = columns == command_columns(vehicle)
    columns = list(COMMANDED_WRENCH) if vehicle.inputs == "wrench" else columns
    rotor = _commanded(flight, columns, steps) if rotor_commanded else _samples(flight, columns)
    if rotor is None:
        raise _no_inputs(vehicle, flight)
    if vehicle.tilts:
        tilt, tilt_commanded = _tilts(vehicle, flight, steps)
    else:
        tilt, tilt_commanded = Samples(rotor.times[:1], np.zeros((1, 0))), False
    return Recorded(
        flight.t,
        attitude,
        position,
        velocity,
        rate,
        _samples(flight, SPECIFIC_FORCE),
        _battery(flight),
        rotor,
        tilt,
        rotor_commanded,
        tilt_commanded,
    )


def _samples(flight: Flight, columns: tuple[str, ...] | list[str]) -> Samples | None:
    if not flight.has(*columns):
        return None
    values = flight.get(*columns)
    good = np.isfinite(values).all(axis=1)
    if good.sum() < 2:
        return None
    return Samples(flight.t[good], values[good], is_derived(flight, tuple(columns)))


def _commanded(flight: Flight, columns: list[str], steps: int) -> Samples:
    """Commands as events, each channel held until its next number.

    Where the flight's metadata say that commands made several steps between two rows, these lie evenly on the line
    between them.
    """
    values = flight.table[columns]
    any_number = values.notna().any(axis=1).to_numpy()
    held = values.ffill().bfill().to_numpy(dtype=float)
    made = _in_steps(Samples(flight.t[any_number], held[any_number]), steps)
    # A number that is the same after a hole as before was not written again.
    known = values.ffill().eq(values.bfill()) & any_number[:, None]
    return replace(made, given=tuple(flight.t[x] for x in known.to_numpy().T))


def _tilts(vehicle: Vehicle, flight: Flight, steps: int) -> tuple[Samples, bool]:
    commands = tilt_columns(vehicle)
    if flight.has(*commands):
        return _commanded(flight, commands, steps), True
    measured = _samples(flight, tilt_columns(vehicle, "tilt_"))
    if measured is None:
        what = f"{flight.meta.get('source', 'flight')}: neither {commands[0]}.. nor tilt_0.. for {vehicle.name}"
        expected = f"{len(commands)} columns of commanded or measured tilts"
        raise InputError(problem(what, expected, "Add them to the log or to its mapping."))
    return measured, False


def _no_inputs(vehicle: Vehicle, flight: Flight) -> InputError:
    """What to say of a flight without the inputs of its vehicle; the wrench may be what it has instead."""
    source, columns = flight.meta.get("source", "flight"), command_columns(vehicle)
    if vehicle.inputs == "wrench":
        lacking = [c for c in columns if not flight.has(c)]
        remedy = "Add them to the log or to its mapping"
        if vehicle.thrust_axis is None and flight.has("cmd_fz") and set(lacking) <= {"cmd_fx", "cmd_fy"}:
            remedy = "Write `thrust_axis: [0, 0, 1]` into the vehicle file if its rotors push along body z only"
        elif all(c.startswith("cmd_t") for c in lacking):
            remedy += ", or leave `inertia` out of the vehicle file: forces alone are then judged"
        what = f"{source}: no {', '.join(lacking)} for {vehicle.name}"
        return InputError(problem(what, f"the commanded wrench, {', '.join(columns)}", f"{remedy}."))
    what = f"{source}: neither {columns[0]}.. nor rotor_0.. for {vehicle.name}"
    remedy = "Add them to the log or to its mapping."
    if flight.has("cmd_fz"):
        remedy = (
            f"Map the rotors, or write `inputs: wrench` in place of {vehicle.name}'s `rotors` to use cmd_fx..cmd_tz."
        )
    return InputError(problem(what, f"{len(columns)} columns of commanded or measured rotor values", remedy))


def _in_steps(logged: Samples, count: int) -> Samples:
    t, x = logged.times, logged.values
    if count < 2 or len(t) < 2:
        return logged
    near = np.diff(t) < _GAP * np.median(np.diff(t))
    part = np.arange(1, count) / count
    times = (t[:-1, None] + part * np.diff(t)[:, None])[near].ravel()
    values = (x[:-1, None] + part[:, None] * np.diff(x, axis=0)[:, None])[near].reshape(len(times), x.shape[1])
    order = np.argsort(np.concatenate([t, times]), kind="stable")
    return Samples(np.concatenate([t, times])[order], np.concatenate([x, values])[order])


def _battery(flight: Flight) -> Samples | None:
    found = _samples(flight, ("battery",))
    if found is None:
        return None
    volts = flight.table["battery"].dropna()
    middle = volts.rolling(_BATTERY_WINDOW, center=True, min_periods=1).median()
    good = ((volts - middle).abs() <= _BATTERY_JUMP * middle.abs()).to_numpy()
    return Samples(found.times[good], found.values[good]) if good.sum() >= 2 else found


def _derived(samples: Samples, rule: derive.Rule) -> Samples | None:
    times, values = derive.on_even_grid(samples.times, samples.values, gap_limit(samples.times), rule)
    return Samples(times, values, derived=True) if len(times) > 2 else None
