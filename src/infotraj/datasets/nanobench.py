"""NanoBench: recorded flights of a Crazyflie 2.1 with motion capture, as flight tables.

Source: S. Ullah and T. Baca, "NanoBench" (2026), arXiv 2603.09908, BSD-3-Clause; files datasets/dataset/*.csv of the
repository, or the same as Parquet. What its README and its files disagree on is settled by the files: the columns
w?_vicon are body rates (rad/s) and the quaternion's scalar comes last; roll, pitch and yaw are radians.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
from numpy.typing import NDArray

from infotraj import flight, rotations
from infotraj.errors import InputError, problem
from infotraj.flight import Flight

NAME = "nanobench"
STANDARD_GRAVITY = 9.80665
FULL_SCALE = 65535.0

_CHANNELS = {
    **{c: c for c in (*flight.POSITION, "qw", "qx", "qy", "qz", *flight.VELOCITY)},
    **{f"w{a}": f"w{a}_vicon" for a in "xyz"},
    **{f"a{a}": f"imu_acc_{a}" for a in "xyz"},
    **{f"cmd_rotor_{k}": f"motor_motor_m{k + 1}" for k in range(4)},
    **{f"ref_p{a}": f"sp_ctrltarget_{a}" for a in "xyz"},
    "battery": "pwr_pm_vbat",
}
_YAW_REFERENCE = "sp_ctrltarget_yaw"

# A row among straight lines of all four motor commands for this long is extrapolated, not measured. The logger
# interpolates at most over a few lost packets of 10 ms.
_STRAIGHT_ROWS = 30

UNUSABLE = {
    "B7_oval_slow_rep1": "holds no flight",
    "B6_linear_ramp_rep1": "never rises above 0.20 m",
    "B9_trefoil_fast_rep5": "onboard channels are extrapolated from 19.2 s on",
    "B9_trefoil_fast_rep10": "onboard channels are extrapolated from 19.2 s on",
    "B2_circle_medium_rep3": "onboard channels are extrapolated from 31.3 s on",
}


def files(folder: str | Path) -> dict[str, Path]:
    """Every flight file of the folder by name, without byte-identical repetitions (the first name stays)."""
    found: dict[str, Path] = {}
    seen: set[str] = set()
    for path in sorted(Path(folder).glob("*.parquet")) + sorted(Path(folder).glob("*.csv")):
        digest = flight.sha256(path)
        if path.stem not in found and digest not in seen:
            found[path.stem] = path
            seen.add(digest)
    if not found:
        raise InputError(problem(f"{folder}: no flight", "NanoBench's *.csv or *.parquet", "Fetch the data set."))
    return found


def good_flights(folder: str | Path) -> dict[str, Path]:
    """The files whose whole flight can be used: `files` without UNUSABLE."""
    return {name: path for name, path in files(folder).items() if name not in UNUSABLE}


def speed(name: str) -> str:
    """'slow', 'medium' or 'fast' as the flight's name says; '' where it says nothing (the ramp)."""
    return next((word for word in ("slow", "medium", "fast") if f"_{word}_" in name), "")


def shape(name: str) -> str:
    """The trajectory that the flight's name gives, 'B9' for B9_trefoil_fast_rep4."""
    return name.split("_", 1)[0]


def read(path: str | Path) -> Flight:
    """One NanoBench file as a flight table. InputError where it is not one.

    Pose and velocity (world) and rates (body) are Vicon's; ax, ay, az is the IMU's (specific force, m/s^2);
    cmd_rotor_0..3 is the motor command as a share (0..1) of full scale, after the firmware's battery compensation,
    NaN where the log extrapolates it; ref_* is the set-point; battery is in V, as logged, spikes included.
    """
    path = Path(path)
    try:
        log = pd.read_parquet(path) if path.suffix == ".parquet" else pd.read_csv(path)
    except (OSError, ValueError, pa.ArrowException) as error:
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(problem(f"{path}: cannot be read ({first})", "a NanoBench file", "Fetch it again.")) from error
    missing = [c for c in ("t", *_CHANNELS.values(), _YAW_REFERENCE) if c not in log]
    if missing:
        raise InputError(problem(f"{path}: no columns {', '.join(missing[:4])}", "a NanoBench file", "Check its name."))
    t = log["t"].to_numpy(dtype=float)
    table = pd.DataFrame({"t": t - t[0]})
    for name, source in _CHANNELS.items():
        table[name] = log[source].to_numpy(dtype=float)
    table[["ax", "ay", "az"]] *= STANDARD_GRAVITY
    rotors = [f"cmd_rotor_{k}" for k in range(4)]
    table[rotors] /= FULL_SCALE
    table.loc[extrapolated(table[rotors].to_numpy()), rotors] = np.nan
    yaw = log[_YAW_REFERENCE].to_numpy(dtype=float)
    table[list(flight.REFERENCE_ATTITUDE)] = rotations.from_euler(0.0, 0.0, yaw)
    digest = flight.sha256(path)
    return Flight(table, {"source": str(path), "sha256": digest, "dataset": NAME, "accelerometer": "imu"})


def extrapolated(commands: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Rows (n,) inside a run of at least 0.3 s in which all commands (n, m) lie on straight lines, and change."""
    step = np.diff(commands, axis=0)
    straight = np.abs(np.diff(step, axis=0)).max(axis=1) < 3e-5
    straight &= np.abs(step).max(axis=1)[1:] > 0
    rows = np.zeros(len(commands), dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], straight, [False]]).astype(int)))
    for start, stop in edges.reshape(-1, 2):
        if stop - start >= _STRAIGHT_ROWS:
            rows[start : stop + 2] = True
    return rows
