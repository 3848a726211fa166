"""With a vehicle file: are these its commands, and do they carry it? A wrong unit makes a thrust unlike the weight."""

from __future__ import annotations

import numpy as np

from infotraj.checking.finding import Finding
from infotraj.checking.settings import command
from infotraj.dynamics.actuators import body_wrench
from infotraj.dynamics.inputs import (
    CHANNEL,
    SURPLUS,
    Surplus,
    for_vehicle,
    speed_columns,
    surplus,
    throttles_beside_speeds,
)
from infotraj.errors import InputError
from infotraj.flight import COMMANDED_FORCE, SPECIFIC_FORCE, Flight
from infotraj.importing.again import FLIGHT_TABLE
from infotraj.importing.streams import noted_setting
from infotraj.importing.units import ROTOR_INPUT
from infotraj.rotations import Array, Mask
from infotraj.vehicle import Vehicle

# Thrust coefficients, batteries and masses are wrong by tens of per cent; units by far more.
TOLERATED = 2.5
RPM = 60 / (2 * np.pi)
# Factor on the thrust that a misread unit makes, what it then is, and the setting that mends it.
Unit = tuple[float, str, str]
UNITS: dict[str, tuple[Unit, ...]] = {
    "speed": (
        (RPM**2, "rpm, not rad/s", "rotor_command.unit=rpm"),
        (RPM**-2, "rad/s that were converted from rpm", f"rotor_command.scale={RPM:.6g}"),
    ),
    "thrust": (
        (1000 / 9.80665, "gf, not N", "rotor_command.scale=0.00980665"),
        (1 / 9.80665, "kgf, not N", "rotor_command.scale=9.80665"),
        (1000.0, "mN, not N", "rotor_command.scale=0.001"),
    ),
}
# What a rotor's input is in a log, and how a vehicle file says so.
INPUTS = {
    "speed": ("speeds (rad/s)", "write `input: speed` and `thrust_coefficient` in the vehicle file"),
    "throttle": ("throttle (0..1)", "write `input: throttle` and `thrust_polynomial` in the vehicle file"),
    "thrust": ("thrusts (N)", "write `input: thrust` in the vehicle file"),
}
# Full scale of what a motor is told instead of a throttle (0..1), by the unit's name in a mapping.
THROTTLES = (("percent", 0.0, 100.0), ("pwm_us", 800.0, 2300.0), ("dshot", 40.0, 2100.0), ("pwm16", 0.0, 65535.0))
# A rotor that turns back for more than this share of the flight reverses; single samples are noise about standstill.
_REVERSES = 0.02


def carrying_findings(flight: Flight, airborne: Mask, vehicle: Vehicle | None) -> list[Finding]:
    """Commanded rotors and commanded force against the weight that they carried, by medians over the flight."""
    if vehicle is None or vehicle.mass is None or airborne.sum() < 50:
        return []
    felt = vehicle.gravity
    if flight.has(*SPECIFIC_FORCE):
        felt = _median(np.linalg.norm(flight.get(*SPECIFIC_FORCE)[airborne], axis=1))
    if not 0.5 * vehicle.gravity < felt < 2 * vehicle.gravity:
        return []  # the accelerometer's unit is in question itself
    found = []
    try:
        flight = for_vehicle(flight, vehicle)
    except InputError:
        return []  # which of its columns are this vehicle's is in question
    thrust = rotor_thrust(flight, vehicle)
    if thrust is not None:
        ratio = _median(thrust[airborne]) / (vehicle.mass * felt)
        prefix, wanted = _carrying_prefix(flight), {r.input for r in vehicle.rotors}
        if wanted == {"throttle"}:
            # What is measured of a rotor is a speed, whatever range its numbers keep to.
            units = _throttle_unit(flight.numbered("cmd_rotor_")[airborne], ratio) if prefix else ()
        else:
            units = UNITS[next(iter(wanted))] if len(wanted) == 1 else ()
        if not prefix:
            units = tuple((f, text, setting.replace("rotor_command.", "rotor.")) for f, text, setting in units)
        what = "the rotor commands make" if prefix else "the measured rotors make"
        columns, other = f"{prefix}rotor_0..{len(vehicle.rotors) - 1}", None
        if len(wanted) == 1:
            other = _other_input(flight, airborne, prefix, *wanted)
        found += _judged(ratio, "rotor_unit", what, columns, units, other)
    if flight.has(*COMMANDED_FORCE):
        size = _median(np.linalg.norm(flight.get(*COMMANDED_FORCE)[airborne], axis=1))
        units = (
            (1 / vehicle.mass, "m/s^2 (mass-normalised), not N", f"commanded_force.scale={vehicle.mass:.6g}"),
            (
                1 / (vehicle.mass * vehicle.gravity),
                "weights",
                f"commanded_force.scale={vehicle.mass * vehicle.gravity:.6g}",
            ),
        )
        found += _judged(
            size / (vehicle.mass * felt), "command_unit", "the commanded force is", "cmd_fx..cmd_fz", units
        )
    return found


