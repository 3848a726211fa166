"""What a fitted model leaves of the measurements when ordinary tolerances of the vehicle file are taken off as well."""

from __future__ import annotations

import numpy as np

from infotraj.diagnosis.allowance import nuisance
from infotraj.diagnosis.fitting import Fit
from infotraj.diagnosis.search import Search
from infotraj.rotations import Array


def left_over(search: Search, whole: Fit) -> list[list[Array]]:
    """Residuals of the fitted model less what ordinary tolerances explain, one (m, 3) a channel of a flight."""
    joint, found = search.joint(list(whole.members))
    columns, deviation = nuisance(found, search.tolerance)
    index = [*found.of_members, *columns]
    if not index:
        return [[x[:, :, 0] for x in flight] for flight in joint]
    gram, right, _ = search.linear(whole.members)[0].total()
    gram, right = gram.sum(axis=0)[np.ix_(index, index)], right.sum(axis=0)[index]
    prior = np.concatenate([np.full(len(found.of_members), 1e-6), 1 / deviation**2])
    theta = np.linalg.solve(gram + np.diag(prior), right)
    take = np.array(index) + 1
    return [[x[:, :, 0] - x[:, :, take] @ theta for x in flight] for flight in joint]
