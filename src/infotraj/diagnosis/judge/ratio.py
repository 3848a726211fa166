"""Thrust over mass as a finding: where it is out of line with the rest of the file, what says so is named.

Accelerations tell the ratio, and not whether the thrust or the mass is off, so that each alone may be within what a
file is off by, and no effect is needed beside a file that is free to be wrong. Where the ratio is further off than in
the worst of files, and what corrects it takes half of an error off flights that were not fitted, staying silent would
leave the largest error without a name.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from infotraj.diagnosis.gates import refusal
from infotraj.diagnosis.judge.evidence import evidence
from infotraj.diagnosis.judge.giving import Given
from infotraj.diagnosis.judge.numbers import in_fit, out_of_line
from infotraj.diagnosis.judge.verdicts import CONFIDENT, HALVES, Finding, group_of
from infotraj.diagnosis.select.fit import Fit

_MOSTLY = 0.5  # of what the best takes off that axis: what takes as much is not told from it


def with_ratio(
    findings: tuple[Finding, ...], told: Fit, made: Given, rng: np.random.Generator
) -> tuple[tuple[Finding, ...], Given]:
    """The findings with what corrects the file's thrust over mass, where that is one; the model that is given with it.

    told: the set of what is needed, beside a file that is free to be wrong.
    """
    best = next(iter(made.of_ratio), "")
    named = {f.name for f in findings if f.verdict in CONFIDENT}
    if best not in made.beside or not out_of_line(told, named):
        return findings, made
    falls = {x: evidence(fit, x, rng) for x, fit in made.of_ratio.items()}
    forces = {a: x for a, x in falls[best].falls.items() if (refusal.axis_group(a) or "")[:1] == "f"}
    axis = max(forces, key=lambda a: forces[a], default="")
    most = forces.get(axis, 0.0)
    if most < HALVES:
        return findings, made
    group = [x for x, e in falls.items() if e.falls.get(axis, 0.0) >= _MOSTLY * most]
    new = {f.name: f for f in group_of([(*in_fit(made.of_ratio[x], x, told), falls[x]) for x in group])}
    return tuple(new.get(f.name, f) for f in findings), replace(made, beside=tuple(x for x in made.beside if x != best))
