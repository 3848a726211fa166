"""A rotor that is out of line with the others: where the file has all of them wrong by as much, one is still weak.

How far files have rotors wrong in common is no measure of how far one may differ from the others: a weak motor may be
within what a file is off by, and is none of its errors where the others agree. Each is held against the others by the
spread that they have (an outlier test with an exact level; Grubbs 1969), so that as many names are false as it says,
whatever the file.
"""

from __future__ import annotations

import numpy as np
from scipy import special

from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.judge.others import beside_others
from infotraj.diagnosis.select.fit import Fit
from infotraj.rotations import Array

LEVEL = 0.01  # of files whose rotors differ at random one in a hundred has a lone one
_ROTOR = "rotor_effectiveness"
_FEWEST = 4  # rotors: with fewer nothing says how much they differ
_NORMAL = special.ndtri((np.arange(2000) + 0.5) / 2000)  # a normal number's quantiles, to average over


def lone_rotor(told: Fit) -> str | None:
    """The label of the rotor whose thrust is out of line with that of the others, if one is; how far a file may be
    off is not asked."""
    columns, vehicle = told.linear.columns, told.linear.observation.vehicle
    own = [i for i, c in enumerate(columns) if c.candidate.name == _ROTOR and c.candidate.label not in told.labels]
    if told.linear.observation.healthy is not None or len(own) < max(_FEWEST, len(vehicle.rotors)):
        return None
    size = np.array([columns[i].scale for i in own])
    factor = told.solution.theta[own] * size
    covariance = overdispersion(told)[1][np.ix_(own, own)] * np.outer(size, size)
    chance = chance_of_each(factor, covariance)
    least = int(np.argmin(chance))
    return columns[own[least]].candidate.label if chance[least] * len(own) < LEVEL else None


def chance_of_each(x: Array, covariance: Array) -> Array:
    """How often a number of n that differ at random lies as far from the others as each of x (n,) does, (n,).

    The others' spread says how far one may be off (Student's t), and covariance (n, n) what is not known of x (normal).
    """
    n = len(x)
    out = np.ones(n)
    apart, error = beside_others(x, covariance)
    for i in range(n):
        spread = max(float(np.std(np.delete(x, i), ddof=1)) * np.sqrt(n / (n - 1)), 1e-300)
        unknown = error[i] * _NORMAL if error[i] > 0.0 else np.zeros(1)
        out[i] = 2.0 * float(np.mean(special.stdtr(n - 2, (unknown - abs(apart[i])) / spread)))
    return np.minimum(out, 1.0)
