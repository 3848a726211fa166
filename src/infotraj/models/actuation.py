"""Actuators along a flight: commands through delay, lag with rate limit, play and bias, at any instants.

Between two commands each lag has a closed form: a tilt further than `max_rate` times its time constant from its command
moves at `max_rate` until it is that close, and exponentially from there. It moves one way only, so play, too, is exact
at every instant. At the very instant of a command the actuators are as they were just before it.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from infotraj.effects.along import Actuation
from infotraj.effects.laws import ActuatorLaw
from infotraj.models.interpolation import interpolate
from infotraj.models.recorded import Recorded, Samples
from infotraj.rotations import Array


def actuation(recorded: Recorded, law: ActuatorLaw, time: Array) -> Actuation:
    """Rotors and tilts at `time` (N,) s, increasing, of the flight's clock."""
    tilt, slope = tilts_at(recorded, law, time)
    return Actuation(*rotors_at(recorded, law, time), tilt + law.tilt_bias, slope)


def rotors_at(recorded: Recorded, law: ActuatorLaw, time: Array) -> tuple[Array, Array]:
    """Rotor inputs and their slopes (N, rotors) at `time` (N,) s, increasing, of the flight's clock."""
    if not recorded.rotor_commanded:
        return _measured(recorded.rotor, law, time)
    none = np.zeros(recorded.rotor.values.shape[1])
    return _respond(time, *_events(recorded.rotor, law), law.rotor_time_constant, none + np.inf, none)


def tilts_at(recorded: Recorded, law: ActuatorLaw, time: Array) -> tuple[Array, Array]:
    """Tilts without their bias, and their slopes (N, tilts), at `time` (N,) s, increasing, of the flight's clock."""
    if not recorded.tilt_commanded:
        return _measured(recorded.tilt, law, time)
    events = _events(recorded.tilt, law)
    return _respond(time, *events, law.tilt_time_constant, law.tilt_max_rate, law.tilt_play)


def _events(commands: Samples, law: ActuatorLaw) -> tuple[Array, Array]:
    return commands.times + law.delay + law.late, np.ascontiguousarray(commands.values)


def _measured(samples: Samples, law: ActuatorLaw, time: Array) -> tuple[Array, Array]:
    written = time - law.late + law.telemetry
    return samples.at(written), interpolate(samples.times, samples.slopes, written, samples.usual)


@njit(cache=True)
def _respond(time, event, command, tau, max_rate, play):
    """Values and slopes (N, m) for commands (e, m) that act from event (e,) on; at rest on the first before."""
    count, m = len(time), command.shape[1]
    out, slope = np.empty((count, m)), np.empty((count, m))
    x, arm = command[0].copy(), command[0].copy()
    target = command[0].copy()
    since = min(event[0], time[0]) if count else event[0]
    e = 0
    for n in range(count):
        # A delayed command may fall on a row but for rounding: it acts after the row's sample.
        while e < len(event) and event[e] < time[n] - 1e-9:
            for j in range(m):
                x[j], _ = _moved(x[j], target[j], event[e] - since, tau[j], max_rate[j])
                arm[j] = min(max(arm[j], x[j] - play[j]), x[j] + play[j])
                target[j] = command[e, j]
            since = event[e]
            e += 1
        elapsed = time[n] - since
        last_tau, decay = -1.0, 0.0
        for j in range(m):
            if max_rate[j] == np.inf:
                if tau[j] != last_tau:
                    last_tau = tau[j]
                    decay = math.exp(-elapsed / tau[j]) if tau[j] > 0 else (1.0 if elapsed <= 0 else 0.0)
                gap = (target[j] - x[j]) * decay
                value = target[j] - gap
                rise = gap / tau[j] if tau[j] > 0 else 0.0
            else:
                value, rise = _moved(x[j], target[j], elapsed, tau[j], max_rate[j])
            if play[j] > 0:
                held = min(max(arm[j], value - play[j]), value + play[j])
                slope[n, j] = rise if held != arm[j] else 0.0
                out[n, j] = held
            else:
                out[n, j], slope[n, j] = value, rise
    return out, slope


@njit(cache=True)
def _moved(x, target, elapsed, tau, max_rate):
    """Value and slope of one lag after `elapsed` seconds towards `target`."""
    gap = target - x
    if elapsed <= 0:
        near = max_rate * tau
        return x, (math.copysign(max_rate, gap) if abs(gap) > near else (gap / tau if tau > 0 else 0.0))
    near = max_rate * tau if max_rate < np.inf else np.inf
    if abs(gap) > near:
        full = (abs(gap) - near) / max_rate
        if full >= elapsed:
            return x + math.copysign(max_rate * elapsed, gap), math.copysign(max_rate, gap)
        elapsed -= full
        gap = math.copysign(near, gap)
    if tau <= 0:
        return target, 0.0
    gap *= math.exp(-elapsed / tau)
    return target - gap, gap / tau
