"""Deviations that turn a task into candidate references (eq. 16, 17).

The paper samples a sum of P = 2 complex exponentials an axis on the angular acceleration, frequencies included:
"12 coefficients". We read them as an amplitude and a frequency for each of 3 axes x 2 terms, the phase being that
of a sine, so that a deviation starts from the task. A sine of amplitude c on the acceleration is one of amplitude
c / (2 pi f)^2 on the angle: that is what is added to the task's attitude, faded in and out over the ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj import rotations
from infotraj.dynamics.allocation import Allocation
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference, from_poses

FADE = 2.0  # s


@dataclass(frozen=True)
class Deviation:
    """Coefficients of eq. 17: amplitude (3, P) rad/s^2 and frequency (3, P) Hz, axes x, y, z of the body."""

    amplitude: Array
    frequency: Array

    def angle(self, t: Array) -> Array:
        """Deviation of the attitude as a rotation vector (rad), (n, 3), for times t (n,) s from the start."""
        w = 2 * np.pi * self.frequency
        waves = np.sin(w[None] * (t - t[0])[:, None, None])
        s = np.clip(np.minimum(t - t[0], t[-1] - t) / FADE, 0.0, 1.0)
        fade = s**3 * (10 - 15 * s + 6 * s * s)
        return -fade[:, None] * np.sum(self.amplitude / w**2 * waves, axis=-1)

    def scaled(self, factor: float) -> Deviation:
        """The same frequencies with all amplitudes times `factor`."""
        return Deviation(factor * self.amplitude, self.frequency)


@dataclass(frozen=True)
class DeviationSpace:
    """The set O_x of eq. 18: what deviations may be sampled. Units: rad/s^2, Hz, rad, rad/s^3; `terms` is P.

    The jerk matters because the residual is learned as a function of the command alone: what the actuators do
    dynamically, beyond their declared lags, is noise to it, and that noise grows with the rate of the torque.
    """

    max_acceleration: float
    min_frequency: float
    max_frequency: float
    max_angle: float
    terms: int = 2
    max_jerk: float = np.inf

    def sample(self, rng: np.random.Generator) -> Deviation:
        """One deviation, uniform in frequency and in amplitude up to what acceleration, angle and jerk allow a term."""
        shape = (3, self.terms)
        frequency = rng.uniform(self.min_frequency, self.max_frequency, shape)
        w = 2 * np.pi * frequency
        limit = np.minimum(self.max_acceleration, np.minimum(self.max_angle * w**2, self.max_jerk / w) / self.terms)
        return Deviation(rng.uniform(-1.0, 1.0, shape) * limit, frequency)


def deviate(task: Reference, deviation: Deviation) -> Reference:
    """The candidate reference: the task's attitude turned by the deviation in body axes (eq. 16)."""
    attitude = rotations.multiply(task.attitude, rotations.exp(deviation.angle(task.t)))
    return from_poses(task.t, task.position, attitude)


def demand(reference: Reference, allocation: Allocation) -> tuple[float, float]:
    """Share of the top rotor speed, and of the top tilt rate, that flying `reference` exactly would ask for.

    The wrench is that of the first-principles model; both results are maxima over the flight, scalars.
    """
    vehicle = allocation.vehicle
    weight = rotations.to_body(reference.attitude, reference.acceleration + np.array([0.0, 0.0, vehicle.gravity]))
    inertia = vehicle.inertia_matrix()
    torque = reference.angular_acceleration @ inertia + np.cross(reference.rate, reference.rate @ inertia)
    speed, tilt = allocation.actuators(np.concatenate([vehicle.known_mass() * weight, torque], axis=1))
    top = np.array([r.max_speed or np.inf for r in vehicle.rotors])
    rate_limit = np.array([t.max_rate for t in vehicle.tilts])
    turn = np.diff(np.unwrap(tilt, axis=0), axis=0) / reference.dt
    share = float(np.max(np.abs(turn) / rate_limit)) if len(vehicle.tilts) else 0.0
    return float(np.max(speed / top)), share


def within_limits(
    task: Reference, deviation: Deviation, allocation: Allocation, speed_share: float = 0.9, rate_share: float = 0.6
) -> Deviation:
    """The deviation, shrunk in steps of 10 % until the candidate stays within these shares of the limits.

    The margins leave room for feedback: 10 % of the rotor speed, 40 % of the tilt rate.
    """
    while True:
        speed, rate = demand(deviate(task, deviation), allocation)
        if (speed <= speed_share and rate <= rate_share) or np.max(np.abs(deviation.amplitude)) < 1e-6:
            return deviation
        deviation = deviation.scaled(0.9)
