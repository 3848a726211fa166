"""The quantities in which a place is named: speeds, height, tilt, tilt rate, thrust, battery, time.

All are taken from the recorded state and commands (actuators after their declared response), and pass the mean of the
window that the residual passed: a residual that is a mean over 0.15 s belongs to the speed's mean over these 0.15 s.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from infotraj import rotations
from infotraj.comparing.window import Window
from infotraj.dynamics.actuators import rotor_frames, thrusts
from infotraj.dynamics.response import actuator_values
from infotraj.flight import ATTITUDE, COMMANDED_WRENCH, POSITION, RATE, VELOCITY, Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

AXES: tuple[str, ...] = ("fx", "fy", "fz", "tx", "ty", "tz")
WORDS = {"x": "forward", "y": "sideways", "z": "upward"}


@dataclass(frozen=True)
class Quantity:
    """One quantity along a flight.

    group: the word under which it counts (speed, height, tilt, tilt rate, rate, thrust, thrust rate, battery, time);
    values (n,); signed: its sign matters, and large means large either way; axis: the one axis that it is meant for,
    None for all.
    """

    name: str
    group: str
    unit: str
    values: Array
    signed: bool = False
    axis: str | None = None


def quantities(flight: Flight, vehicle: Vehicle, seconds: float) -> list[Quantity]:
    """Every quantity that the flight's channels give, on its rows, through the mean of a window of `seconds`."""
    t = flight.t
    found = [Quantity("time", "time", "s", t - t[0])]
    attitude = held(flight, ATTITUDE)
    found += _of_motion(flight, attitude)
    battery = held(flight, ("battery",))
    if battery is not None:
        # A voltage spikes and steps by its resolution; half a second of median leaves its level.
        found.append(Quantity("battery voltage", "battery", "V", _median(battery[:, 0], t)))
    found += _of_actuators(flight, vehicle)
    window = Window.over(t, seconds)
    return [_smoothed(q, window) for q in found]


def cannot_name(flight: Flight, vehicle: Vehicle) -> list[str]:
    """Groups of quantities that this flight's channels cannot give."""
    needs = {
        "speed": VELOCITY,
        "height": POSITION,
        "tilt": ATTITUDE,
        "rate": RATE,
        "battery": ("battery",),
    }
    missing = [group for group, columns in needs.items() if not flight.has(*columns)]
    return missing + ([] if actuator_commands(flight, vehicle) else ["thrust"])


def held(flight: Flight, columns: Iterable[str]) -> Array | None:
    """Columns (n, c) with the last sample held where there is none; None where one of them has no sample at all."""
    columns = tuple(columns)
    if not flight.has(*columns):
        return None
    values = flight.get(*columns)
    good = np.all(np.isfinite(values), axis=1)
    if not good.any():
        return None
    last = np.maximum.accumulate(np.where(good, np.arange(len(good)), -1))
    return values[np.where(last < 0, int(np.argmax(good)), last)]


def _of_motion(flight: Flight, attitude: Array | None) -> list[Quantity]:
    found = []
    velocity, rate, position = held(flight, VELOCITY), held(flight, RATE), held(flight, POSITION)
    if velocity is not None:
        found.append(Quantity("speed", "speed", "m/s", np.linalg.norm(velocity, axis=1)))
        if attitude is not None:
            body = rotations.to_body(attitude, velocity)
            found += [
                Quantity(f"{WORDS[a]} speed", "speed", "m/s", body[:, k], signed=True) for k, a in enumerate("xyz")
            ]
    if position is not None:
        found.append(Quantity("height", "height", "m", position[:, 2]))
    if attitude is not None:
        roll, pitch, _ = np.degrees(rotations.to_euler(attitude)).T
        up = np.clip(rotations.matrix(attitude)[:, 2, 2], -1.0, 1.0)
        found.append(Quantity("tilt of the body", "tilt", "deg", np.degrees(np.arccos(up))))
        found += [
            Quantity("roll", "tilt", "deg", roll, signed=True),
            Quantity("pitch", "tilt", "deg", pitch, signed=True),
        ]
    if rate is not None:
        found.append(Quantity("turning rate", "rate", "rad/s", np.linalg.norm(rate, axis=1)))
        found += [Quantity(f"rate about {a}", "rate", "rad/s", rate[:, k], signed=True) for k, a in enumerate("xyz")]
    return found


