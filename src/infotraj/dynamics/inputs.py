"""A vehicle's inputs as a flight holds them: which columns they are, and how a model of that vehicle reads them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj.errors import InputError, problem
from infotraj.flight import COMMANDED_FORCE, COMMANDED_TORQUE, COMMANDED_WRENCH, Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

# The channel of a mapping whose fields the numbered columns are.
CHANNEL = {"cmd_rotor_": "rotor_command", "rotor_": "rotor", "cmd_tilt_": "tilt_command", "tilt_": "tilt"}
SURPLUS = "surplus_columns"


def command_columns(vehicle: Vehicle) -> list[str]:
    """The columns of what is commanded beside tilts: rotors, or the components of the wrench that a log must hold."""
    if vehicle.inputs == "wrench":
        return wrench_columns(vehicle)
    return [f"cmd_rotor_{i}" for i in range(len(vehicle.rotors))]


def input_columns(vehicle: Vehicle, flight: Flight) -> list[str] | None:
    """The columns of the inputs beside tilts that the flight holds: commanded ones, else measured ones, else None."""
    measured = [] if vehicle.inputs == "wrench" else [f"rotor_{i}" for i in range(len(vehicle.rotors))]
    found = (columns for columns in (command_columns(vehicle), measured) if columns and flight.has(*columns))
    return next(found, None)


def wrench_columns(vehicle: Vehicle) -> list[str]:
    """The components of the commanded wrench that a prediction needs.

    Forces across the one axis of thrust are none, and torques say nothing without an inertia.
    """
    axis = vehicle.thrust_axis or (1.0, 1.0, 1.0)
    force = [c for c, along in zip(COMMANDED_FORCE, axis, strict=True) if along != 0.0]
    return force + (list(COMMANDED_TORQUE) if vehicle.inertia is not None else [])


def for_vehicle(flight: Flight, vehicle: Vehicle) -> Flight:
    """The flight as a model of this vehicle reads it; what is given stays as it is, and a second time nothing changes.

    Speeds of rotors are magnitudes: a rotor of the file turns one way, whatever sign a log gives that. Columns of
    rotors and tilts beyond the vehicle's are left out where they are unused, and so are throttles where the rotors take
    speeds and these were measured. Components of a commanded wrench that the file says are none, or that nothing asks
    for, are 0. InputError where surplus columns are in use: the order of the
    vehicle's own is then unknown.
    """
    columns: dict[str, float | Array] = (
        {c: 0.0 for c in COMMANDED_WRENCH if not flight.has(c)} if _takes_wrench(vehicle, flight) else {}
    )
    for column in speed_columns(vehicle, flight):
        values = flight.get(column)[:, 0]
        if np.nanmin(values) < 0.0:
            columns[column] = np.abs(values)
    extra = surplus(flight, vehicle)
    for s in extra:
        if s.used and SURPLUS not in (flight.meta.get("accept") or ()):
            source = flight.meta.get("source", "flight")
            what = f"{source}: {s.count} columns {s.prefix}*, {s.in_use} of them in use{s.still}"
            expected = f"{s.wanted} as {vehicle.name} has"
            raise InputError(problem(what, expected, f"Give the flight's own vehicle file, or {s.remedy}."))
    drop = [c for s in extra for c in s.columns] + throttles_beside_speeds(vehicle, flight)
    if not columns and not drop:
        return flight
    return Flight(flight.table.assign(**columns).drop(columns=drop), dict(flight.meta))


def throttles_beside_speeds(vehicle: Vehicle, flight: Flight) -> list[str]:
    """The columns of commands that are throttles (0..1) of rotors that take speeds, where the log has these as well."""
    if vehicle.inputs == "wrench" or any(r.input != "speed" for r in vehicle.rotors):
        return []
    commands, measured = command_columns(vehicle), [f"rotor_{i}" for i in range(len(vehicle.rotors))]
    if not commands or not flight.has(*commands, *measured):
        return []
    said, turned = flight.get(*commands), flight.get(*measured)
    if np.nanmin(said) < 0.0 or not 0.0 < np.nanmax(said) <= 1.0 or np.nanmax(np.abs(turned)) <= 1.0:
        return []
    return commands


def speed_columns(vehicle: Vehicle, flight: Flight) -> list[str]:
    """The columns with numbers, commanded and measured, of rotors whose input is a speed."""
    rotors = [i for i, r in enumerate(vehicle.rotors) if r.input == "speed"]
    named = (f"{prefix}{i}" for prefix in ("cmd_rotor_", "rotor_") for i in rotors)
    return [c for c in named if flight.has(c)]


@dataclass(frozen=True)
class Surplus:
    """Columns of more rotors or tilts than a vehicle has: names and, where some are in use, those of them in use.

    `picked` counts the columns that may be the vehicle's own; none where no choice of as many commands anything.
    """

    prefix: str
    wanted: int
    count: int
    columns: tuple[str, ...]
    used: tuple[str, ...]
    picked: tuple[int, ...]
    changing: int

    @property
    def in_use(self) -> int:
        """How many columns, the vehicle's own included, are in use."""
        return self.count - len(self.columns) + len(self.used)

    @property
    def still(self) -> str:
        """How many columns change, where not all of those in use do."""
        return f", {self.changing} of which change" if 0 < self.changing < self.in_use else ""

    @property
    def setting(self) -> str:
        """The mapping's setting that would leave the vehicle's own."""
        return f"{CHANNEL[self.prefix]}.pick=[{', '.join(map(str, self.picked))}]"

    @property
    def remedy(self) -> str:
        """What to do, as the tool accepts it."""
        if not self.picked:
            return f"take {CHANNEL[self.prefix]} out of the log's mapping"
        return f"infotraj import LOG --set '{self.setting}' -o NEW.parquet"


def surplus(flight: Flight, vehicle: Vehicle) -> list[Surplus]:
    """Columns of more rotors or tilts than the vehicle has; none of a vehicle that takes a wrench.

    A column is unused where it holds no number, or zeros, or one number while the vehicle's own change.
    """
    if vehicle.inputs == "wrench":
        return []
    found = []
    for prefix in CHANNEL:
        wanted = len(vehicle.rotors) if "rotor" in prefix else len(vehicle.tilts)
        values = flight.numbered(prefix)
        if values.shape[1] <= wanted:
            continue
        own_change = any(_changes(x) for x in values[:, :wanted].T)
        in_use = [k for k, x in enumerate(values.T) if _changes(x) or (np.nan_to_num(x).any() and not own_change)]
        used = [k for k in in_use if k >= wanted]
        picked = tuple(in_use) if len(in_use) == wanted else tuple(range(wanted))
        changing = tuple(k for k, x in enumerate(values.T) if _changes(x))
        if changing and not any(k in changing for k in picked):
            picked = ()  # columns that all stand still command nothing
        found.append(
            Surplus(
                prefix,
                wanted,
                values.shape[1],
                tuple(f"{prefix}{k}" for k in range(wanted, values.shape[1])),
                tuple(f"{prefix}{k}" for k in used),
                picked,
                len(changing),
            )
        )
    return found


def _takes_wrench(vehicle: Vehicle, flight: Flight) -> bool:
    return vehicle.inputs == "wrench" and flight.has(*wrench_columns(vehicle))


def _changes(x: Array) -> bool:
    known = x[np.isfinite(x)]
    return known.size > 0 and bool(np.ptp(known) > 0.0)
