"""The logs of the hidden-effect study's flights: as the sensors read, poorer, or as a log profile writes them."""

from __future__ import annotations

import numpy as np
import pandas as pd

from infotraj import rotations
from infotraj.experiment.rough import PROFILES
from infotraj.flight import ATTITUDE, POSITION, VELOCITY, Flight
from infotraj.vehicle import Vehicle

# `held` is of rows faster than the plants' 200 Hz; the other two are conventions that `infotraj import` undoes.
LOGS = ("clean", *(name for name in PROFILES if name not in ("held", "signed_speeds", "wrench")))
# Logs with the rotors' measured speeds: a motion capture system's users log them from the speed controllers.
MEASURED_SPEEDS = ("motion_capture",)
# What a log with measured speeds does not show: between the command and the speed nothing need be predicted.
UNSEEN_IN_LOGS: dict[str, frozenset[str]] = {
    "motion_capture": frozenset(
        {
            "rotor_lag",
            "actuation_delay",
            "gyro_bias",
            "accelerometer_bias",
            "imu_misalignment",
            "time_offset",
            "sensor_lag",
        }
    ),
}
# What a log itself does to the flight, by the names that state it. Filters delay the IMU; where poses come late, every
# command seems to act late; a gyro that was never zeroed has a bias.
_LATE = frozenset({"time_offset", "actuation_delay", "sensor_lag"})
TRUE_OF_LOGS: dict[str, frozenset[str]] = {
    "autopilot": _LATE,
    "motion_capture": _LATE,
    "nanodrone": _LATE | {"gyro_bias"},
    "filters": _LATE,
}


def logged(flight: Flight, kind: str) -> Flight:
    """What a poorer log would hold. mocap: poses at 100 Hz without an IMU; no_tilts: no tilt command; 50hz: every
    fourth row (a command then stands for two)."""
    table, meta = flight.table, {k: v for k, v in flight.meta.items() if k in ("vehicle", "imu_rate", "mocap_rate")}
    table = table[[c for c in table if not c.startswith(("est_", "ref_"))]]
    if kind == "mocap":
        table = table.drop(columns=["wx", "wy", "wz", "ax", "ay", "az"]).iloc[::2]
    elif kind == "no_tilts":
        table = table[[c for c in table if not c.startswith("cmd_tilt_")]]
    elif kind == "50hz":
        table = table.iloc[::4]
    return Flight(table.reset_index(drop=True), meta)


def roughly_logged(
    flight: Flight, true: pd.DataFrame, profile: str, vehicle: Vehicle, noise: float, rng: np.random.Generator
) -> Flight:
    """A flight as a log profile writes it.

    flight: its table, without what the estimator and the reference added; true: the motion at the same rows; noise:
    multiple of the usual noise of poses and velocities. A profile starts from a log that holds everything in every row:
    poses (1 mm, 0.1 deg), velocities (0.01 m/s), the IMU, and measured speeds (0.2 %) where such logs have them.
    """
    n, table = len(true), flight.table.copy()
    for names, size in ((POSITION, 1e-3), (VELOCITY, 1e-2)):
        table[list(names)] = true[list(names)].to_numpy() + noise * size * rng.standard_normal((n, 3))
    turned = rotations.exp(noise * np.radians(0.1) * rng.standard_normal((n, 3)))
    table[list(ATTITUDE)] = rotations.multiply(true[list(ATTITUDE)].to_numpy(), turned)
    if profile in MEASURED_SPEEDS:
        for name in [f"rotor_{k}" for k in range(len(vehicle.rotors))]:
            table[name] = true[name].to_numpy() * (1.0 + 0.002 * noise * rng.standard_normal(n))
    commanded = [c for c in table if c.startswith("cmd_") and not c.startswith(("cmd_rotor_", "cmd_tilt_"))]
    rough = PROFILES[profile].log(Flight(table.drop(columns=commanded), dict(flight.meta)), vehicle, rng)
    tilts = [c for c in table if c.startswith("cmd_tilt_") and c not in rough.table]
    return Flight(rough.table.assign(**{c: table[c].to_numpy() for c in tilts}), dict(rough.meta))
