"""A flight table as a CSV in NED and FRD with angles in degrees, and the mapping that undoes it. For tests only."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from infotraj import rotations
from infotraj.flight import Flight

NED_MAPPING: dict[str, Any] = {
    "name": "ned_degrees",
    "reads": ["table"],
    "world": "NED",
    "body": "FRD",
    "time": {"fields": "time_ms", "unit": "ms"},
    "streams": [
        {
            "name": "row",
            "channels": {
                "position": {"fields": ["north", "east", "down"], "unit": "mm"},
                "attitude": {"fields": ["roll", "pitch", "yaw"], "euler": True, "unit": "deg"},
                "velocity": {"fields": ["u", "v", "w"], "expressed_in": "body"},
                "rate": {"fields": ["p", "q", "r"], "unit": "deg/s"},
                "specific_force": {"fields": ["fx", "fy", "fz"], "unit": "g"},
                "rotor_command": {"fields": "rpm*", "unit": "rpm"},
                "tilt_command": {"fields": "tilt*", "unit": "deg"},
                "battery": {"fields": "mv", "unit": "mV"},
            },
        }
    ],
}


def write_ned_csv(flight: Flight, path: Path) -> Path:
    """Body velocities (u, v, w), roll, pitch, yaw in degrees, forces in g, rotor speeds in rpm, times in ms."""
    swap = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    flip = np.array([1.0, -1.0, -1.0])
    q = flight.get("qw", "qx", "qy", "qz")
    half = np.sqrt(0.5)
    q_ned = rotations.multiply(rotations.multiply(np.array([0, half, half, 0]), q), np.array([0.0, 1.0, 0.0, 0.0]))
    euler = np.degrees(rotations.to_euler(q_ned))
    ned = flight.get("px", "py", "pz") @ swap.T * 1000.0
    body = rotations.to_body(q, flight.get("vx", "vy", "vz")) * flip
    rate = np.degrees(flight.get("wx", "wy", "wz")) * flip
    force = flight.get("ax", "ay", "az") * flip / 9.80665
    columns: dict[str, Any] = {"time_ms": flight.t * 1000.0}
    for names, values in (
        (("north", "east", "down"), ned),
        (("roll", "pitch", "yaw"), euler),
        (("u", "v", "w"), body),
        (("p", "q", "r"), rate),
        (("fx", "fy", "fz"), force),
    ):
        columns.update(dict(zip(names, values.T, strict=True)))
    for k, speed in enumerate(flight.numbered("cmd_rotor_").T):
        columns[f"rpm{k}"] = speed * 60.0 / (2.0 * np.pi)
    for k, angle in enumerate(flight.numbered("cmd_tilt_").T):
        columns[f"tilt{k}"] = np.degrees(angle)
    columns["mv"] = flight.table["battery"] * 1000.0
    pd.DataFrame(columns).to_csv(path, index=False, float_format="%.17g")
    return path
