"""An exact simulation of the catalogue, for time stamps and signs: shares no code with infotraj's effects and models.

Written from the specification of the catalogue and of the flight table alone, and integrated in steps of at most
`SUBSTEP`. This module makes the flight table and its noise; beside it stand what is simulated (`exact_truth`), its
physics (`exact_motion`, `exact_vectors`), path and controller (`exact_controller`), and time (`exact_integration`).

    table = fly(vehicle_file_content, {"com_offset": {"r": [0.01, 0, 0]}}, seconds=16.0, seed=1)
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from exact_controller import calmer, control_of, path_of
from exact_integration import simulate
from exact_truth import truth_of

SUBSTEP = 5e-4
ROW = 0.005


def _forget_older() -> None:
    """What numba keeps of a function outlives a change in another module that it calls: older than any is gone."""
    here = Path(__file__).parent
    newest = max(path.stat().st_mtime for path in here.glob("exact_*.py"))
    for kept in (here / "__pycache__").glob("exact_*.nbi"):
        if kept.stat().st_mtime < newest:
            kept.unlink(missing_ok=True)


_forget_older()


def fly(
    vehicle,
    effects,
    *,
    seconds=8.0,
    seed=0,
    noise=None,
    row=ROW,
    substep=SUBSTEP,
    share_commands=True,
    start=0.0,
    motion=1.0,
):
    """A flight table (pandas) of the vehicle with hidden `effects` {name: {parameter: value}} (or a list of pairs).

    noise: None, or standard deviations {"gyro", "accelerometer", "position", "attitude", "velocity"} a sample;
    motion: times the usual path.
    """
    pairs = list(effects.items()) if isinstance(effects, dict) else list(effects)
    by_name = {name: dict(values) for name, values in pairs}
    body, rotors, tilts, air, other = truth_of(vehicle, pairs)
    rng = np.random.default_rng(seed)
    rows = np.arange(round(seconds / row) + 1) * row
    imu_shift = by_name.get("time_offset", {}).get("dt", 0.0)
    out = simulate(
        rows,
        rows - imu_shift,
        substep,
        body,
        rotors,
        tilts,
        air,
        other,
        control_of(vehicle, share_commands),
        calmer(path_of(vehicle, rng), motion),
    )
    state, imu, cmd_rotor, cmd_tilt, rotor, tilt = out
    turn = _rotation(np.array(by_name.get("imu_misalignment", {}).get("rotvec", np.zeros(3)), dtype=float))
    bias = np.array(by_name.get("gyro_bias", {}).get("b", np.zeros(3)), dtype=float)
    force_bias = np.array(by_name.get("accelerometer_bias", {}).get("b", np.zeros(3)), dtype=float)
    columns = {"t": rows + start}
    _put(columns, ["px", "py", "pz"], state[:, 0:3])
    _put(columns, ["qw", "qx", "qy", "qz"], state[:, 3:7])
    _put(columns, ["vx", "vy", "vz"], state[:, 7:10])
    _put(columns, ["wx", "wy", "wz"], imu[:, 0:3] @ turn.T + bias)
    _put(columns, ["ax", "ay", "az"], imu[:, 3:6] @ turn.T + force_bias)
    _put(columns, [f"cmd_rotor_{i}" for i in range(cmd_rotor.shape[1])], cmd_rotor)
    _put(columns, [f"cmd_tilt_{i}" for i in range(cmd_tilt.shape[1])], cmd_tilt)
    _put(columns, [f"rotor_{i}" for i in range(cmd_rotor.shape[1])], rotor)
    _put(columns, [f"tilt_{i}" for i in range(cmd_tilt.shape[1])], tilt)
    if other.sag_exponent != 0.0:
        columns["battery"] = vehicle["nominal_voltage"] * (1.0 - other.volts_rate * rows)
    table = pd.DataFrame(columns)
    return table if noise is None else _noisy(table, noise, rng)


def _put(columns, names, values):
    for i, name in enumerate(names):
        columns[name] = values[:, i]


def _noisy(table, noise, rng):
    n = len(table)
    for names, key in (
        (["wx", "wy", "wz"], "gyro"),
        (["ax", "ay", "az"], "accelerometer"),
        (["px", "py", "pz"], "position"),
        (["vx", "vy", "vz"], "velocity"),
    ):
        table[names] += noise.get(key, 0.0) * rng.standard_normal((n, 3))
    q = table[["qw", "qx", "qy", "qz"]].to_numpy()
    e = 0.5 * noise.get("attitude", 0.0) * rng.standard_normal((n, 3))
    w, x, y, z = q.T
    step = np.stack([-x, -y, -z], 1), np.stack([w, -z, y], 1), np.stack([z, w, -x], 1), np.stack([-y, x, w], 1)
    q = q + np.stack([np.sum(s * e, axis=1) for s in step], axis=1)
    table[["qw", "qx", "qy", "qz"]] = q / np.linalg.norm(q, axis=1, keepdims=True)
    return table


def _rotation(v):
    angle = np.linalg.norm(v)
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    if angle == 0.0:
        return np.eye(3)
    return np.eye(3) + np.sin(angle) / angle * k + (1 - np.cos(angle)) / angle**2 * (k @ k)