def _of_actuators(flight: Flight, vehicle: Vehicle) -> list[Quantity]:
    commands = actuator_commands(flight, vehicle)
    if commands is None:
        return []
    t = flight.t
    rotor, tilt = actuator_values(vehicle, t, *commands)
    dt = np.diff(t, append=2 * t[-1] - t[-2])[:, None]
    after = np.minimum(np.arange(1, len(t) + 1), len(t) - 1)
    if vehicle.inputs == "wrench":
        size = Quantity("thrust", "thrust", "N", np.linalg.norm(rotor[:, :3], axis=1))
        return [size, *_changing("change of the commanded wrench in", (rotor[after] - rotor) / dt)]
    thrust = thrusts(vehicle, rotor)
    found = [Quantity("thrust", "thrust", "N", thrust.sum(axis=1))]
    position, axis = rotor_frames(vehicle, tilt)
    spin = np.array([r.spin * r.moment_constant for r in vehicle.rotors])
    per_newton = np.concatenate([axis, np.cross(position, axis) - spin[:, None] * axis], axis=2)
    if vehicle.tilts:
        slope = (tilt[after] - tilt) / dt
        found.append(
            Quantity("angle of the arms", "tilt", "deg", np.degrees(np.sqrt(np.mean(np.sin(tilt) ** 2, axis=1))))
        )
        found.append(Quantity("tilt rate of the arms", "tilt rate", "rad/s", np.sqrt(np.mean(slope**2, axis=1))))
        moved = np.einsum("nr,nrc->nc", thrust, per_newton[after] - per_newton) / dt
        found += [
            Quantity(f"tilt rate of the arms times thrust, as it turns {a}", "tilt rate", _per_second(a), moved[:, k],
                     signed=True, axis=a)
            for k, a in enumerate(AXES)
        ]  # fmt: skip
    changed = np.einsum("nr,nrc->nc", (thrust[after] - thrust) / dt, per_newton)
    return found + _changing("change of the rotors' thrust in", changed)


def _changing(words: str, slope: Array) -> list[Quantity]:
    """How fast each axis (n, 6) of the wrench changes, N/s and N m/s."""
    return [
        Quantity(f"{words} {a}", "thrust rate", _per_second(a), slope[:, k], signed=True, axis=a)
        for k, a in enumerate(AXES)
    ]


def actuator_commands(flight: Flight, vehicle: Vehicle) -> tuple[Array, Array] | None:
    """Rotor (n, rotors) and tilt (n, tilts) commands, held where a row has none; measured values where none is
    commanded; None where neither is complete. Of a vehicle that takes a wrench: the wrench (n, 6) for the rotors."""
    if vehicle.inputs == "wrench":
        wrench = held(flight, COMMANDED_WRENCH)
        return None if wrench is None else (wrench, np.zeros((len(flight.t), 0)))
    found = []
    for kind, count in (("rotor", len(vehicle.rotors)), ("tilt", len(vehicle.tilts))):
        values: Array | None = np.zeros((len(flight.t), 0))
        if count:
            both = (held(flight, [f"{prefix}{kind}_{i}" for i in range(count)]) for prefix in ("cmd_", ""))
            values = next((v for v in both if v is not None), None)
        if values is None:
            return None
        found.append(values)
    return found[0], found[1]


def _per_second(axis: str) -> str:
    return "N/s" if axis.startswith("f") else "N m/s"


def _smoothed(quantity: Quantity, window: Window) -> Quantity:
    mean = window.mean(quantity.values[:, None])[:, 0]
    values = np.where(np.isfinite(mean), mean, quantity.values)
    return Quantity(quantity.name, quantity.group, quantity.unit, values, quantity.signed, quantity.axis)


def _median(x: Array, t: Array) -> Array:
    from scipy.ndimage import median_filter

    return median_filter(x, size=max(1, round(0.5 / float(np.median(np.diff(t)))) | 1), mode="nearest")
