"""The example flights, made small from runs of the hidden-effect study: 100 Hz, no more digits than sensors have.

One flight is also written as the log of a flight controller: north, east and down, degrees, g, revolutions a minute.
What was hidden is sealed: no command reads it, and no eye that passes by.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq

from infotraj import rotations
from infotraj.flight import ATTITUDE, COMMANDED_WRENCH, POSITION, RATE, SPECIFIC_FORCE, Flight, read_flight

EVERY = 2  # rows: the plant logs at 200 Hz, and poses and commands change at half of that
DIGITS = 5
_SEAL = """# What was hidden in these flights. No command reads this file. Look after you have made up your mind:
#     tail -n +4 {name} | base64 -d
#
"""
_G = 9.80665  # m/s^2


def pack(flown: str | Path, targets: Sequence[str | Path]) -> None:
    """Writes the flight_K.parquet of a folder, in their order, small to `targets`: as many, else ValueError."""
    flights = sorted(Path(flown).glob("flight_*.parquet"))
    for path, target in zip(flights, targets, strict=True):
        flight = read_flight(path)
        table = flight.table.drop(columns=list(COMMANDED_WRENCH), errors="ignore").iloc[::EVERY]
        Flight(table.round(DIGITS).reset_index(drop=True), {"vehicle": flight.meta["vehicle"]}).write(target)
        pq.write_table(pq.read_table(target), target, compression="zstd", use_dictionary=False)


def board_log(flight: str | Path, path: str | Path) -> None:
    """Writes a packed flight as a flight controller logs: NED and FRD, ms, m, deg, deg/s, g, rpm. CSV."""
    one = read_flight(flight)
    flip = np.array([1.0, -1.0, -1.0])  # forward, left, up to forward, right, down and back
    half = np.sqrt(0.5)
    to_ned = np.array([0.0, half, half, 0.0])  # east, north, up to north, east, down
    attitude = rotations.multiply(rotations.multiply(to_ned, one.get(*ATTITUDE)), np.array([0.0, 1.0, 0.0, 0.0]))
    place = one.get(*POSITION)
    columns = {"time_ms": 1000.0 * one.t}
    for names, values in (
        (("north", "east", "down"), np.stack([place[:, 1], place[:, 0], -place[:, 2]], axis=1)),
        (("roll", "pitch", "yaw"), np.degrees(rotations.to_euler(attitude))),
        (("p", "q", "r"), np.degrees(one.get(*RATE)) * flip),
        (("acc_x", "acc_y", "acc_z"), one.get(*SPECIFIC_FORCE) * flip / _G),
    ):
        columns.update(dict(zip(names, values.T, strict=True)))
    for k, speed in enumerate(one.numbered("cmd_rotor_").T):
        columns[f"rpm_{k + 1}"] = speed * 60.0 / (2.0 * np.pi)
    pd.DataFrame(columns).to_csv(path, index=False, float_format="%.6g")


def seal(truth: str | Path, path: str | Path) -> None:
    """Writes what was hidden (the run's YAML) so that nobody reads it by accident."""
    body = base64.encodebytes(Path(truth).read_bytes()).decode()
    Path(path).write_text(_SEAL.format(name=Path(path).name) + body)
