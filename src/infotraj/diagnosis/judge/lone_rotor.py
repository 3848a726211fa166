"""A rotor that is out of line with the others: where the file has all of them wrong by as much, one is still weak.

How far files have rotors wrong in common is no measure of how far one may differ from the others: a weak motor may be
within what a file is off by, and is none of its errors where the others agree. Each is held against the others by the
spread that they have (an outlier test with an exact level; Grubbs 1969), so that as many names are false as it says,
whatever the file. It is named where it takes half of an error off flights that were not fitted.
"""

from __future__ import annotations

import numpy as np
from scipy import stats

from infotraj.diagnosis.judge.evidence import evidence, overdispersion
from infotraj.diagnosis.judge.giving import Given, given
from infotraj.diagnosis.judge.numbers import in_fit
from infotraj.diagnosis.judge.others import beside_others
from infotraj.diagnosis.judge.verdicts import CONFIDENT, HALVES, Finding, group_of
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.prior import Scales
from infotraj.diagnosis.select.search import Search
from infotraj.rotations import Array

LEVEL = 0.01  # of files whose rotors differ at random one in a hundred has a lone one
_ROTOR, _PLACE = "rotor_effectiveness", "com_offset"
_FEWEST = 4  # rotors: with fewer nothing says how much they differ
_NORMAL = stats.norm.ppf((np.arange(2000) + 0.5) / 2000)  # a normal number's quantiles, to average over
_ROUNDS = 4


def with_lone_rotor(
    search: Search, findings: tuple[Finding, ...], told: Fit, made: Given, rng: np.random.Generator
) -> tuple[tuple[Finding, ...], Given]:
    """The findings with the rotor that is out of line with the others, where one is; the model that is given with it.

    told: the set of what is needed, beside a file that is free to be wrong.
    """
    label = lone_rotor(told)
    if label is None or any(f.verdict in CONFIDENT and _ROTOR in (f.name, *f.group) for f in findings):
        return findings, made
    named = [x for x in made.fit.labels if x not in made.beside]
    ratio = [x for x in list(made.of_ratio)[:1] if x not in named]
    tried = [label, *(_PLACE for c in search.known if c.name == _PLACE and _PLACE not in named)]
    fits = {x: search.fitted([*named, *ratio, x], told, Scales(0.0), _ROUNDS, go_on=True) for x in tried}
    falls = {x: evidence(fit, x, rng) for x, fit in fits.items()}
    axis = max(falls[label].falls, key=lambda a: falls[label].falls[a], default="")
    most = falls[label].falls.get(axis, 0.0)
    if most < HALVES:
        return findings, made
    with_it = given(search, told, [*named, label])
    if label in with_it.lost or label in with_it.at_bound:
        return findings, made
    # What leaves twice as much there is told from it.
    group = [x for x, e in falls.items() if e.falls.get(axis, 0.0) > most - HALVES]
    new = {f.name: f for f in group_of([(*in_fit(fits[x], x, told), falls[x]) for x in group])}
    return tuple(new.get(f.name, f) for f in findings), with_it


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
        out[i] = 2.0 * float(np.mean(stats.t.sf((abs(apart[i]) - unknown) / spread, n - 2)))
    return np.minimum(out, 1.0)
