"""Lateral specific force of a multirotor from motion capture, and the inputs that should explain it.

A multirotor whose rotors all point along body z pushes along body z alone; what acts on it sideways, in body x and y,
is drag and interference, and an accelerometer or the motion capture sees it as lateral specific force. Its usual
first-order model is linear in the body velocity, with a coefficient that grows with the rotor speeds (Faessler,
Franchi, Scaramuzza, "Differential flatness of quadrotor dynamics subject to rotor drag", 2018), hence the inputs here:
the velocity in the body frame and the collective thrust.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import medfilt, savgol_filter

from infotraj import flight, rotations
from infotraj.errors import InputError, problem
from infotraj.flight import Flight
from infotraj.rotations import Array

GRAVITY = 9.81
STEP = 0.01  # s, the grid on which the filter's 31 samples are counted
FILTER_SAMPLES, FILTER_ORDER = 31, 3
BATTERY_SAMPLES = 51  # 0.5 s: five messages of the voltage, of which two may be spikes
LOWEST, LEAST_THROTTLE, MARGIN = 0.4, 0.15, 1.5  # m; share of full scale; s


@dataclass(frozen=True)
class LateralForce:
    """The rows of one flight that count.

    t (n,) s; velocity (n, 3) m/s, body; thrust (n,) V^2, sum over the rotors of (throttle times battery voltage)^2,
    to which the thrust is proportional; force (n, 2) m/s^2, lateral specific force in body x and y, mean removed.
    """

    t: Array
    velocity: Array
    thrust: Array
    force: Array


def lateral_force(recorded: Flight) -> LateralForce:
    """Inputs and lateral specific force of a recorded flight (columns: pose, cmd_rotor_*, battery).

    Position is put on a 10 ms grid; velocity and acceleration are its Savitzky-Golay derivatives (31 samples,
    order 3). Rows count above 0.4 m and above 15 % mean throttle, without the first and last 1.5 s of that part.
    InputError where no row is left.
    """
    t, position, attitude = uniform_pose(recorded)
    velocity = derivative(position, 1)
    specific = rotations.to_body(attitude, derivative(position, 2) + np.array([0.0, 0.0, GRAVITY]))
    throttle = recorded.numbered("cmd_rotor_")
    if throttle.shape[1] == 0:
        recorded.get("cmd_rotor_0")
    battery = medfilt(recorded.get("battery")[:, 0], BATTERY_SAMPLES)
    thrust = resample(recorded.t, ((throttle * battery[:, None]) ** 2).sum(axis=1), t)
    mean_throttle = resample(recorded.t, throttle.mean(axis=1), t)
    keep = counted_rows(t, position[:, 2], mean_throttle > LEAST_THROTTLE) & np.isfinite(thrust)
    if not keep.any():
        raise InputError(
            problem(
                f"{recorded.meta.get('source', 'flight')}: no row in flight",
                f"rows above {LOWEST} m and {100 * LEAST_THROTTLE:.0f} % throttle for more than {2 * MARGIN} s",
                "Leave the flight out.",
            )
        )
    force = specific[keep, :2]
    return LateralForce(
        t=t[keep],
        velocity=rotations.to_body(attitude, velocity)[keep],
        thrust=thrust[keep],
        force=force - force.mean(axis=0),
    )


def counted_rows(t: Array, height: Array, running: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Rows (n,) above 0.4 m where `running`, without the first and last 1.5 s of them."""
    up = (height > LOWEST) & running
    if not up.any():
        return up
    first, last = t[up][[0, -1]]
    return up & (t >= first + MARGIN) & (t <= last - MARGIN)


def uniform_pose(recorded: Flight) -> tuple[Array, Array, Array]:
    """Time (n,), position (n, 3) and attitude (n, 4) on a 10 ms grid, between the recorded samples linearly."""
    source = recorded.t
    t = source[0] + STEP * np.arange(int((source[-1] - source[0]) / STEP + 1e-6) + 1)
    if len(t) < FILTER_SAMPLES:
        raise InputError(
            problem(
                f"{recorded.meta.get('source', 'flight')}: {len(t)} samples of 10 ms",
                f"at least {FILTER_SAMPLES}",
                "Leave the flight out.",
            )
        )
    position = resample(source, recorded.get(*flight.POSITION), t)
    attitude = resample(source, rotations.continuous(recorded.get(*flight.ATTITUDE)), t)
    return t, position, rotations.normalize(attitude)


def resample(source: Array, values: Array, t: Array) -> Array:
    """Linear interpolation of values (m,) or (m, d), at times `source`, to the times t."""
    values = np.asarray(values, dtype=float)
    if values.ndim == 1:
        return np.interp(t, source, values)
    return np.column_stack([np.interp(t, source, column) for column in values.T])


def derivative(values: Array, order: int) -> Array:
    """Time derivative of the given order of values (n, d) on the 10 ms grid: Savitzky-Golay, 31 samples, order 3."""
    return savgol_filter(values, FILTER_SAMPLES, FILTER_ORDER, deriv=order, delta=STEP, axis=0)


def rms(difference: Array) -> float:
    """Root of the mean square over rows and both axes (m/s^2)."""
    return float(np.sqrt(np.mean(np.square(difference))))
