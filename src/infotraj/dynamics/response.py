"""The declared response of the actuators: first-order lags, the tilts' limited in rate, solved exactly.

Between two rows a command is constant, so each lag has a closed form: a tilt that is further than `max_rate` times its
time constant from its command moves at `max_rate` until it is that close, and exponentially from there.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from infotraj.dynamics.actuators import body_wrench
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


def respond(t: ArrayLike, command: ArrayLike, time_constant: ArrayLike, max_rate: ArrayLike) -> Array:
    """Actuator values (n, m) at times t (n,) s for commands (n, m), the one of row k acting from t[k] to t[k+1].

    time_constant (m,) s, 0 for none; max_rate (m,) per second, inf for none. The values start at the first command.
    """
    t = np.ascontiguousarray(t, dtype=float)
    command = np.ascontiguousarray(command, dtype=float)
    shape = command.shape[1:]
    tau = np.ascontiguousarray(np.broadcast_to(time_constant, shape), dtype=float)
    return _respond(t, command, tau, np.ascontiguousarray(np.broadcast_to(max_rate, shape), dtype=float))


def actuator_values(vehicle: Vehicle, t: ArrayLike, cmd_rotor: ArrayLike, cmd_tilt: ArrayLike) -> tuple[Array, Array]:
    """Rotor inputs (n, rotors), or the wrench (n, 6), and tilts (n, tilts) that the file declares for commands."""
    rotor = respond(t, cmd_rotor, vehicle.input_time_constants, np.inf)
    if not vehicle.tilts:
        return rotor, np.zeros((len(rotor), 0))
    tilt = respond(t, cmd_tilt, [a.time_constant for a in vehicle.tilts], [a.max_rate for a in vehicle.tilts])
    return rotor, tilt


def wrench_of_rows(vehicle: Vehicle, t: ArrayLike, cmd_rotor: ArrayLike, cmd_tilt: ArrayLike) -> Array:
    """Mean body wrench (n, 6), N and N m, from t[k] to t[k+1] (last row: at t[n-1]) with the declared response."""
    at_rows = body_wrench(vehicle, *actuator_values(vehicle, t, cmd_rotor, cmd_tilt))
    mean = at_rows.copy()
    mean[:-1] = 0.5 * (at_rows[:-1] + at_rows[1:])
    return mean


@njit(cache=True)
def _respond(t, command, tau, max_rate):
    out = np.empty_like(command)
    out[0] = command[0]
    for j in range(command.shape[1]):
        x = command[0, j]
        for k in range(len(t) - 1):
            left, gap = t[k + 1] - t[k], command[k, j] - x
            near = max_rate[j] * tau[j]
            if abs(gap) > near:
                full = (abs(gap) - near) / max_rate[j]
                if full >= left:
                    x += math.copysign(max_rate[j] * left, gap)
                    out[k + 1, j] = x
                    continue
                left -= full
                gap = math.copysign(near, gap)
            x = command[k, j] - (gap * math.exp(-left / tau[j]) if tau[j] > 0 else 0.0)
            out[k + 1, j] = x
    return out
