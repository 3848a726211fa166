"""The demand x* - l(x) of eq. 20: the scaled wrench that a perfect actuator would have to deliver. Compiled."""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True)
def rotate_into(q, v, out):
    """out = R(q)^T v: a vector of the outer frame expressed in the frame that q (w, x, y, z) describes."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    out[0] = (1 - 2 * (y * y + z * z)) * v[0] + 2 * (x * y + w * z) * v[1] + 2 * (x * z - w * y) * v[2]
    out[1] = 2 * (x * y - w * z) * v[0] + (1 - 2 * (x * x + z * z)) * v[1] + 2 * (y * z + w * x) * v[2]
    out[2] = 2 * (x * z + w * y) * v[0] + 2 * (y * z - w * x) * v[1] + (1 - 2 * (x * x + y * y)) * v[2]


@njit(cache=True)
def relative(q, r, out):
    """out = conj(q) r: the attitude r seen from q."""
    out[0] = q[0] * r[0] + q[1] * r[1] + q[2] * r[2] + q[3] * r[3]
    out[1] = q[0] * r[1] - q[1] * r[0] - q[2] * r[3] + q[3] * r[2]
    out[2] = q[0] * r[2] - q[2] * r[0] - q[3] * r[1] + q[1] * r[3]
    out[3] = q[0] * r[3] - q[3] * r[0] - q[1] * r[2] + q[2] * r[1]


@njit(cache=True)
def limit_norm(v, start, limit):
    """Shortens v[start:start + 3] to `limit`; True where it was longer."""
    norm = math.sqrt(v[start] ** 2 + v[start + 1] ** 2 + v[start + 2] ** 2)
    if norm <= limit:
        return False
    for i in range(3):
        v[start + i] *= limit / norm
    return True


@njit(cache=True)
def demand(gains, gravity, inertia, period, state, reference, integral, out):
    """Writes the demand (6,) m/s^2 and rad/s^2, body frame, and updates the integrals (6,).

    state: (13,) position, attitude, velocity (world), rate (body); reference: (19,) the same, then acceleration
    (world) and angular acceleration (body of the reference); inertia (3, 3). The demanded acceleration is the
    task's own plus the PID action on the errors; l(x), weight and gyroscopic torque, is taken off. Anti-windup:
    an axis does not integrate while the feedback of its group is limited.
    """
    q, w = state[3:7], state[10:13]
    feedback = np.empty(6)
    for i in range(3):
        feedback[i] = (
            gains.position_p * (reference[i] - state[i])
            + gains.position_d * (reference[7 + i] - state[7 + i])
            + gains.position_i * integral[i]
        )

    turn = np.empty(4)
    relative(q, reference[3:7], turn)
    if turn[0] < 0:
        turn[:] = -turn
    sine = math.sqrt(turn[1] ** 2 + turn[2] ** 2 + turn[3] ** 2)
    stretch = 2.0 * math.atan2(sine, turn[0]) / sine if sine > 1e-9 else 2.0
    # turn maps vectors of the reference's body to the vehicle's: rotate_into takes the inverse.
    back = np.array([turn[0], -turn[1], -turn[2], -turn[3]])
    rate, acceleration = np.empty(3), np.empty(3)
    rotate_into(back, reference[10:13], rate)
    rotate_into(back, reference[16:19], acceleration)
    for i in range(2):
        feedback[3 + i] = (
            gains.attitude_p * stretch * turn[1 + i]
            + gains.attitude_d * (rate[i] - w[i])
            + gains.attitude_i * integral[3 + i]
        )
    feedback[5] = gains.yaw_p * stretch * turn[3] + gains.yaw_d * (rate[2] - w[2]) + gains.yaw_i * integral[5]
    limited = limit_norm(feedback, 0, gains.max_feedback_acceleration)
    limited_turn = limit_norm(feedback, 3, gains.max_feedback_angular_acceleration)
    for i in range(3):
        if not limited:
            integral[i] += period * (reference[i] - state[i])
        if not limited_turn:
            integral[3 + i] += period * stretch * turn[1 + i]

    world = np.empty(3)
    for i in range(3):
        world[i] = reference[13 + i] + feedback[i]
    world[2] += gravity
    rotate_into(q, world, out[:3])
    momentum = inertia @ w
    gyroscopic = np.array(
        [
            w[1] * momentum[2] - w[2] * momentum[1],
            w[2] * momentum[0] - w[0] * momentum[2],
            w[0] * momentum[1] - w[1] * momentum[0],
        ]
    )
    # The transport term w x rate: the reference's rate is differentiated in a frame that turns with the vehicle.
    out[3] = acceleration[0] - (w[1] * rate[2] - w[2] * rate[1]) + feedback[3] + gyroscopic[0] / inertia[0, 0]
    out[4] = acceleration[1] - (w[2] * rate[0] - w[0] * rate[2]) + feedback[4] + gyroscopic[1] / inertia[1, 1]
    out[5] = acceleration[2] - (w[0] * rate[1] - w[1] * rate[0]) + feedback[5] + gyroscopic[2] / inertia[2, 2]
    limit_norm(out, 0, gains.max_specific_force)
    limit_norm(out, 3, gains.max_angular_acceleration)
