"""What a flight's table holds for a prediction: every channel on its own samples, commands as events."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj import rotations
from infotraj.effects.channels import is_derived, rotor_columns, tilt_columns
from infotraj.errors import InputError, problem
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight, command_steps
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_BATTERY_WINDOW = 21  # samples; a voltage further than a twentieth from their median is a logging error, not a sag
_BATTERY_JUMP = 0.05
_GAP = 4.0  # usual steps between commands; over a longer one they are held


@dataclass(frozen=True)
class Samples:
    """Samples (m, c) of a channel at `times` (m,) s; `derived` where they were computed from another channel."""

    times: Array
    values: Array
    derived: bool = False


@dataclass(frozen=True)
class Recorded:
    """A flight's channels for one vehicle; None for one that the flight neither holds nor implies.

    Velocities are derived from the positions and rates from the attitudes (central differences over two samples)
    where the table does not hold them. Of a row with several channels each is used where it has a number.
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
    """Reads the channels. InputError where the flight lacks what every prediction needs: rotors, and tilts if any."""
    attitude = _samples(flight, ATTITUDE)
    if attitude is not None:
        unit = rotations.continuous(rotations.normalize(attitude.values))
        attitude = Samples(attitude.times, unit, attitude.derived)
    position = _samples(flight, POSITION)
    velocity = _samples(flight, VELOCITY)
    if velocity is None and position is not None and len(position.times) > 2:
        slope = np.gradient(position.values, position.times, axis=0)
        velocity = Samples(position.times, slope, derived=True)
    rate = _samples(flight, RATE)
    if rate is None and attitude is not None and len(attitude.times) > 2:
        rate = Samples(attitude.times, _rates(attitude), derived=True)
    steps = command_steps(flight)
    rotor, rotor_commanded = _actuators(vehicle, flight, "rotor", rotor_columns, steps)
    if vehicle.tilts:
        tilt, tilt_commanded = _actuators(vehicle, flight, "tilt", tilt_columns, steps)
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


def _actuators(vehicle, flight, what, columns, steps) -> tuple[Samples, bool]:
    """Commands as events, each channel held until its next number; else the measured values.

    Where the flight's metadata say that commands made several steps between two rows, these lie evenly on the line
    between them.
    """
    commands = columns(vehicle, f"cmd_{what}_")
    if flight.has(*commands):
        values = flight.table[commands]
        any_number = values.notna().any(axis=1).to_numpy()
        held = values.ffill().bfill().to_numpy(dtype=float)
        logged = Samples(flight.t[any_number], held[any_number])
        return _in_steps(logged, steps), True
    measured = _samples(flight, columns(vehicle, f"{what}_"))
    if measured is None:
        raise InputError(
            problem(
                f"{flight.meta.get('source', 'flight')}: neither {commands[0]}.. nor {what}_0.. for {vehicle.name}",
                f"{len(commands)} columns of commanded or measured {what} values",
                "Add them to the log or to its mapping.",
            )
        )
    return measured, False


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


def _rates(attitude: Samples) -> Array:
    t, q = attitude.times, attitude.values
    turn = rotations.log(rotations.multiply(rotations.conjugate(q[:-1]), q[1:])) / np.diff(t)[:, None]
    middle = (turn[:-1] * np.diff(t)[:-1, None] + turn[1:] * np.diff(t)[1:, None]) / (t[2:] - t[:-2])[:, None]
    return np.concatenate([turn[:1], middle, turn[-1:]])
