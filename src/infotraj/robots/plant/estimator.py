"""The state estimator: an error-state observer that integrates the IMU and is corrected by delayed motion capture.

Between poses the IMU is integrated (trapezoid, 200 Hz). A pose arrives `delay` after it was taken; it is compared with
the estimate of that time, and the error times fixed gains corrects position, velocity and attitude, now and in the
stored past. The gains are the steady Kalman gains of the sensors' noise (J. Sola, "Quaternion kinematics for the
error-state Kalman filter", 2017, section 6; steady state by the Riccati equation), process noise raised by `margin`.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy.linalg import solve_discrete_are

from infotraj.robots.plant.sensors import IMU_PERIOD, MOCAP_PERIOD, Noise, turned
from infotraj.robots.robot import Estimate
from infotraj.rotations import Array


class Estimator:
    """Position, attitude, velocity and rate from IMU samples at 200 Hz and poses at 100 Hz.

    delay: s from a pose's sampling to its use, a multiple of the IMU's period.
    """

    def __init__(self, noise: Noise, gravity: float, delay: float = 0.010, margin: float = 2.0) -> None:
        self.delay = delay
        self.delay_rows = round(delay / IMU_PERIOD)
        self.gains = steady_gains(noise, margin)
        self._gravity = gravity
        self._pose = np.zeros(7)  # position, attitude
        self._velocity = np.zeros(3)
        self._last = np.zeros(6)  # gyro, specific force
        self._rate = np.zeros(3)
        self._past = np.zeros((self.delay_rows + 1, 7))  # poses of this row and the rows before it

    @property
    def description(self) -> str:
        """One line for the flight's metadata."""
        p, v, a = self.gains
        return (
            f"error-state observer: IMU integrated at {1 / IMU_PERIOD:.0f} Hz, motion capture at "
            f"{1 / MOCAP_PERIOD:.0f} Hz used {1e3 * self.delay:.0f} ms after its sampling; gains position {p:.4f}, "
            f"velocity {v:.3f} 1/s, attitude {a:.4f}; rate: mean of the last two gyro samples "
            f"({0.5e3 * IMU_PERIOD:.1f} ms)"
        )

    def start(self, position: Array, attitude: Array) -> None:
        """Begins at rest at a measured pose."""
        self._pose[:3], self._pose[3:] = position, attitude
        self._velocity[:], self._last[:], self._rate[:] = 0.0, 0.0, 0.0
        self._past[:] = self._pose
        self._fresh = True

    def integrate(self, gyro: Array, specific_force: Array) -> None:
        """Goes on by one IMU sample (3,) rad/s and (3,) m/s^2, taken one IMU period after the last."""
        if self._fresh:
            self._last[:3], self._last[3:] = gyro, specific_force
            self._rate[:] = gyro
            self._fresh = False
            return
        _integrate(self._pose, self._velocity, self._last, self._rate, self._past, gyro, specific_force, self._gravity)

    def correct(self, position: Array, attitude: Array) -> None:
        """Uses a pose that was taken `delay` before the last IMU sample."""
        _correct(self._pose, self._velocity, self._past, position, attitude, self.gains, self.delay)

    def estimate(self) -> Estimate:
        """The state at the last IMU sample."""
        return Estimate(self._pose[:3].copy(), self._pose[3:].copy(), self._velocity.copy(), self._rate.copy())


def steady_gains(noise: Noise, margin: float) -> Array:
    """Gains of position, velocity (1/s) and attitude on the pose error, (3,)."""
    T, steps = MOCAP_PERIOD, MOCAP_PERIOD / IMU_PERIOD
    velocity_step = (margin * noise.specific_force * IMU_PERIOD) ** 2 * steps
    angle_step = (margin * noise.rate * IMU_PERIOD) ** 2 * steps
    F, H = np.array([[1.0, T], [0.0, 1.0]]), np.array([[1.0, 0.0]])
    Q = velocity_step * np.array([[T * T / 3.0, T / 2.0], [T / 2.0, 1.0]])
    gains = []
    for transition, observed, process, variance in (
        (F, H, Q, noise.position**2),
        (np.eye(1), np.eye(1), np.array([[angle_step]]), noise.attitude**2),
    ):
        if variance == 0.0:
            gains += [1.0, 1.0 / T][: len(transition)]
            continue
        P = solve_discrete_are(transition.T, observed.T, process, np.array([[variance]]))
        gains += list((P @ observed.T / (observed @ P @ observed.T + variance)).ravel())
    return np.array(gains)


@njit(cache=True)
def _to_world(q, v, out):
    w, x, y, z = q[0], q[1], q[2], q[3]
    out[0] = (1 - 2 * (y * y + z * z)) * v[0] + 2 * (x * y - w * z) * v[1] + 2 * (x * z + w * y) * v[2]
    out[1] = 2 * (x * y + w * z) * v[0] + (1 - 2 * (x * x + z * z)) * v[1] + 2 * (y * z - w * x) * v[2]
    out[2] = 2 * (x * z - w * y) * v[0] + 2 * (y * z + w * x) * v[1] + (1 - 2 * (x * x + y * y)) * v[2]


@njit(cache=True)
def _integrate(pose, velocity, last, rate, past, gyro, specific_force, gravity):
    dt = IMU_PERIOD
    before, after, mean = np.empty(3), np.empty(3), np.empty(3)
    _to_world(pose[3:], last[3:], before)
    for c in range(3):
        mean[c] = 0.5 * dt * (last[c] + gyro[c])
        rate[c] = 0.5 * (last[c] + gyro[c])
    turned(pose[3:], mean, pose[3:])
    _to_world(pose[3:], specific_force, after)
    for c in range(3):
        acceleration = 0.5 * (before[c] + after[c]) - (gravity if c == 2 else 0.0)
        pose[c] += dt * (velocity[c] + 0.5 * dt * acceleration)
        velocity[c] += dt * acceleration
        last[c], last[3 + c] = gyro[c], specific_force[c]
    for i in range(past.shape[0] - 1, 0, -1):
        past[i] = past[i - 1]
    past[0] = pose


@njit(cache=True)
def _correct(pose, velocity, past, position, attitude, gains, delay):
    old = past[past.shape[0] - 1]
    w, x, y, z = old[3], -old[4], -old[5], -old[6]
    a, b, c, d = attitude[0], attitude[1], attitude[2], attitude[3]
    e0 = w * a - x * b - y * c - z * d
    sign = 2.0 if e0 >= 0.0 else -2.0
    turn = np.empty(3)
    turn[0] = gains[2] * sign * (w * b + x * a + y * d - z * c)
    turn[1] = gains[2] * sign * (w * c - x * d + y * a + z * b)
    turn[2] = gains[2] * sign * (w * d + x * c - y * b + z * a)
    shift, kick = np.empty(3), np.empty(3)
    for i in range(3):
        error = position[i] - old[i]
        shift[i], kick[i] = gains[0] * error, gains[1] * error
    for k in range(past.shape[0]):
        age = delay * k / max(past.shape[0] - 1, 1)
        for i in range(3):
            past[k, i] += shift[i] + (delay - age) * kick[i]
        turned(past[k, 3:], turn, past[k, 3:])
    for i in range(3):
        velocity[i] += kick[i]
        pose[i] = past[0, i]
    pose[3:] = past[0, 3:]
