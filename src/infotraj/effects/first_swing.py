"""How a load on a cable swings as a flight begins.

A log seldom begins with the load at rest, and a free swing dies slowly. Where nothing but air and cable acts, across
the axis of all thrusts, the measured specific force shows the swing: the state that the load begins with is the most
probable one for what is measured there, a drag linear in the velocity and a constant of the sensor fitted along.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from infotraj.rotations import Array

STATES = 4  # angles and rates of the first row, across the cable
_USUAL = 0.1  # rad, and rad of a free swing's rate: how far a load that hangs still is from rest
LEARNED = 10.0  # s: after more of it a swing without damping is another
_LONGEST = 1.0  # s over which errors go together, at most
_PERIODS = (1.0, 3.0)  # of a free swing from which it is found at first: over many an error of phase hides the way
_ROUNDS = 4
_STEP = 1e-3
_FAR = 0.4  # the longest step
_LEAST = 1e-3  # of the vehicle's mass: of a lighter load nothing is seen

Swing = Callable[[Array, Array], tuple[Array, Array]]
Across = Callable[[Array], tuple[Array, Array, Array]]


def first_swing(across: Across, swing: Swing, time: Array, hang: Array, rate: float) -> tuple[Array, Array]:
    """Direction q (3,) of the cable in the first row and its rate q' (3,) 1/s, world axes.

    across(time (N,) s): two directions across the thrusts (N, 2, 3), world axes, and the specific force (m/s^2) and the
    velocity (m/s) along them, (N, 2); swing(q, q'): direction of the cable (N, 3) and its pull per mass of the load
    (N,) m/s^2 at `time`, for a load that begins so; time: in even steps, of the flight's first LEARNED seconds;
    hang (3,): where it hangs at rest; rate: of a free swing, rad/s.
    """
    sideways = np.linalg.svd(hang[None])[2][1:]
    still = np.zeros(STATES)
    step = time[1] - time[0]
    every_direction, force, velocity = across(time)

    def state(x: Array) -> tuple[Array, Array]:
        q = hang + x[:2] @ sideways
        q = q / np.linalg.norm(q)
        q_dot = rate * (x[2:] @ sideways)
        return q, q_dot - q * (q @ q_dot)

    if not np.isfinite(force).all() or not np.isfinite(velocity).all():
        return state(still)

    def pulls(x: Array, count: int) -> Array:
        q, pull = swing(*state(x))
        along = q[:count] * pull[:count, None]
        return np.einsum("nki,ni->kn", every_direction[:count], along).ravel()

    x = still
    for seconds in (*(2.0 * np.pi * n / rate for n in _PERIODS), np.inf):
        count = int(np.searchsorted(time, time[0] + seconds))
        one, none = np.ones(count), np.zeros(count)
        others = [np.concatenate(pair) for v in (one, *velocity[:count].T) for pair in ((v, none), (none, v))]
        measured = force[:count].T.ravel()
        if len(measured) < 4 * (len(others) + STATES):
            continue
        for _ in range(_ROUNDS):
            now = pulls(x, count)
            moved = [(pulls(x + _STEP * e, count) - now) / _STEP for e in np.eye(STATES)]
            columns = np.column_stack([now, *moved, *others])
            found = np.linalg.lstsq(columns, measured, rcond=None)[0]
            left = (measured - columns @ found).reshape(2, -1)
            spread = np.sqrt(np.mean(left**2) * _together(left, step))
            known = np.zeros((STATES, columns.shape[1]))
            known[:, 0], known[:, 1 : 1 + STATES] = x, np.eye(STATES)
            known *= spread / (max(found[0], _LEAST) * _USUAL)
            found = np.linalg.lstsq(np.vstack([columns, known]), np.concatenate([measured, still]), rcond=None)[0]
            move = found[1 : 1 + STATES] / max(found[0], _LEAST)
            x = x + move * min(1.0, _FAR / max(float(np.abs(move).max()), _FAR))
            if np.abs(move).max() < _STEP:
                break
        if found[0] <= _LEAST:
            x = still
    return state(x)


def _together(left: Array, step: float) -> float:
    """Samples that say as much as one of independent errors (axes, N): the integral of their autocorrelation."""
    centred = left - left.mean(axis=1, keepdims=True)
    size = np.sum(centred**2)
    if size == 0.0:
        return 1.0
    total = 1.0
    for lag in range(1, min(centred.shape[1] - 1, round(_LONGEST / step))):
        alike = np.sum(centred[:, lag:] * centred[:, :-lag]) / size
        if alike <= 0.0:
            break
        total += 2.0 * alike
    return float(total)
