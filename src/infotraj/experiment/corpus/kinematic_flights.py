"""Flights with known conventions that no vehicle flew: smooth paths and angles, differentiated.

They share no code with the checks: positions and Euler angles are sums of sines, accelerations their differences at
1 ms, angular velocities come from rotation matrices differenced at 0.1 ms.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight

G = 9.81


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
        (POSITION, position(t) + noise * 5e-4 * rng.standard_normal((len(t), 3))),
        (ATTITUDE, q),
        (VELOCITY, v + noise * 0.01 * rng.standard_normal((len(t), 3))),
        (RATE, w + noise * (0.02 * rng.standard_normal((len(t), 3)) + 0.01 * rng.standard_normal(3))),
        (SPECIFIC_FORCE, f + noise * (0.3 * rng.standard_normal((len(t), 3)) + 0.05 * rng.standard_normal(3))),
    ):
        table.update(dict(zip(names, values.T, strict=True)))
    speed = np.sqrt(np.linalg.norm(f, axis=1)) * np.where(t < 1.9, 0.1, 1.0)
    for k in range(4):
        table[f"cmd_rotor_{k}"] = 200 * np.interp(t + 0.03, t, speed) + noise * rng.standard_normal(len(t))
    return Flight(pd.DataFrame(table), {"source": f"{kind} {seed}"})
