"""The exact simulation in time: Runge-Kutta's fourth order between events, and what is read and commanded at them.

Steps end exactly where a command begins to act and where a sensor is sampled.
"""

from __future__ import annotations

import numpy as np
from exact_controller import commands, reference
from exact_motion import derivative
from exact_vectors import dot, plus
from numba import njit


@njit(cache=True)
def _jump(state, n, m, rotor_cmd, tilt_cmd, rotors, tilts):
    """Actuators without a lag are at their command at once."""
    for i in range(n):
        if rotors.tau[i] <= 0:
            state[13 + i] = rotor_cmd[i]
    for i in range(m):
        if tilts.tau[i] <= 0:
            state[13 + n + i] = tilt_cmd[i]


@njit(cache=True)
def _advance(state, arm, start, stop, substep, n, m, rotor_cmd, tilt_cmd, body, rotors, tilts, air, other):
    steps = max(1, int(np.ceil((stop - start) / substep - 1e-9)))
    h = (stop - start) / steps
    for k in range(steps):
        t = start + k * h
        k1, _ = derivative(state, n, m, t, rotor_cmd, tilt_cmd, arm, body, rotors, tilts, air, other)
        at = plus(state, 0.5 * h, k1)
        k2, _ = derivative(at, n, m, t + 0.5 * h, rotor_cmd, tilt_cmd, arm, body, rotors, tilts, air, other)
        at = plus(state, 0.5 * h, k2)
        k3, _ = derivative(at, n, m, t + 0.5 * h, rotor_cmd, tilt_cmd, arm, body, rotors, tilts, air, other)
        at = plus(state, h, k3)
        k4, _ = derivative(at, n, m, t + h, rotor_cmd, tilt_cmd, arm, body, rotors, tilts, air, other)
        for i in range(len(state)):
            state[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
        for unit in (state[3:7], state[13 + n + m : 16 + n + m]):
            size = np.sqrt(dot(unit, unit))
            for i in range(len(unit)):
                unit[i] /= size
        for i in range(m):
            x = state[13 + n + i]
            arm[i] = min(max(arm[i], x - tilts.play), x + tilts.play)


@njit(cache=True)
def simulate(rows, samples, substep, body, rotors, tilts, air, other, control, path):
    """States at `rows`, rate and specific force at `samples`, commands of the rows, actuators at the rows."""
    count, n, m = len(rows), len(rotors.spin), len(tilts.tau)
    states, imu = np.empty((count, 10)), np.empty((count, 6))
    cmd_rotor, cmd_tilt = np.empty((count, n)), np.empty((count, m))
    out_rotor, out_tilt = np.empty((count, n)), np.empty((count, m))
    state = np.zeros(25 + n + m)
    start, _ = reference(rows[0], path)
    state[0:3] = start[0]
    state[3] = 1.0
    state[15 + n + m] = -1.0
    rotor, tilt = commands(rows[0], state, n, m, control, path)
    state[13 : 13 + n], state[13 + n : 13 + n + m] = rotor, tilt
    arm = tilt.copy()
    now_rotor, now_tilt = rotor.copy(), tilt.copy()
    waiting_rotor, waiting_tilt = np.empty((count, n)), np.empty((count, m))
    time, row, sample, event = rows[0], 0, 0, 0
    _, f = derivative(state, n, m, 0.0, now_rotor, now_tilt, arm, body, rotors, tilts, air, other)
    state[19 + n + m : 22 + n + m], state[22 + n + m : 25 + n + m] = state[10:13], f
    while sample < count and samples[sample] < rows[0]:
        imu[sample, 0:3], imu[sample, 3:6] = state[10:13], f
        sample += 1
    last = max(rows[count - 1], samples[count - 1])
    while True:
        # At one instant: the IMU first, then the row (pose, new command), then a command that begins to act.
        if sample < count and samples[sample] <= time + 1e-12:
            _, f = derivative(state, n, m, time - rows[0], now_rotor, now_tilt, arm, body, rotors, tilts, air, other)
            imu[sample, 0:3], imu[sample, 3:6] = state[10:13], f
            if other.sensor_lag > 0.0:
                imu[sample] = state[19 + n + m : 25 + n + m]
            sample += 1
        if row < count and rows[row] <= time + 1e-12:
            states[row] = state[0:10]
            out_rotor[row] = state[13 : 13 + n]
            for i in range(m):
                out_tilt[row, i] = arm[i] + tilts.bias[i]
            rotor, tilt = commands(time, state, n, m, control, path)
            cmd_rotor[row], cmd_tilt[row] = rotor, tilt
            waiting_rotor[row], waiting_tilt[row] = rotor, tilt
            row += 1
        if event < row and rows[event] + other.delay <= time + 1e-12:
            now_rotor, now_tilt = waiting_rotor[event].copy(), waiting_tilt[event].copy()
            _jump(state, n, m, now_rotor, now_tilt, rotors, tilts)
            event += 1
        if time >= last - 1e-12 or (row == count and sample == count):
            break
        upcoming = last
        if row < count:
            upcoming = min(upcoming, rows[row])
        if sample < count:
            upcoming = min(upcoming, samples[sample])
        if event < row:
            upcoming = min(upcoming, rows[event] + other.delay)
        _advance(
            state,
            arm,
            time - rows[0],
            upcoming - rows[0],
            substep,
            n,
            m,
            now_rotor,
            now_tilt,
            body,
            rotors,
            tilts,
            air,
            other,
        )
        time = upcoming
    return states, imu, cmd_rotor, cmd_tilt, out_rotor, out_tilt
