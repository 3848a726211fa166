"""Flights with known conventions for the tests of `check`, and the ways to spoil them.

The two generators share no code with the checks: positions and Euler angles are sums of sines, accelerations their
analytic derivatives, angular velocities come from rotation matrices differenced at 0.1 ms.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation, Slerp

from infotraj.flight import Flight

G = 9.81
Q, W, V, A, P = (
    ["qw", "qx", "qy", "qz"],
    ["wx", "wy", "wz"],
    ["vx", "vy", "vz"],
    ["ax", "ay", "az"],
    ["px", "py", "pz"],
)
C_NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
D_FRD = np.diag([1.0, -1.0, -1.0])


def sines(rng, amplitude, low, high, terms=4):
    """Sums of sines of three components: value and second derivative as functions of t."""
    f = rng.uniform(low, high, (3, terms))
    phase = rng.uniform(0, 2 * np.pi, (3, terms))
    size = np.asarray(amplitude)[:, None] * rng.uniform(0.5, 1.0, (3, terms)) / np.sqrt(terms)
    w = 2 * np.pi * f

    def at(t, order=0):
        angle = w[..., None] * t + phase[..., None] + order * np.pi / 2
        return (size[..., None] * w[..., None] ** order * np.sin(angle)).sum(axis=1).T

    return at


def simulated(seed, kind="quadrotor", rate_hz=100.0, duration=20.0, noise=1.0):
    """A flight (all channels but commands are noisy): a quadrotor whose thrust bends with its path, or a vehicle that
    turns as it likes ("omav"). 2 s of rest on the ground before, 1 s of take-off ramp."""
    rng = np.random.default_rng([77, seed])
    t = np.arange(0, duration, 1 / rate_hz)
    path = sines(rng, (1.0, 1.0, 0.3), 0.08, 0.45) if kind == "quadrotor" else sines(rng, (0.3, 0.3, 0.2), 0.05, 0.4)
    turn = sines(rng, (0.0, 0.0, 0.8), 0.05, 0.3) if kind == "quadrotor" else sines(rng, (0.6, 0.6, 0.4), 0.05, 0.5)
    offset = np.array([0.0, 0.0, 1.5]) - path(np.array([2.0]))

    def ramp(t):
        s = np.clip((t - 2.0) / 2.0, 0, 1)
        return (s**4 * (35 - 84 * s + 70 * s**2 - 20 * s**3))[:, None]

    def position(t):
        return ramp(t) * (path(t) + offset) + (1 - ramp(t)) * np.array([0.0, 0.0, 0.1])

    def acceleration(t):
        h = 1e-3
        return (position(t + h) - 2 * position(t) + position(t - h)) / h**2

    def velocity(t):
        h = 1e-4
        return (position(t + h) - position(t - h)) / (2 * h)

    def attitude(t):
        angles = ramp(t) * turn(t)
        if kind != "quadrotor":
            return Rotation.from_euler("ZYX", angles[:, ::-1])
        # the thrust carries the weight, the acceleration and a drag of 0.15 m/s^2 a m/s: the specific force has parts
        # across the thrust, as a real quadrotor's has
        z = acceleration(t) + np.array([0.0, 0.0, G]) + 0.15 * velocity(t)
        z /= np.linalg.norm(z, axis=1, keepdims=True)
        heading = np.stack([np.cos(angles[:, 2]), np.sin(angles[:, 2]), np.zeros(len(t))], axis=1)
        y = np.cross(z, heading)
        y /= np.linalg.norm(y, axis=1, keepdims=True)
        return Rotation.from_matrix(np.stack([np.cross(y, z), y, z], axis=-1))

    d = 1e-4
    r = attitude(t)
    w = (attitude(t - d).inv() * attitude(t + d)).as_rotvec() / (2 * d)
    f = r.inv().apply(acceleration(t) + np.array([0.0, 0.0, G]))
    v = velocity(t)
    q = (r * Rotation.from_rotvec(noise * 0.002 * rng.standard_normal((len(t), 3)))).as_quat()
    q = q[:, [3, 0, 1, 2]]
    table = {"t": t}
    for names, values in (
        (P, position(t) + noise * 5e-4 * rng.standard_normal((len(t), 3))),
        (Q, q),
        (V, v + noise * 0.01 * rng.standard_normal((len(t), 3))),
        (W, w + noise * (0.02 * rng.standard_normal((len(t), 3)) + 0.01 * rng.standard_normal(3))),
        (A, f + noise * (0.3 * rng.standard_normal((len(t), 3)) + 0.05 * rng.standard_normal(3))),
    ):
        table.update(dict(zip(names, values.T, strict=True)))
    speed = np.sqrt(np.linalg.norm(f, axis=1)) * np.where(t < 1.9, 0.1, 1.0)
    for k in range(4):
        table[f"cmd_rotor_{k}"] = 200 * np.interp(t + 0.03, t, speed) + noise * rng.standard_normal(len(t))
    return Flight(pd.DataFrame(table), {"source": f"{kind} {seed}"})


def _rotation(flight):
    """The attitude in every row; between samples along the geodesic."""
    q = flight.get(*Q)[:, [1, 2, 3, 0]]
    good = np.isfinite(q).all(axis=1)
    known = flight.t[good]
    return Slerp(known, Rotation.from_quat(q[good]))(np.clip(flight.t, known[0], known[-1]))


def _with(flight, names, values):
    return Flight(flight.table.assign(**dict(zip(names, np.asarray(values).T, strict=True))), dict(flight.meta))


def _quaternion(rotation):
    return rotation.as_quat()[:, [3, 0, 1, 2]]


def _as_if_degrees(flight, factor):
    return _with(flight, Q, _quaternion(Rotation.from_euler("ZYX", factor * _rotation(flight).as_euler("ZYX"))))


def _ned(flight):
    r = Rotation.from_matrix(C_NED @ _rotation(flight).as_matrix() @ D_FRD)
    out = _with(flight, Q, _quaternion(r))
    for names, turn in ((P, C_NED), (V, C_NED), (W, D_FRD), (A, D_FRD)):
        if flight.has(*names):
            out = _with(out, names, flight.get(*names) @ turn.T)
    return out


def _shift(flight, names, late):
    columns = []
    for name in names:
        x = flight.get(name)[:, 0]
        good = np.isfinite(x)
        columns.append(np.interp(flight.t - late, flight.t[good], x[good]))
    x = np.stack(columns, axis=-1)
    return _with(flight, names, x)


def _columns(flight, names, change):
    return _with(flight, names, change(flight.get(*names).copy(), _rotation(flight)))


def _gravity_removed(a, r):
    return a - r.inv().apply(np.tile([0.0, 0.0, G], (len(a), 1)))


# name: (how a flight is spoiled, the codes any of which names the error rightly)
SPOILED: dict[str, tuple[Callable[[Flight], Flight], tuple[str, ...]]] = {
    "quaternion x y z w in the columns of w x y z": (
        lambda f: _with(f, Q, f.get("qx", "qy", "qz", "qw")),
        ("attitude_order",),
    ),
    "quaternion w x y z read as x y z w": (lambda f: _with(f, Q, f.get("qz", "qw", "qx", "qy")), ("attitude_order",)),
    "quaternion world to body": (lambda f: _with(f, Q, f.get(*Q) * [1, -1, -1, -1]), ("attitude_inverse",)),
    "degrees taken as radians": (lambda f: _as_if_degrees(f, 180 / np.pi), ("attitude_unit",)),
    "radians taken as degrees": (lambda f: _as_if_degrees(f, np.pi / 180), ("attitude_unit",)),
    "attitude NED/FRD, the rest ENU/FLU": (
        lambda f: _with(f, Q, _quaternion(Rotation.from_matrix(C_NED @ _rotation(f).as_matrix() @ D_FRD))),
        ("attitude_frame",),
    ),
    "rates in deg/s": (lambda f: _columns(f, W, lambda w, r: np.degrees(w)), ("rate_unit",)),
    "rates in the world frame": (lambda f: _columns(f, W, lambda w, r: r.apply(w)), ("rate_frame",)),
    "body rates turned as if of the world": (
        lambda f: _columns(f, W, lambda w, r: r.inv().apply(w)),
        ("rate_frame",),
    ),
    "rates in FRD": (lambda f: _columns(f, W, lambda w, r: w @ D_FRD), ("rate_axes",)),
    "velocity in the body frame": (lambda f: _columns(f, V, lambda v, r: r.inv().apply(v)), ("velocity_frame",)),
    "velocity in NED": (lambda f: _columns(f, V, lambda v, r: v @ C_NED.T), ("velocity_axes",)),
    "velocity in km/h": (lambda f: _columns(f, V, lambda v, r: 3.6 * v), ("velocity_unit",)),
    "position in mm": (lambda f: _columns(f, P, lambda p, r: 1000 * p), ("position_unit",)),
    "acceleration in g": (lambda f: _columns(f, A, lambda a, r: a / 9.80665), ("acceleration_unit",)),
    "acceleration without gravity": (lambda f: _columns(f, A, _gravity_removed), ("acceleration_without_gravity",)),
    "acceleration negated": (lambda f: _columns(f, A, lambda a, r: -a), ("acceleration_sign", "or acceleration_sign")),
    "acceleration in FRD": (lambda f: _columns(f, A, lambda a, r: a @ D_FRD), ("acceleration_axes",)),
    "all of it NED/FRD": (_ned, ("world_z_down",)),
    "IMU 60 ms late": (lambda f: _shift(f, W + A, 0.06), ("imu_clock_offset",)),
    "IMU 40 ms early": (lambda f: _shift(f, W + A, -0.04), ("imu_clock_offset",)),
    "time in milliseconds": (lambda f: Flight(f.table.assign(t=1000 * f.t), dict(f.meta)), ("time_unit",)),
}


def named(check):
    """The codes that a check reports as warnings or worse, and, as "or CODE", what it says fits as well."""
    found = [f for f in check.findings if f.severity != "note"]
    return {f.code for f in found} | {f"or {code}" for f in found for code in f.values.get("alternatives", ())}


def plant_flights(count=2):
    """Flights of the MuJoCo omav by its own controller: a figure of eight and a pitching task, for each plant."""
    from infotraj.experiment.config import ExperimentConfig
    from infotraj.experiment.flying import fly, plant
    from infotraj.trajectories.tasks import figure_eight, pitch_task
    from infotraj.vehicle import load_vehicle

    config = ExperimentConfig()
    vehicle = load_vehicle(config.vehicle)
    tasks = (figure_eight(np.radians(26), 9.0, 2, 0.01), pitch_task(np.radians(60), 1.0, 2, 0.01))
    for name in ("omav_a", "omav_b", "omav_c")[:count]:
        robot = plant(config, name)
        for k, task in enumerate(tasks):
            flight = fly(robot, vehicle, task, None, config, np.random.default_rng([5, k]))
            yield Flight(flight.table, {**flight.meta, "source": f"{name} task {k}"})
