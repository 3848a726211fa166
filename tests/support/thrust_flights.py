"""Flights of a body that four thrusts drive, with its commands as thrusts, as a wrench and as rotor speeds."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pandas as pd

from infotraj.flight import COMMANDED_WRENCH, Flight
from infotraj.vehicle import parse_vehicle

ROW, SUBSTEPS = 0.005, 4

ARM, KAPPA, MASS = 0.1, 0.012, 0.9

INERTIA = np.array([[6e-3, 2e-4, -1e-4], [2e-4, 7e-3, 3e-4], [-1e-4, 3e-4, 1.1e-2]])

PLACES = ARM * np.array([[1, -1, 0.1], [-1, -1, 0.1], [-1, 1, 0.1], [1, 1, 0.1]])

SPINS = (1, -1, 1, -1)

BODY = {
    "mass": MASS,
    "inertia": {"xx": 6e-3, "yy": 7e-3, "zz": 1.1e-2, "xy": 2e-4, "xz": -1e-4, "yz": 3e-4},
}


def with_thrusts(lag=0.0, **keys):
    rotors = [
        {
            "name": f"r{i}",
            "position": PLACES[i].tolist(),
            "spin": SPINS[i],
            "input": "thrust",
            "moment_constant": KAPPA,
            "time_constant": lag,
            **keys,
        }
        for i in range(4)
    ]
    return parse_vehicle({"name": "by_thrust", **BODY, "rotors": rotors})


def with_wrench(**keys):
    return parse_vehicle({"name": "by_wrench", **BODY, "inputs": "wrench", **keys})


def wrench_of(thrust):
    """Force and torque (.., 6) of four thrusts along body z, written out."""
    x, y = PLACES[:, 0], PLACES[:, 1]
    out = np.zeros((*thrust.shape[:-1], 6))
    out[..., 2] = thrust.sum(axis=-1)
    out[..., 3] = thrust @ y
    out[..., 4] = -thrust @ x
    out[..., 5] = -(thrust @ np.array(SPINS)) * KAPPA
    return out


@lru_cache
def fly(lag=0.0, factor=1.0, noise=0.0, drag=0.0, seconds=8.0, seed=0, yaw=1.0):
    """A rigid body in space, driven by four thrusts that follow their commands with a lag; Runge-Kutta, 4th order.

    A controller keeps it about hover and turns it about all axes. factor: of all thrusts; yaw: of the reaction torques;
    drag (N s/m): at the origin. The flight with thrust commands, and the same with the wrench that was commanded.
    """
    rng = np.random.default_rng(seed)
    n = round(seconds / ROW)
    mixer = np.linalg.inv(wrench_of(np.eye(4))[:, 2:].T)
    inverse, h = np.linalg.inv(INERTIA), ROW / SUBSTEPS
    pace, start = rng.uniform(1.0, 4.0, (3, 3)), rng.uniform(-3, 3, (3, 3))
    p, v, q, w = np.array([0.0, 0.0, 5.0]), np.zeros(3), np.array([1.0, 0, 0, 0]), np.zeros(3)
    thrust = np.full(4, MASS * 9.81 / 4)
    rows: dict[str, list] = {k: [] for k in ("p", "v", "q", "w", "a", "u")}

    def matrix(q):
        s, x, y, z = q / np.linalg.norm(q)
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - s * z), 2 * (x * z + s * y)],
                [2 * (x * y + s * z), 1 - 2 * (x * x + z * z), 2 * (y * z - s * x)],
                [2 * (x * z - s * y), 2 * (y * z + s * x), 1 - 2 * (x * x + y * y)],
            ]
        )

    def specific(q, v, thrust):
        return (factor * wrench_of(thrust)[:3] - drag * matrix(q).T @ v) / MASS

    def followed(command, thrust, time):
        """Thrusts some time after a command, exact for a first-order lag."""
        return command + (thrust - command) * (np.exp(-time / lag) if lag > 0 else 0.0)

    def slope(v, q, w, thrust):
        torque = factor * wrench_of(thrust)[3:] * [1.0, 1.0, yaw]
        s, x = q[0], q[1:]
        turn = 0.5 * np.concatenate([[-x @ w], s * w + np.cross(x, w)])
        return matrix(q) @ specific(q, v, thrust) - [0, 0, 9.81], turn, inverse @ (torque - np.cross(w, INERTIA @ w))

    for k in range(n):
        t = k * ROW
        wanted = 0.25 * np.sin(pace * t + start).sum(axis=1)
        level = np.cross(matrix(q).T @ [0.0, 0.0, 1.0], [0.0, 0.0, 1.0])
        torque = np.diag(INERTIA) * (80.0 * ([*wanted[:2], 0.0] - level) - 14.0 * (w - [0, 0, wanted[2]]))
        lift = MASS * (9.81 + 1.5 * np.sin(2.3 * t) + 1.0 * (5.0 - p[2]) - 1.5 * v[2])
        u = mixer @ [lift, *torque]
        now = u if lag == 0.0 and k == 0 else thrust
        for key, x in zip("pvqwau", (p, v, q, w, specific(q, v, now), u), strict=True):
            rows[key].append(x.copy())
        for i in range(SUBSTEPS):
            stages = [(0.0, None), (0.5, 0), (0.5, 1), (1.0, 2)]
            k_: list[tuple] = []
            for part, before in stages:
                d = (np.zeros(3), np.zeros(3), np.zeros(4), np.zeros(3)) if before is None else k_[before]
                x = [y + part * h * dy for y, dy in zip((p, v, q, w), d, strict=True)]
                dv, dq, dw = slope(x[1], x[2], x[3], followed(u, thrust, (i + part) * h))
                k_.append((x[1], dv, dq, dw))
            p, v, q, w = (y + h / 6 * (a + 2 * b + 2 * c + d) for y, a, b, c, d in zip((p, v, q, w), *k_, strict=True))
            q = q / np.linalg.norm(q)
        thrust = followed(u, thrust, ROW)
    out = {k: np.array(x) for k, x in rows.items()}
    table = pd.DataFrame({"t": np.arange(n) * ROW})
    names = {"p": "px py pz", "v": "vx vy vz", "q": "qw qx qy qz", "w": "wx wy wz", "a": "ax ay az"}
    sizes = {"p": 1e-4, "v": 1e-3, "q": 0.0, "w": 2e-3, "a": 2e-2}
    for key, columns in names.items():
        table[columns.split()] = out[key] + noise * sizes[key] * rng.standard_normal(out[key].shape)
    by_thrust = table.assign(**{f"cmd_rotor_{i}": out["u"][:, i] for i in range(4)})
    by_wrench = table.assign(**dict(zip(COMMANDED_WRENCH, wrench_of(out["u"]).T, strict=True)))
    return Flight(by_thrust, {"source": "by_thrust"}), Flight(by_wrench, {"source": "by_wrench"})


def errors(model, flight):
    """Greatest errors of the specific force at the rows and of the mean angular acceleration after half a second."""
    made = model.predict(flight)
    rows = flight.t > 0.5
    rows[-1] = False
    slope = np.diff(flight.get("wx", "wy", "wz"), axis=0) / np.diff(flight.t)[:, None]
    return (
        np.abs(made.specific_force - flight.get("ax", "ay", "az"))[rows].max(),
        np.abs(made.angular_acceleration_mean[:-1] - slope)[rows[:-1]].max(),
    )


def without(flight, *columns):
    return Flight(flight.table.drop(columns=list(columns)), dict(flight.meta))


SQUARES = {"thrust_coefficient": 2e-6, "input": "speed"}


def by_speed(flight):
    """The same flight with its thrusts as speeds of rotors, and the vehicle that takes these."""
    speeds = np.sqrt(np.maximum(flight.numbered("cmd_rotor_"), 0.0) / 2e-6)
    columns = {f"cmd_rotor_{i}": speeds[:, i] for i in range(4)} | {f"rotor_{i}": speeds[:, i] for i in range(4)}
    return Flight(flight.table.assign(**columns), dict(flight.meta)), with_thrusts(**SQUARES)


def signed(flight):
    """Rotors 1 and 3, which turn clockwise, have negative speeds: commanded and measured."""
    columns = {f"{p}rotor_{i}": -flight.get(f"{p}rotor_{i}")[:, 0] for p in ("cmd_", "") for i in (1, 3)}
    return Flight(flight.table.assign(**columns), dict(flight.meta))