def _carrying_prefix(flight: Flight) -> str:
    """Of the columns that say what carries the vehicle: the commands', "cmd_", else those of measured ones, ""."""
    return "cmd_" if flight.numbered("cmd_rotor_").shape[1] else ""


def _other_input(flight: Flight, airborne: Mask, prefix: str, wanted: str) -> tuple[str, str] | None:
    """What the log holds of its rotors where the vehicle file takes something else, and what to write in the file.

    The unit that the log was imported by says it; of a table that is none of import's nobody said one. No rotor that
    turns by less than 1 rad/s carries anything.
    """
    channels = flight.meta.get("channels")
    said = channels.get(CHANNEL[f"{prefix}rotor_"]) if isinstance(channels, dict) else None
    unit = said.get("unit") if isinstance(said, dict) else None
    held = ROTOR_INPUT.get(str(unit)) if flight.meta.get("mapping") != FLIGHT_TABLE else None
    numbers = flight.numbered(f"{prefix}rotor_")[airborne]
    numbers = numbers[np.isfinite(numbers)]
    if wanted == "speed" and numbers.size and numbers.min() >= 0.0 and 0.0 < numbers.max() <= 1.0:
        held = "throttle"
    if held is None or held == wanted:
        return None
    return f"the log holds {INPUTS[held][0]}, the vehicle file's rotors take {INPUTS[wanted][0]}", INPUTS[held][1]


def rotor_thrust(flight: Flight, vehicle: Vehicle) -> Array | None:
    """The size of the rotors' summed thrust vector (n,), N, commanded (else measured) and with commanded tilts; None
    where the log does not have one column for each rotor."""
    prefix = _carrying_prefix(flight)
    rotors, tilts = flight.numbered(f"{prefix}rotor_"), flight.numbered(f"{prefix}tilt_")
    if not vehicle.rotors or rotors.shape[1] != len(vehicle.rotors) or tilts.shape[1] < len(vehicle.tilts):
        return None
    return np.linalg.norm(body_wrench(vehicle, rotors, tilts)[:, :3], axis=1)


def column_findings(flight: Flight, airborne: Mask, vehicle: Vehicle | None) -> list[Finding]:
    """Columns of more rotors or tilts than the vehicle has, and signs that speeds of rotors carry."""
    if vehicle is None:
        return []
    found = [_surplus(s, flight) for s in surplus(flight, vehicle)] + _signed(flight, airborne, vehicle)
    if unread := throttles_beside_speeds(vehicle, flight):
        found.append(
            Finding(
                "commands_unread",
                "note",
                f"{unread[0]}..{unread[-1]} are throttles (0..1), and the vehicle file's rotors take speeds (rad/s), "
                "which were measured",
                "predictions rest on the measured speeds; what is between a command and them is not told",
                "nothing",
                channels=tuple(unread),
            )
        )
    return found


