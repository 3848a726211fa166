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

from infotraj.diagnosis.allowance import nuisance, without_tolerances
from infotraj.diagnosis.fitting import Fit
from infotraj.diagnosis.search import INEXACT, Search
from infotraj.diagnosis.sensitivities import Sensitivities
from infotraj.diagnosis.sums import Sums

ALONE = 1.0  # sum of squares, in standard deviations, that is ordinary for one number that deviates alone
TOGETHER = 10.0  # the same where several do (95 % of chi squared with four to five degrees of freedom)
_EVIDENT = 100.0  # fall of the squared error by tolerances beside the model: more than chance, others deviate too


def tolerated(search: Search, whole: Fit) -> frozenset[str]:
    """Labels of the members of the fitted model `whole` that tolerances explain, all of them together."""
    if search.tolerance < INEXACT:
        # The flights showed the vehicle file to be exact: what is off is off on its own.
        return frozenset()
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
    """Least sum of squares, in standard deviations, that explains what these members explain; inf where none does.

    It is what tolerances need beyond those that they need beside the whole model.
    """
    out = search.fitted([m for m in whole.members if m.candidate.label not in labels])
    if out is None:
        return float("inf")
    sums, found = search.linear(out.members)
    columns, deviation = nuisance(found, search.tolerance)
    if not columns:
        return float("inf")
    # What tolerances explain beside the whole model they must explain here too, and are not charged for.
    beside, own = search.linear(whole.members)
    best = without_tolerances(beside, own, search.tolerance).square.sum(axis=1)
    allowed = search.matters * whole.sums.windows.sum(axis=1) + best
    sure = least_tolerance(beside, own, *nuisance(own, search.tolerance), allowed)
    return least_tolerance(sums, found, columns, deviation, allowed) - (sure if np.isfinite(sure) else 0.0)


def _beside(search: Search, whole: Fit) -> float:
    """Fall of the squared error of the fitted model when tolerances are fitted beside it."""
    sums, found = search.linear(whole.members)
    columns, deviation = nuisance(found, search.tolerance)
    index = [*found.of_members, *columns]
    if not columns:
        return 0.0
    gram, right, _ = sums.total()
    gram, right = gram.sum(axis=0)[np.ix_(index, index)], right.sum(axis=0)[index]
    prior = np.concatenate([np.full(len(found.of_members), 1e-6), 1 / deviation**2])
    return float(right @ np.linalg.solve(gram + np.diag(prior), right))


def least_tolerance(
    sums: Sums, found: Sensitivities, columns: list[int], deviation: np.ndarray, allowed: np.ndarray
) -> float:
    """Least sum of squares, in standard deviations, that keeps the error of every axis as allowed; inf if none."""
    own = list(found.of_members)
    index = np.array(own + columns, dtype=int)
    prior = np.concatenate([np.zeros(len(own)), 1.0 / deviation**2])
    gram = sums.gram.sum(axis=1)[:, index[:, None], index]
    right, square = sums.right.sum(axis=1)[:, index], sums.square.sum(axis=1)
    total = gram.sum(axis=0)
    total = total + 1e-9 * np.diag(np.diag(total)) + 1e-9 * np.eye(len(total))
    for weight in 10.0 ** np.arange(8, -3, -0.25):
        theta = np.linalg.solve(total + np.diag(weight * prior), right.sum(axis=0))
        error = square - 2 * right @ theta + np.einsum("aij,i,j->a", gram, theta, theta)
        if np.all(error <= allowed):
            return float(np.sum((theta[len(own) :] / deviation) ** 2))
    return float("inf")
