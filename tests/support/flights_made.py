"""A made flight for the import tests: smooth pose, exact velocity and rate, commands, battery; any length and rate."""

from __future__ import annotations

import numpy as np
import pandas as pd

from infotraj import rotations
from infotraj.flight import Flight


def made_flight(seconds: float = 4.0, rate_hz: float = 100.0, rotors: int = 4, tilts: int = 2) -> Flight:
    """Figure-eight with rolling and yawing; columns for every channel of the flight table; t in whole microseconds."""
    t = np.round(np.arange(int(seconds * rate_hz)) / rate_hz, 6)
    position = np.stack([np.sin(t), 0.5 * np.sin(2 * t), 1.0 + 0.2 * np.cos(0.5 * t)], axis=-1)
    velocity = np.stack([np.cos(t), np.cos(2 * t), -0.1 * np.sin(0.5 * t)], axis=-1)
    q = rotations.from_euler(0.3 * np.sin(1.3 * t), 0.2 * np.cos(0.7 * t), 0.4 * t - 1.0)
    later = rotations.from_euler(0.3 * np.sin(1.3 * (t + 1e-6)), 0.2 * np.cos(0.7 * (t + 1e-6)), 0.4 * (t + 1e-6) - 1.0)
    rate = rotations.log(rotations.multiply(rotations.conjugate(q), later)) / 1e-6
    acceleration = np.stack([-np.sin(t), -2.0 * np.sin(2 * t), -0.05 * np.cos(0.5 * t)], axis=-1)
    force = rotations.to_body(q, acceleration + np.array([0.0, 0.0, 9.81]))
    columns = {"t": t}
    for names, values in (
        (("px", "py", "pz"), position),
        (("qw", "qx", "qy", "qz"), q),
        (("vx", "vy", "vz"), velocity),
        (("wx", "wy", "wz"), rate),
        (("ax", "ay", "az"), force),
    ):
        columns.update(dict(zip(names, values.T, strict=True)))
    for k in range(rotors):
        columns[f"cmd_rotor_{k}"] = 600.0 + 50.0 * np.sin((k + 1) * t)
    for k in range(tilts):
        columns[f"cmd_tilt_{k}"] = 0.1 * np.cos((k + 1) * t)
    columns["battery"] = 16.0 - 0.05 * t
    return Flight(pd.DataFrame(columns), {"source": "made"})
