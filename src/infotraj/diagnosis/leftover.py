"""What a fitted model leaves of the measurements when ordinary tolerances of the vehicle file are taken off as well."""

from __future__ import annotations

import numpy as np

from infotraj.diagnosis.allowance import beside_members, nuisance
from infotraj.diagnosis.fitting import Fit
from infotraj.diagnosis.search import Search
from infotraj.rotations import Array


def left_over(search: Search, whole: Fit) -> list[list[Array]]:
    """Residuals of the fitted model less what ordinary tolerances explain, one (m, 3) a channel of a flight."""
    joint, found = search.joint(list(whole.members))
    columns, deviation = nuisance(found, search.tolerance)
    sums = search.linear(whole.members)[0]
    theta = beside_members(sums, found, columns, deviation)
    take = np.flatnonzero(theta)
    return [[x[:, :, 0] - x[:, :, 1 + take] @ theta[take] for x in flight] for flight in joint]
