"""Motion capture and IMU: the true motion plus white noise, sampled at fixed rates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from infotraj.rotations import Array

IMU_PERIOD = 0.005  # s, 200 Hz
MOCAP_PERIOD = 0.010  # s, 100 Hz


@dataclass(frozen=True)
class Noise:
    """Standard deviations, each axis and sample: position m, attitude rad, rate rad/s, specific force m/s^2."""

    position: float = 1e-3
    attitude: float = float(np.radians(0.1))
    rate: float = 0.01
    specific_force: float = 0.1

    def imu(self, rng: np.random.Generator, samples: int) -> tuple[Array, Array]:
        """Noise of the gyro (rad/s) and the accelerometer (m/s^2), (samples, 3) each."""
        return (
            self.rate * rng.standard_normal((samples, 3)),
            self.specific_force * rng.standard_normal((samples, 3)),
        )

    def mocap(self, rng: np.random.Generator, samples: int) -> tuple[Array, Array]:
        """Noise of the position (m, world) and the attitude (rad, body), (samples, 3) each."""
        return (
            self.position * rng.standard_normal((samples, 3)),
            self.attitude * rng.standard_normal((samples, 3)),
        )


@njit(cache=True)
def turned(attitude, rotvec, out):
    """attitude (4,) times the rotation by `rotvec` (3,) rad in the body frame, normalised, into `out` (4,)."""
    angle = np.sqrt(rotvec[0] ** 2 + rotvec[1] ** 2 + rotvec[2] ** 2)
    c = np.cos(0.5 * angle)
    s = 0.5 if angle < 1e-9 else np.sin(0.5 * angle) / angle
    x, y, z = s * rotvec[0], s * rotvec[1], s * rotvec[2]
    w, a, b, d = attitude[0], attitude[1], attitude[2], attitude[3]
    q0 = w * c - a * x - b * y - d * z
    q1 = w * x + a * c + b * z - d * y
    q2 = w * y - a * z + b * c + d * x
    q3 = w * z + a * y - b * x + d * c
    scale = 1.0 / np.sqrt(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3)
    out[0], out[1], out[2], out[3] = q0 * scale, q1 * scale, q2 * scale, q3 * scale
