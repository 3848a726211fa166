"""Whether ordinary tolerances of a vehicle explain what an effect explains: then it is real, but it does not matter.

No vehicle file is right to the last digit: rotors differ by a per cent, an inertia by two, a time stamp by a fraction
of a row. Minutes of data find each of these with certainty. So an effect counts as within tolerance when small changes
of such numbers, together, leave no more error than the limit of what matters. The least of them is found by a prior of
these standard deviations whose weight grows until the error rises by that limit (Tikhonov; Morozov's discrepancy
principle, 1966).
"""

from __future__ import annotations

from collections.abc import Set

import numpy as np

from infotraj.diagnosis.fitting import Fit
from infotraj.diagnosis.search import Search
from infotraj.diagnosis.sensitivities import Sensitivities
from infotraj.diagnosis.sums import Sums

# Standard deviations in usual sizes of the effect (Parameter.scale), with what that is.
TOLERANCES = {
    "rotor_effectiveness": 1 / 15,  # 1 % of a rotor's thrust
    "inertia_error": 2 / 15,  # 2 %
    "com_offset": 1 / 10,  # 0.3 % of an arm
    "moment_scale": 1 / 30,  # 1 %
    "rotor_lag": 1 / 30,  # 1 ms
    "servo_lag": 1 / 30,  # 1 ms
    "actuation_delay": 1 / 15,  # 1 ms
    "time_offset": 1 / 10,  # 1 ms
    "servo_bias": 1 / 10,  # 0.1 deg
    "imu_misalignment": 1 / 10,  # 0.1 deg
}
MOST = 5.0  # sum of squares in standard deviations that still counts as ordinary


def tolerable(search: Search, whole: Fit, labels: Set[str]) -> bool:
    """Whether tolerances explain what the members `labels` of the fitted model `whole` explain together."""
    rest = [m for m in whole.members if m.candidate.label not in labels]
    if search.fitted(rest) is None:
        return False
    rest = search.fitted(rest).members
    sums, found = search.linear(rest)
    columns, deviation = nuisance(found)
    if not columns:
        return False
    allowed = search.matters * whole.sums.rows.sum(axis=1) + whole_error(whole)
    least = least_tolerance(sums, found, columns, deviation, allowed)
    return least <= MOST


def nuisance(found: Sensitivities) -> tuple[list[int], np.ndarray]:
    """Columns that tolerances move, and their standard deviations in usual sizes."""
    columns, deviation, seen = [], [], set()
    for choice in found.choices:
        label = choice.candidate.label
        if choice.candidate.name not in TOLERANCES or label in seen:
            continue
        seen.add(label)
        columns += list(choice.columns)
        deviation += [TOLERANCES[choice.candidate.name]] * len(choice.columns)
    return columns, np.array(deviation)


def whole_error(whole: Fit) -> np.ndarray:
    """Squared error of a fit, axis by axis."""
    return whole.sums.square.sum(axis=1)


def least_tolerance(
    sums: Sums, found: Sensitivities, columns: list[int], deviation: np.ndarray, allowed: np.ndarray
) -> float:
    """Least sum of squares, in standard deviations, that keeps the error of every axis as allowed; inf if none."""
    own = list(found.of_members)
    index = np.array(own + columns, dtype=int)
    prior = np.concatenate([np.zeros(len(own)), 1.0 / deviation**2])
    gram = sums.gram.sum(axis=1)[:, index[:, None], index]
    right, square = sums.right.sum(axis=1)[:, index], sums.square.sum(axis=1)
    total = gram.sum(axis=0) + 1e-9 * np.diag(np.diag(gram.sum(axis=0)))
    for weight in 10.0 ** np.arange(8, -3, -0.5):
        theta = np.linalg.solve(total + np.diag(weight * prior), right.sum(axis=0))
        error = square - 2 * right @ theta + np.einsum("aij,i,j->a", gram, theta, theta)
        if np.all(error <= allowed):
            return float(np.sum((theta[len(own) :] / deviation) ** 2))
    return float("inf")
