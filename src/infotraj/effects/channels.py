"""Which channels of a flight there are, in the words of an effect's `needs`, and why one that is missing is missing."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from infotraj.dynamics.inputs import command_columns
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.vehicle import Vehicle

NO_ROTORS = "no rotors in the vehicle file"


def tilt_columns(vehicle: Vehicle, prefix: str = "cmd_tilt_") -> list[str]:
    """Names of the tilts' columns."""
    return [f"{prefix}{i}" for i in range(len(vehicle.tilts))]


FORCE_FROM = "force_from"  # key of a flight's metadata


def from_velocity(flight: Flight) -> bool:
    """Whether a flight is marked: its forces are told from its velocity, though an accelerometer was logged."""
    return bool(flight.meta.get(FORCE_FROM) == "velocity")


def is_derived(flight: Flight, columns: tuple[str, ...]) -> bool:
    """True where the flight's metadata says that one of these columns was derived, not measured."""
    derived = flight.meta.get("derived", ()) or ()
    return any(c in derived for c in columns)


LACKS = {x: f"the vehicle file gives no {x}" for x in ("mass", "inertia")}


def file_lacks(reasons: Iterable[str]) -> list[str]:
    """Which of mass and inertia the vehicle file lacks, by reasons why something cannot be answered."""
    said = list(reasons)
    return [x for x, lacks in LACKS.items() if any(lacks in reason for reason in said)]


def missing_channel(need: str, vehicle: Vehicle, flight: Flight) -> str | None:
    """None where the flight and the vehicle offer `need`, else the reason in words."""
    if need == "mass":
        return LACKS["mass"] if vehicle.mass is None else None
    if need == "inertia":
        return LACKS["inertia"] if vehicle.inertia is None else None
    if need == "tilts":
        return None if vehicle.tilts else "the vehicle has no tilts"
    if need in ("rotors", "radius", "rotor speed") and not vehicle.rotors:
        return NO_ROTORS
    if need == "rotors":
        return None
    if need == "reaction torque":
        known = bool(vehicle.rotors or vehicle.thrust_axis)
        return None if known else f"{NO_ROTORS}, nor a thrust_axis: which torque is their reaction is not known"
    if need == "radius":
        return None if all(r.radius for r in vehicle.rotors) else "the vehicle file gives no rotor radius"
    if need == "rotor speed":
        known = all(r.thrust_coefficient is not None for r in vehicle.rotors)
        taken = " or a ".join(sorted({r.input for r in vehicle.rotors if r.thrust_coefficient is None}))
        return None if known else f"no rotor speed: the rotors take a {taken} and have no thrust_coefficient"
    if need == "attitude":
        return None if flight.has(*ATTITUDE) else "the flight has no attitude (qw..qz)"
    if need == "height":
        reason = missing_channel("attitude", vehicle, flight)
        return reason or (None if flight.has("pz") else "the flight has no height (pz)")
    if need == "velocity":
        reason = missing_channel("attitude", vehicle, flight)
        known = flight.has(*VELOCITY) or flight.has(*POSITION)
        return reason or (None if known else "the flight has neither velocity nor position")
    if need == "rate":
        return None if flight.has(*RATE) or flight.has(*ATTITUDE) else "the flight has neither rates nor attitude"
    if need == "gyro":
        if not flight.has(*RATE):
            return "the flight has no measured rates (wx, wy, wz)"
        return "the rates are derived from the attitude, not measured" if is_derived(flight, RATE) else None
    if need == "accelerometer":
        if not flight.has(*SPECIFIC_FORCE):
            return "the flight has no measured specific force (ax, ay, az)"
        if from_velocity(flight):
            return "the accelerometer shows vibration and little else (accelerometer_shaken)"
        derived = is_derived(flight, SPECIFIC_FORCE)
        return "the specific force is derived from the velocity, not measured" if derived else None
    if need == "gyro or accelerometer":
        reasons = [missing_channel(n, vehicle, flight) for n in ("gyro", "accelerometer")]
        return None if None in reasons else reasons[0]
    if need == "specific force":
        # Where no accelerometer was recorded, changes of the velocity in the world show the same.
        moved = flight.has(*ATTITUDE) and (flight.has(*VELOCITY) or flight.has(*POSITION))
        known = flight.has(*SPECIFIC_FORCE) or moved
        return (
            None if known else "the flight has no specific force (ax, ay, az), nor a pose or velocity to take it from"
        )
    if need == "body motion":
        reason = missing_channel("attitude", vehicle, flight)
        known = flight.has(*SPECIFIC_FORCE) or flight.has(*VELOCITY) or flight.has(*POSITION)
        return reason or (None if known else "the flight has neither specific force nor velocity nor position")
    if need == "rotor commands":
        if flight.has(*command_columns(vehicle)):
            return None
        wrench = vehicle.inputs == "wrench"
        what = "commanded wrench (cmd_fx..cmd_tz)" if wrench else "rotor commands (cmd_rotor_*)"
        return f"the flight has no {what}"
    if need == "tilt commands":
        if not vehicle.tilts:
            return "the vehicle has no tilts"
        return None if flight.has(*tilt_columns(vehicle)) else "the flight has no tilt commands (cmd_tilt_*)"
    if need == "moving command":
        return None if _any_command_moves(vehicle, flight) else "no command changes during the flight"
    raise ValueError(f"unknown need {need!r}")


def _any_command_moves(vehicle: Vehicle, flight: Flight) -> bool:
    columns = [c for c in command_columns(vehicle) + tilt_columns(vehicle) if flight.has(c)]
    return any(np.nanmax(x) > np.nanmin(x) for x in (flight.get(c) for c in columns))
