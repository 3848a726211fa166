"""Numbers of the vehicle file that are no further off than this file is: they are the file's, and nothing is missing.

A file whose rotors agree with one another looks exact, and its mass, its inertia and the thrust of all rotors, each of
which is one number, then look like so many missing effects. How far such a file is off is told by its other kinds of
numbers; how far one rotor may differ, by the other rotors. What is within that is corrected, and not named.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence

import numpy as np

from infotraj.diagnosis.judge.anchor import errors_beside, kinds_off
from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.judge.groups import Rival
from infotraj.diagnosis.judge.numbers import OF_THRUST_OVER_MASS, ORDINARY, out_of_line, thrust_over_mass
from infotraj.diagnosis.judge.others import beside_others
from infotraj.diagnosis.judge.verdicts import CONFIDENT, Finding
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.prior import SCALES, Scales

_ONE_NUMBER = ("inertia", "moment")  # kinds of which the file holds one effect
_RATIO = 0.011  # of thrust over mass, in a file that is right to 1 %: all thrusts by 1 %, the mass by half of that
_ROTOR = "rotor_effectiveness"


def in_line(findings: Sequence[Finding], told: Fit, stand: Mapping[str, Rival]) -> dict[str, str]:
    """Names told with confidence that are what this file is off by, and the reason; none against healthy flights.

    told: the set of what is needed, beside a file that is free to be wrong; stand: fits of what stands for a group, by
    name. Of names that flights do not tell apart all have to be the file's.
    """
    if told.linear.observation.healthy is not None:
        return {}
    sure = {f.name: f for f in findings if f.verdict in CONFIDENT}
    off = _off(told) if sure else 0.0
    inside = {x.split()[0] for x in told.labels}
    fits = {n: told if n in inside or n not in stand else stand[n].fit for n in sure}
    why = {n: reason for n, fit in fits.items() if (reason := _ordinary(n, fit, off, sure))}
    while True:
        together = {x for f in sure.values() if not {f.name, *f.group} <= why.keys() for x in (f.name, *f.group)}
        if not together & why.keys():
            return why
        why = {n: reason for n, reason in why.items() if n not in together}


def _off(told: Fit) -> float:
    """How far this file is off, times 1 %: one kind of number, or two, may be off by what is missing."""
    _, second, third, *_ = kinds_off(told)
    return float(np.clip(np.sqrt(second * third), min(SCALES), max(SCALES)))


def _ordinary(name: str, told: Fit, off: float, sure: Iterable[str]) -> str:
    """Why the numbers of an effect are within what this file is off by; empty where they are not, or are no file's."""
    columns, theta = told.linear.columns, told.solution.theta
    if name in OF_THRUST_OVER_MASS:
        named = set(sure) - OF_THRUST_OVER_MASS
        if not _shows_ratio(told, named) or out_of_line(told, named):
            return ""
        least = ORDINARY * _RATIO * off
        return _words(off) if all(abs(np.log(n.value)) < least for n in thrust_over_mass(told, named)) else ""
    if name == _ROTOR:
        each = max(told.scales.of("rotors"), min(off, 1.0))
        return _words(each) if _alike(told, each) else ""
    own = [i for i, c in enumerate(columns) if c.candidate.name == name and c.candidate.label in told.labels]
    declared = columns[own[0]].candidate.cls.declared if own else None
    if declared is None or declared.kind not in _ONE_NUMBER:
        return ""
    error = np.hypot(errors_beside(told, off), told.linear.spike(Scales(off)))[own]
    return _words(off) if np.all(np.abs(theta[own]) < ORDINARY * error) else ""


def _shows_ratio(told: Fit, named: Container[str]) -> bool:
    """Whether these flights have a thrust over mass that is not told by another name."""
    rotors = [c.candidate for c in told.linear.columns if c.candidate.name == _ROTOR]
    others = [c for c in rotors if _ROTOR not in named or c.label not in told.labels]
    lost = any(x.split()[0] == "coaxial_loss" for x in told.labels)
    return bool(told.linear.observation.vehicle.mass) and not lost and bool(others or not rotors)


def _alike(told: Fit, each: float) -> bool:
    """Whether no rotor of the set is further from the others than its own error, each times 1 %, makes it."""
    columns = told.linear.columns
    ordinary = told.linear.spike(Scales(each))
    every = [i for i, c in enumerate(columns) if c.candidate.name == _ROTOR and ordinary[i] > 0.0]
    mine = [k for k, i in enumerate(every) if columns[i].candidate.label in told.labels]
    covariance = overdispersion(told)[1][np.ix_(every, every)]
    apart, error = beside_others(told.solution.theta[every], covariance)
    within = np.abs(apart) < ORDINARY * np.hypot(error, ordinary[every])
    return bool(mine) and bool(within[mine].all())


def _words(off: float) -> str:
    return f"it is no further off than this vehicle file is ({off:.2g} times 1 %): the file's own error"
