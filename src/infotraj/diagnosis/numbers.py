"""The numbers of fitted effects and their standard errors, by parameter."""

from __future__ import annotations

from typing import Any

import numpy as np

from infotraj.diagnosis.candidates import places
from infotraj.diagnosis.evidence import standard_errors
from infotraj.diagnosis.fitting import Fit
from infotraj.diagnosis.observation import Member
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


def values_of(m: Member) -> dict[str, Any]:
    """What is fixed and what is fitted of a member, other forms of the effect left out."""
    wanted = {*dict(m.candidate.fixed), *(p.name for p in m.candidate.form)}
    return {k: v for k, v in m.effect.values.items() if k in wanted}


def fitted_numbers(made: Fit, vehicle: Vehicle, widen: float = 1.0, more: Array | float = 0.0) -> list[dict[str, Any]]:
    """Standard errors of every member of a fit by parameter, times `widen`; more (p,): variance added, usual sizes."""
    return [by_parameter(m, e) for m, e in zip(made.members, errors_of(made, vehicle, widen, more), strict=True)]


def errors_of(made: Fit, vehicle: Vehicle, widen: float, more: Array | float) -> list[Array]:
    """Standard errors of every member's numbers, in their units, times `widen`."""
    gram, right, _ = made.sums.total()
    all_of_them = np.sqrt((widen * standard_errors(gram, right)) ** 2 + more)
    out, place = [], 0
    for m in made.members:
        at = places(m.candidate, vehicle)
        out.append(all_of_them[place : place + len(at)] * np.abs([p.scale for p in at]))
        place += len(at)
    return out


def by_parameter(m: Member, values: Array) -> dict[str, Any]:
    """Numbers of a member by parameter, a list where the parameter is one."""
    out, place = {}, 0
    for p in m.candidate.form:
        size = np.size(getattr(m.effect, p.name))
        part = [float(v) for v in values[place : place + size]]
        out[p.name] = part[0] if p.size == 1 else part
        place += size
    return out
