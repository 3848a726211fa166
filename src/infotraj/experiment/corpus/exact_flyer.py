"""A multirotor with fixed rotors flies a path, exactly: the truth behind the corpus that `check` is measured on.

A rigid body with first-order rotors, drag of rotors and body, wind and a springy ground, by Runge-Kutta's fourth order
in steps of 1 ms; a cascade of position, attitude and rate control at 500 Hz acts on a noisy gyro, as autopilots do.
It shares no code with the checks and the models.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd
from numba import njit

from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

STEP = 1e-3
_CONTROL_EVERY = 2  # steps: 500 Hz
_GYRO_NOISE = 0.02  # rad/s, white at 500 Hz: what keeps the commands of real vehicles restless


class _Body(NamedTuple):
    mass: float
    inertia: Array
    gravity: float
    wrench_per_thrust: Array
    mixer: Array
    coefficient: Array
    time_constant: Array
    top_speed: Array
    rotor_drag: float
    body_drag: float
    attitude_gain: float
    ground: float


@dataclass(frozen=True)
class Air:
    """What the air does. rotor_drag: deceleration a speed across the rotors at hover (1/s; 0.1 to 0.5 in Faessler et
    al., RA-L 2018); body_drag: deceleration a squared speed (1/m); wind: (n, 3) world, m/s, a row a step."""

    rotor_drag: float
    body_drag: float
    wind: Array


def fly_exactly(
    vehicle: Vehicle, path: Array, yaw: Array, air: Air, rate_hz: float, rng: np.random.Generator
) -> Flight:
    """The flight table of a vehicle that follows `path` (n, 3; m) and `yaw` (n,; rad), a row a STEP, without noise.

    Rows at rate_hz, which divides 1 kHz: pose, velocity, rate, specific force, commanded and true rotor speeds. The
    path starts on the ground, whose height is that of its first row. The commands before the path rises are idle.
    """
    velocity = np.gradient(path, STEP, axis=0)
    acceleration = np.gradient(velocity, STEP, axis=0)
    body = _body(vehicle, air, float(path[0, 2]))
    gyro = _GYRO_NOISE * rng.standard_normal((len(path), 3))
    every = round(1.0 / (rate_hz * STEP))
    wind = np.ascontiguousarray(air.wind)
    states, commands = _simulate(body, path, velocity, acceleration, yaw, wind, gyro, every)
    count = len(body.coefficient)
    columns: dict[str, Array] = {"t": np.arange(len(states), dtype=float) * every * STEP}
    for names, first in ((POSITION, 0), (ATTITUDE, 3), (VELOCITY, 7), (RATE, 10), (SPECIFIC_FORCE, 13)):
        columns.update({name: states[:, first + i] for i, name in enumerate(names)})
    columns.update({f"cmd_rotor_{i}": commands[:, i] for i in range(count)})
    columns.update({f"rotor_{i}": states[:, 16 + i] for i in range(count)})
    return Flight(pd.DataFrame(columns), {"vehicle": vehicle.name})


def _body(vehicle: Vehicle, air: Air, ground: float) -> _Body:
    mass, rotors = float(vehicle.mass or 1.0), vehicle.rotors
    columns = []
    for rotor in rotors:
        axis = np.array(rotor.axis)
        torque = np.cross(rotor.position, axis) - rotor.spin * rotor.moment_constant * axis
        columns.append(np.concatenate([axis, torque]))
    per_thrust = np.array(columns).T
    coefficient = np.array([rotor.thrust_coefficient for rotor in rotors], dtype=float)
    lag = np.array([max(rotor.time_constant, 1e-3) for rotor in rotors])
    hover = float(np.sqrt(mass * vehicle.gravity / coefficient.sum()))
    return _Body(
        mass,
        np.ascontiguousarray(np.diag(vehicle.inertia_matrix())),
        vehicle.gravity,
        np.ascontiguousarray(per_thrust),
        np.ascontiguousarray(np.linalg.pinv(per_thrust[2:])),
        coefficient,
        lag,
        np.array([rotor.max_speed for rotor in rotors], dtype=float),
        air.rotor_drag * mass / (hover * len(rotors)),
        air.body_drag * mass,
        # the attitude loop stays below the rotors' own bandwidth
        min(20.0, 0.35 / float(lag.max())),
        ground,
    )


@njit(cache=True)
def _matrix(q):
    w, x, y, z = q[0], q[1], q[2], q[3]
    r = np.empty((3, 3))
    r[0, 0], r[0, 1], r[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    r[1, 0], r[1, 1], r[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    r[2, 0], r[2, 1], r[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    return r


@njit(cache=True)
def _cross(a, b):
    out = np.empty(3)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] = a[j] * b[k] - a[k] * b[j]
    return out


@njit(cache=True)
def _derivative(x, command, wind, body):
    """Rate of the state (position, quaternion, velocity, rate, rotor speeds), and the specific force in body axes."""
    n = len(body.coefficient)
    d = np.zeros(13 + n)
    r = _matrix(x[3:7])
    q, w = x[3:7], x[10:13]
    air = np.zeros(3)
    for i in range(3):
        for j in range(3):
            air[i] += r[j, i] * (x[7 + j] - wind[j])
    force, torque, spinning = np.zeros(3), np.zeros(3), 0.0
    for k in range(n):
        speed = x[13 + k]
        thrust = body.coefficient[k] * speed * speed
        spinning += speed
        for i in range(3):
            force[i] += body.wrench_per_thrust[i, k] * thrust
            torque[i] += body.wrench_per_thrust[3 + i, k] * thrust
        d[13 + k] = (command[k] - speed) / body.time_constant[k]
    size = np.sqrt(air[0] ** 2 + air[1] ** 2 + air[2] ** 2)
    for i in range(3):
        force[i] -= body.body_drag * size * air[i]
        if i < 2:
            force[i] -= body.rotor_drag * spinning * air[i]
    # the ground: legs that push and never pull, level the vehicle and stop it
    sunk = body.ground - x[2]
    if sunk > 0.0:
        push = body.mass * max(0.0, 4000.0 * sunk - 90.0 * x[9])
        for i in range(3):
            force[i] += r[2, i] * push
            slip = 0.0
            for j in range(2):
                slip += r[j, i] * x[7 + j]
            force[i] -= 20.0 * body.mass * slip
        tilted = np.array([r[2, 1], -r[2, 0], 0.0])
        for i in range(3):
            torque[i] -= body.inertia[i] * (900.0 * tilted[i] + 40.0 * w[i])
    momentum = np.empty(3)
    for i in range(3):
        momentum[i] = body.inertia[i] * w[i]
    gyroscopic = _cross(w, momentum)
    d[3] = 0.5 * (-q[1] * w[0] - q[2] * w[1] - q[3] * w[2])
    d[4] = 0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1])
    d[5] = 0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2])
    d[6] = 0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0])
    for i in range(3):
        d[i] = x[7 + i]
        for j in range(3):
            d[7 + i] += r[i, j] * force[j] / body.mass
        d[10 + i] = (torque[i] - gyroscopic[i]) / body.inertia[i]
    d[9] -= body.gravity
    return d, force / body.mass


@njit(cache=True)
def _control(x, gyro, place, velocity, acceleration, yaw, body):
    """Rotor speeds of a cascade: position and velocity, direction of thrust, attitude and rate; the path fed ahead."""
    n = len(body.coefficient)
    ask = np.empty(3)
    for i in range(3):
        ask[i] = acceleration[i] + 4.0 * (place[i] - x[i]) + 3.5 * (velocity[i] - x[7 + i])
        ask[i] = min(max(ask[i], -9.0), 9.0)
    ask[2] = max(ask[2] + body.gravity, 0.2 * body.gravity)
    size = np.sqrt(ask[0] ** 2 + ask[1] ** 2 + ask[2] ** 2)
    up = ask / size
    side = _cross(up, np.array([np.cos(yaw), np.sin(yaw), 0.0]))
    side = side / np.sqrt(side[0] ** 2 + side[1] ** 2 + side[2] ** 2)
    goal = np.empty((3, 3))
    goal[:, 0], goal[:, 1], goal[:, 2] = _cross(side, up), side, up
    r = _matrix(x[3:7])
    along = ask[0] * r[0, 2] + ask[1] * r[1, 2] + ask[2] * r[2, 2]
    wrench = np.empty(4)
    wrench[0] = body.mass * along
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        error = 0.0
        for a in range(3):
            error += 0.5 * (r[a, j] * goal[a, k] - r[a, k] * goal[a, j])
        gain = body.attitude_gain if i < 2 else 0.4 * body.attitude_gain
        turn = -gain * gain * error - 1.6 * gain * (x[10 + i] + gyro[i])
        wrench[1 + i] = body.inertia[i] * turn
    out = np.empty(n)
    for k in range(n):
        thrust = 0.0
        for i in range(4):
            thrust += body.mixer[k, i] * wrench[i]
        top = body.top_speed[k]
        out[k] = min(max(np.sqrt(max(thrust, 0.0) / body.coefficient[k]), 0.08 * top), top)
    return out


@njit(cache=True)
def _simulate(body, path, velocity, acceleration, yaw, wind, gyro, every):
    count, n = len(path), len(body.coefficient)
    rows = (count + every - 1) // every
    states, commands = np.empty((rows, 16 + n)), np.empty((rows, n))
    x = np.zeros(13 + n)
    x[0:3] = path[0]
    x[3], x[6] = np.cos(0.5 * yaw[0]), np.sin(0.5 * yaw[0])
    x[2] -= body.gravity / 4000.0
    command = 0.08 * body.top_speed
    x[13:] = command
    h = 1e-3
    for k in range(count):
        if k % _CONTROL_EVERY == 0:
            # idle until the path rises, and again once it is back on the ground
            if path[k, 2] > body.ground + 1e-6 or x[2] > body.ground + 0.05:
                command = _control(x, gyro[k], path[k], velocity[k], acceleration[k], yaw[k], body)
            else:
                command = 0.08 * body.top_speed
        k1, force = _derivative(x, command, wind[k], body)
        if k % every == 0:
            row = k // every
            states[row, 0:13], states[row, 13:16], states[row, 16:] = x[0:13], force, x[13:]
            commands[row] = command
        k2, _ = _derivative(x + 0.5 * h * k1, command, wind[k], body)
        k3, _ = _derivative(x + 0.5 * h * k2, command, wind[k], body)
        k4, _ = _derivative(x + h * k3, command, wind[k], body)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        x[3:7] /= np.sqrt(np.sum(x[3:7] ** 2))
    return states, commands