def _surplus(found: Surplus, flight: Flight) -> Finding:
    columns = f"{found.columns[0]}..{found.columns[-1]}" if len(found.columns) > 1 else found.columns[0]
    if found.used:
        return Finding(
            SURPLUS,
            "reject",
            f"{found.in_use} columns {found.prefix}* are in use{found.still}, and the vehicle has {found.wanted}",
            "which of them are the vehicle's own, and in which order, is not known",
            f"give the flight's own vehicle file, or {found.remedy}{_another_instance(found, flight)}",
            channels=found.used,
            values={"columns": found.count, "vehicle": found.wanted},
            settings=(found.setting,) if found.picked else (),
        )
    return Finding(
        "unused_columns",
        "note",
        f"{columns} are beyond the vehicle's {found.wanted} and unused (empty, zero or unchanged throughout)",
        "they are left out",
        "nothing",
        channels=found.columns,
    )


def _another_instance(found: Surplus, flight: Flight) -> str:
    """The setting that takes another instance of the topic, where import noted that the log has one."""
    setting = noted_setting(CHANNEL[found.prefix], "instance", flight.meta.get("notes") or ())
    return f"; or, of the topic's other instance, {command((setting,))}" if setting is not None else ""


def _signed(flight: Flight, airborne: Mask, vehicle: Vehicle) -> list[Finding]:
    """A note where speeds are negative; a warning where a rotor turns both ways, which no vehicle file here can say."""
    negative: list[str] = []
    both: list[str] = []
    for column in speed_columns(vehicle, flight):
        x = flight.get(column)[airborne, 0]
        x = x[np.isfinite(x)]
        if not x.size or x.min() >= 0.0:
            continue
        forward, back = (float(np.mean(side > 0.1 * np.median(np.abs(x)))) for side in (x, -x))
        (both if min(forward, back) > _REVERSES else negative).append(column)
    found = []
    if negative:
        found.append(
            Finding(
                "signed_speeds",
                "note",
                f"{', '.join(negative)} are negative: the sign says which way a rotor turns",
                "speeds are read by magnitude: the vehicle file's rotors turn one way, by their `spin`",
                "nothing",
                channels=tuple(negative),
            )
        )
    if both:
        found.append(
            Finding(
                "reversing_rotors",
                "warning",
                f"{', '.join(both)} turn both ways in flight",
                "a rotor of the vehicle file pushes one way: where it turns back its thrust is predicted the wrong way",
                "cut the log to where the rotors turn one way",
                channels=tuple(both),
            )
        )
    return found


def _median(x: Array) -> float:
    x = x[np.isfinite(x)]
    return float(np.median(x)) if x.size else float("nan")


def _throttle_unit(commands: Array, ratio: float) -> tuple[Unit, ...]:
    """What commands (n, rotors) beyond a throttle's range are, by the range that they keep to."""
    known = commands[np.isfinite(commands)]
    if not known.size or np.percentile(known, 99) <= 1.5:
        return ()
    low, high = np.percentile(known, [1, 99])
    names = [name for name, bottom, top in THROTTLES if bottom <= low and high <= top]
    return tuple((ratio, f"{name}, not a throttle (0..1)", f"rotor_command.unit={name}") for name in names[:1])


def _judged(
    ratio: float, code: str, what: str, columns: str, units: tuple[Unit, ...], other: tuple[str, str] | None = None
) -> list[Finding]:
    if not np.isfinite(ratio) or 1 / TOLERATED < ratio < TOLERATED:
        return []
    fitting = [(text, setting) for factor, text, setting in units if 1 / TOLERATED < ratio / factor < TOLERATED]
    causes = [other[0]] if other is not None else []
    remedies = [other[1]] if other is not None else []
    causes += [f"they are in {text}" for text, _ in fitting[:1]]
    remedies += [command((setting,)) for _, setting in fitting[:1]]
    if other is None and fitting:
        remedies.append("correct mass and thrust in the vehicle file")
    elif not remedies:
        remedies = [f"check the unit of {columns}, and mass and thrust coefficients in the vehicle file"]
    return [
        Finding(
            code,
            "reject",
            f"{what} {ratio:.3g} times what carries the vehicle" + (": " if causes else "") + ", or ".join(causes),
            "the prediction would be wrong by that factor",
            "; or ".join(remedies),
            sure=0.99 if causes else 0.95,
            channels=(columns,),
            values={"ratio": ratio},
            settings=(fitting[0][1],) if fitting else (),
        )
    ]
