"""The inversion of eq. 20: the command u with u + mu(u) equal to the demand. Compiled.

The Gaussian process has no force rows, so the force part of u is the demand's own; the torque part solves
min |d - u - mu(u)|^2 by Levenberg-Marquardt with the analytic Jacobian I + dmu/du (Nocedal and Wright 2006, 10.3),
started from the last command's correction and kept within `max_correction` of the demand.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from infotraj.residual.compiled import mean_and_jacobian

_ITERATIONS = 12
_TOLERANCE = 1e-8  # (rad/s^2)^2


@njit(cache=True)
def invert(wanted, process, max_correction, correction, command):
    """Writes the command (6,) for the demand `wanted` (6,), both m/s^2 and rad/s^2; returns the error left (squared).

    process: the arrays of `GaussianProcess.mean_arrays`; correction (3,): start value, and the result command - wanted.
    """
    points, alpha, weights, signal_variance, constant, slopes = process
    command[:3] = wanted[:3]
    command[3:] = wanted[3:] + correction
    mean, jacobian = np.empty(3), np.empty((3, 6))
    mean_and_jacobian(command, points, alpha, weights, signal_variance, constant, slopes, mean, jacobian)
    error = wanted[3:] - command[3:] - mean
    cost = error @ error
    damping = 1e-4
    trial, trial_mean, trial_jacobian = command.copy(), np.empty(3), np.empty((3, 6))
    for _ in range(_ITERATIONS):
        if cost < _TOLERANCE:
            break
        a = np.eye(3) + jacobian[:, 3:]
        normal = a.T @ a
        for i in range(3):
            normal[i, i] += damping
        step = np.linalg.solve(normal, a.T @ error)
        for i in range(3):
            shift = command[3 + i] + step[i] - wanted[3 + i]
            trial[3 + i] = wanted[3 + i] + min(max(shift, -max_correction), max_correction)
        mean_and_jacobian(trial, points, alpha, weights, signal_variance, constant, slopes, trial_mean, trial_jacobian)
        trial_error = wanted[3:] - trial[3:] - trial_mean
        trial_cost = trial_error @ trial_error
        if trial_cost < cost:
            if cost - trial_cost < 1e-9 * cost:
                cost = trial_cost
                command[3:] = trial[3:]
                break
            command[3:] = trial[3:]
            error, cost = trial_error, trial_cost
            jacobian[:] = trial_jacobian
            damping = max(damping * 0.1, 1e-8)
        else:
            damping *= 10.0
            if damping > 1e6:
                break
    correction[:] = command[3:] - wanted[3:]
    return cost
