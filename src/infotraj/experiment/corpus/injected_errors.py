"""Errors that logs of vehicles come with, each put into a log that is right, and the findings that name it rightly."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from infotraj.checking import Check, Finding
from infotraj.experiment.rough.actuators import dead_rotor_sensor, signed_speeds
from infotraj.experiment.rough.columns import held, numbered, replaced, step
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

GRAVITY = 9.81
ENU_NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FLU_FRD = np.diag([1.0, -1.0, -1.0])
Spoil = Callable[[Flight, Vehicle | None, np.random.Generator], Flight]


@dataclass(frozen=True)
class Injected:
    """How a log is spoiled, the codes that name it rightly (patterns), the columns that it can be seen in, whether a
    note is enough (what makes no answer wrong by itself), and whether a vehicle file with rotors in speed is needed."""

    spoil: Spoil
    codes: tuple[str, ...]
    needs: tuple[str, ...] = ()
    note: bool = False
    vehicle: bool = False

    def applies(self, flight: Flight, vehicle: Vehicle | None) -> bool:
        """Whether this log can hold the error."""
        speeds = vehicle is not None and bool(vehicle.rotors) and vehicle.rotors[0].input == "speed"
        return flight.has(*self.needs) and (speeds or not self.vehicle)

    def found(self, check: Check, spoiled: tuple[str, ...] = ()) -> bool:
        """Whether a finding names it, or says of what it names that this error fits as well.

        `spoiled`: the columns that were changed. Where it is one alone, the finding has to name it alone.
        """
        heard = check.findings
        if len(spoiled) == 1 and spoiled != ("t",):
            heard = [f for f in heard if f.channels == spoiled]
        said = named(heard, notes=self.note)
        return any(fnmatch(code.removeprefix("or "), pattern) for code in said for pattern in self.codes)


def named(findings: Sequence[Finding], notes: bool = False) -> set[str]:
    """The codes of warnings or worse, and, as "or CODE", what they say fits as well."""
    found = [f for f in findings if notes or f.severity != "note"]
    return {f.code for f in found} | {f"or {code}" for f in found for code in f.values.get("alternatives", ())}


def attitude(flight: Flight) -> Rotation:
    """The attitude in every row; between samples along the geodesic."""
    q = flight.get(*ATTITUDE)[:, [1, 2, 3, 0]]
    good = np.isfinite(q).all(axis=1)
    known = flight.t[good]
    return Slerp(known, Rotation.from_quat(q[good]))(np.clip(flight.t, known[0], known[-1]))


def late(flight: Flight, names: tuple[str, ...], seconds: float) -> Flight:
    """The columns `seconds` late (early where negative)."""
    columns = []
    for name in names:
        x = flight.get(name)[:, 0]
        good = np.isfinite(x)
        columns.append(np.interp(flight.t - seconds, flight.t[good], x[good]))
    return replaced(flight, names, np.stack(columns, axis=-1))


def _turned(flight: Flight, rotation: Rotation) -> Flight:
    q = rotation.as_quat()[:, [3, 0, 1, 2]]
    # an attitude that was not sampled stays so
    q[~np.isfinite(flight.get(*ATTITUDE)).all(axis=1)] = np.nan
    return replaced(flight, ATTITUDE, q)


def _angles_times(flight: Flight, factor: float) -> Flight:
    return _turned(flight, Rotation.from_euler("ZYX", factor * attitude(flight).as_euler("ZYX")))


def _ned_attitude(flight: Flight) -> Flight:
    return _turned(flight, Rotation.from_matrix(ENU_NED @ attitude(flight).as_matrix() @ FLU_FRD))


def _ned(flight: Flight) -> Flight:
    out = _ned_attitude(flight)
    for names, turn in ((POSITION, ENU_NED), (VELOCITY, ENU_NED), (RATE, FLU_FRD), (SPECIFIC_FORCE, FLU_FRD)):
        if flight.has(*names):
            out = replaced(out, names, flight.get(*names) @ turn.T)
    return out


def _channel(names: tuple[str, ...], change: Callable[[Array, Rotation], Array]) -> Spoil:
    return lambda f, v, rng: replaced(f, names, change(f.get(*names).copy(), attitude(f)))


def _scaled(names: tuple[str, ...], factor: float) -> Spoil:
    return lambda f, v, rng: replaced(f, names, factor * f.get(*names))


def _order(*names: str) -> Spoil:
    return lambda f, v, rng: replaced(f, ATTITUDE, f.get(*names))


def _without_gravity(a: Array, r: Rotation) -> Array:
    return a - r.inv().apply(np.tile([0.0, 0.0, GRAVITY], (len(a), 1)))


def _imu_late(seconds: float) -> Spoil:
    return lambda f, v, rng: late(f, tuple(n for n in (*RATE, *SPECIFIC_FORCE) if f.has(n)), seconds)


def _held_pose(flight: Flight, vehicle: Vehicle | None, rng: np.random.Generator) -> Flight:
    names = [n for n in (*POSITION, *ATTITUDE, *VELOCITY) if flight.has(n)]
    return held(flight, names, rng.integers(3, 11) * step(flight))


def _coarse_rotors(flight: Flight, vehicle: Vehicle | None, rng: np.random.Generator) -> Flight:
    # a byte over the whole range: a few steps between the slowest and the fastest in flight
    names = numbered(flight, "rotor_") or numbered(flight, "cmd_rotor_")
    speed = flight.get(*names)
    unit = float(np.nanmax(speed) / rng.uniform(12.0, 25.0))
    return replaced(flight, names, np.round(speed / unit) * unit)


def _signed(flight: Flight, vehicle: Vehicle | None, rng: np.random.Generator) -> Flight:
    assert vehicle is not None  # as `Injected.vehicle` says
    return signed_speeds(flight, vehicle, rng)


def _dead_rotor(flight: Flight, vehicle: Vehicle | None, rng: np.random.Generator) -> Flight:
    return dead_rotor_sensor(flight, rng)[0]


# what each needs is what could show it: an attitude alone agrees with every other attitude
_W, _V, _A, _P, _Q = RATE, VELOCITY, SPECIFIC_FORCE, POSITION, ATTITUDE
_WQ = (*_W, *_Q)
INJECTED: dict[str, Injected] = {
    "quaternion x y z w in the columns of w x y z": Injected(_order("qx", "qy", "qz", "qw"), ("attitude_order",), _WQ),
    "quaternion w x y z read as x y z w": Injected(_order("qz", "qw", "qx", "qy"), ("attitude_order",), _WQ),
    "quaternion world to body": Injected(
        lambda f, v, rng: replaced(f, _Q, f.get(*_Q) * [1, -1, -1, -1]), ("attitude_inverse",), _WQ
    ),
    "degrees taken as radians": Injected(lambda f, v, rng: _angles_times(f, 180 / np.pi), ("attitude_unit",), _WQ),
    "radians taken as degrees": Injected(lambda f, v, rng: _angles_times(f, np.pi / 180), ("attitude_unit",), _WQ),
    "attitude NED/FRD, the rest ENU/FLU": Injected(lambda f, v, rng: _ned_attitude(f), ("attitude_frame",), _WQ),
    "rates in deg/s": Injected(_scaled(_W, 180 / np.pi), ("rate_unit",), _WQ),
    "rates in the world frame": Injected(_channel(_W, lambda w, r: r.apply(w)), ("rate_frame",), _WQ),
    "body rates turned as if of the world": Injected(_channel(_W, lambda w, r: r.inv().apply(w)), ("rate_frame",), _WQ),
    "rates in FRD": Injected(_channel(_W, lambda w, r: w @ FLU_FRD), ("rate_axes",), _WQ),
    "velocity in the body frame": Injected(
        _channel(_V, lambda v, r: r.inv().apply(v)), ("velocity_frame",), (*_V, *_Q)
    ),
    "velocity in NED": Injected(_channel(_V, lambda v, r: v @ ENU_NED.T), ("velocity_axes",), (*_V, *_Q)),
    "velocity in km/h": Injected(_scaled(_V, 3.6), ("velocity_unit",), (*_V, *_P)),
    "position in mm": Injected(_scaled(_P, 1000.0), ("position_unit",), (*_P, *_V)),
    "acceleration in g": Injected(_scaled(_A, 1 / 9.80665), ("acceleration_unit",), _A),
    "acceleration without gravity": Injected(
        _channel(_A, _without_gravity), ("acceleration_without_gravity",), (*_A, *_Q)
    ),
    "acceleration negated": Injected(_scaled(_A, -1.0), ("acceleration_sign",), _A),
    "acceleration in FRD": Injected(_channel(_A, lambda a, r: a @ FLU_FRD), ("acceleration_axes",), (*_A, *_Q)),
    "all of it NED/FRD": Injected(lambda f, v, rng: _ned(f), ("world_z_down",), (*_Q, *_P, *_A)),
    "IMU 60 ms late": Injected(_imu_late(0.06), ("imu_clock_offset",), _WQ),
    "IMU 40 ms early": Injected(_imu_late(-0.04), ("imu_clock_offset",), _WQ),
    "time in milliseconds": Injected(lambda f, v, rng: replaced(f, ("t",), 1000 * f.t[:, None]), ("time_unit",)),
    "one rotor's sensor dead": Injected(_dead_rotor, ("dead*", "stuck*", "rotor_dead*"), ("cmd_rotor_0",)),
    "poses held for 3 to 10 rows": Injected(_held_pose, ("held*",), _P, note=True),
    "rotor speeds signed": Injected(_signed, ("signed*",), ("cmd_rotor_0",), note=True, vehicle=True),
    "rotor speeds in coarse steps": Injected(_coarse_rotors, ("quantis*",), ("rotor_0",), note=True),
}
