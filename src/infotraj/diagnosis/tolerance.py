"""Whether ordinary tolerances of a vehicle explain what an effect explains: then it is real, but it does not matter.

No vehicle file is right to the last digit: rotors differ by a per cent, an inertia by two, a time stamp by a fraction
of a row. Minutes of data find each of these with certainty. So effects count as within tolerance when small changes of
such numbers, together, leave no more error than the limit of what matters. The least of them is found by a prior of
these standard deviations whose weight grows until the error rises by that limit (Tikhonov; Morozov's discrepancy
principle, 1966).

How much is ordinary depends on company. Tolerances come together: where other numbers deviate too, deviations up to
what is likely by chance are ordinary; one clean deviation and nothing beside it is an effect, unless it is tiny.
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
ALONE = 1.0  # sum of squares, in standard deviations, that is ordinary for one number that deviates alone
TOGETHER = 10.0  # the same where several do (95 % of chi squared with four to five degrees of freedom)
_SCALES = (0.03, 0.1, 0.3, 0.6, 1.0, 1.5)  # of all tolerances together
_EVIDENT = 100.0  # fall of the squared error by tolerances beside the model: more than chance, others deviate too


def tolerated(search: Search, whole: Fit) -> frozenset[str]:
    """Labels of the members of the fitted model `whole` that tolerances explain, all of them together."""
    alone = {}
    for m in whole.members:
        if not m.held:
            alone[m.candidate.label] = _least(search, whole, {m.candidate.label})
    suspects = {label: least for label, least in alone.items() if least <= 3 * TOGETHER}
    company = bool(suspects) and _beside(search, whole) > _EVIDENT
    while suspects:
        most = TOGETHER if company or len(suspects) > 1 else ALONE
        least = _least(search, whole, set(suspects)) if len(suspects) > 1 else next(iter(suspects.values()))
        if least <= most:
            return frozenset(suspects)
        del suspects[max(suspects, key=suspects.get)]
    return frozenset()


def _least(search: Search, whole: Fit, labels: Set[str]) -> float:
    """Least sum of squares, in standard deviations, that explains what these members explain; inf where none does."""
    out = search.fitted([m for m in whole.members if m.candidate.label not in labels])
    if out is None:
        return float("inf")
    sums, found = search.linear(out.members)
    columns, deviation = nuisance(found)
    if not columns:
        return float("inf")
    allowed = search.matters * whole.sums.windows.sum(axis=1) + whole_error(whole)
    return least_tolerance(sums, found, columns, deviation, allowed)


def _beside(search: Search, whole: Fit) -> float:
    """Fall of the squared error of the fitted model when tolerances are fitted beside it."""
    sums, found = search.linear(whole.members)
    columns, deviation = nuisance(found)
    index = [*found.of_members, *columns]
    if not columns:
        return 0.0
    gram, right, _ = sums.total()
    gram, right = gram.sum(axis=0)[np.ix_(index, index)], right.sum(axis=0)[index]
    prior = np.concatenate([np.full(len(found.of_members), 1e-6), 1 / deviation**2])
    return float(right @ np.linalg.solve(gram + np.diag(prior), right))


def spread(search: Search, made: Fit) -> np.ndarray:
    """Variance (p,) of a fit's numbers, in usual sizes, that ordinary tolerances of the vehicle file make.

    Each tolerance that the model does not have moves the numbers that are fitted without it. How large they are here is
    estimated from what the fit leaves (their common scale by marginal likelihood; MacKay 1992): exact files get none.
    """
    sums, found = search.linear(made.members)
    columns, deviation = nuisance(found)
    own = list(found.of_members)
    if not columns or not own:
        return np.zeros(len(own))
    gram, right, _ = sums.total()
    gram, right = gram.sum(axis=0), right.sum(axis=0)
    of_own = gram[np.ix_(own, own)]
    of_own = of_own + 1e-9 * np.diag(np.diag(of_own)) + 1e-12 * np.eye(len(own))
    across = gram[np.ix_(own, columns)] * deviation
    solved = np.linalg.solve(of_own, across)
    rest = gram[np.ix_(columns, columns)] * np.outer(deviation, deviation) - across.T @ solved
    pull = right[columns] * deviation - solved.T @ right[own]
    best = (0.0, 0.0)
    for scale in _SCALES:
        inside = np.eye(len(columns)) + scale**2 * rest
        fit = scale**2 * pull @ np.linalg.solve(inside, pull) - np.linalg.slogdet(inside)[1]
        best = max(best, (float(fit), scale))
    return best[1] ** 2 * np.sum(solved**2, axis=1)


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
