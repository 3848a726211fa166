"""Whether ordinary tolerances of a vehicle explain what an effect explains: then it is real, but it does not matter.

No vehicle file is right to the last digit: rotors differ by a per cent, an inertia by two, a time stamp by a fraction
of a row. Minutes of data find each of these with certainty. So effects count as within tolerance when small changes of
such numbers, together, leave no more error than the limit of what matters, or little and a fifth of it at most. The
least of them is found by a prior of these standard deviations whose weight grows until the error rises by that limit
(Tikhonov; Morozov's discrepancy principle, 1966).

Where the flights showed the file to be exact (`allowance`), nothing is ordinary: what is off is off on its own. Only
when commands acted stays uncertain where they were logged now and then.
"""

from __future__ import annotations

from collections.abc import Set

import numpy as np

from infotraj.diagnosis.allowance import nuisance, unsure, without_tolerances
from infotraj.diagnosis.fitting import Fit
from infotraj.diagnosis.search import INEXACT, Search
from infotraj.diagnosis.sensitivities import Sensitivities
from infotraj.diagnosis.sums import Sums
from infotraj.rotations import Array

TOGETHER = 10.0  # sum of squares, in standard deviations, that is ordinary (95 % of chi squared, four to five numbers)

_CERTAIN = 1e-4  # s: when commands acted is known
_REST = 0.2  # of what is lost without some effects: tolerances that explain all but as much explain them
_FEW = 1.5  # times what matters: the most that may be left so


def tolerated(search: Search, whole: Fit) -> frozenset[str]:
    """Labels of the members of the fitted model `whole` that tolerances explain, all of them together."""
    if search.tolerance < INEXACT and unsure(search.observation.command_step) < _CERTAIN:
        # The flights showed the vehicle file to be exact: what is off is off on its own.
        return frozenset()
    # What tolerances explain beside the whole model they must explain in its parts too, and are not charged for.
    beside, own = search.linear(whole.members)
    best = reached(without_tolerances(beside, own, search.tolerance), whole.sums)
    windows = whole.sums.windows.sum(axis=1)

    def least(labels: Set[str]) -> float:
        """Least sum of squares, in standard deviations, that explains what these members explain; inf if none does."""
        out = search.fitted([m for m in whole.members if m.candidate.label not in labels])
        if out is None:
            return float("inf")
        sums, found = search.linear(out.members)
        columns, deviation = nuisance(found, search.tolerance)
        lost = (sums.square.sum(axis=1) - best) / windows
        allowed = best + windows * np.clip(_REST * lost, search.matters, _FEW * search.matters)
        sure = least_tolerance(beside, own, *nuisance(own, search.tolerance), allowed)
        sure = sure if np.isfinite(sure) else 0.0
        return least_tolerance(sums, found, columns, deviation, allowed) - sure if columns else float("inf")

    alone = {m.candidate.label: least({m.candidate.label}) for m in whole.members if not m.held}
    suspects = {label: size for label, size in alone.items() if size <= 3 * TOGETHER}
    while suspects:
        size = least(set(suspects)) if len(suspects) > 1 else next(iter(suspects.values()))
        if size <= TOGETHER:
            return frozenset(suspects)
        del suspects[max(suspects, key=suspects.get)]
    return frozenset()


def reached(tolerant: Sums, plain: Sums) -> Array:
    """Squared error (axes,) of a model with or without tolerances taken off, whichever leaves less of an axis.

    Of all blocks together: no model is now the one, now the other.
    """
    return np.minimum(tolerant.square.sum(axis=1), plain.square.sum(axis=1))


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
