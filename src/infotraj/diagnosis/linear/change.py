"""By how much the numbers of an effect differ from the healthy ones, and how well flights tell that.

Flights tell a change better than they tell the number now: what is not known of the healthy number is in both. A
number that is positive in the file changes by a factor, which holds however far the file is off, others by a
difference.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from infotraj.diagnosis.linear.candidates import Candidate, Place, raw, slopes
from infotraj.effects.base import Effect
from infotraj.vehicle import Vehicle

Numbers = float | list[float | None] | None


@dataclass(frozen=True)
class Change:
    """One number of an effect, or a vector, beside the healthy one; a list where it is a vector.

    name: of what changed; value, standard_error: of the factor (times) or of the difference, None where healthy flights
    do not show the number; unit: of a difference, empty of a factor.
    """

    name: str
    times: bool
    value: Numbers
    standard_error: Numbers
    unit: str = ""

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        kind = "times_healthy" if self.times else "difference"
        return {"name": self.name, kind: self.value, "standard_error": self.standard_error, "unit": self.unit or None}


def changes(
    candidate: Candidate,
    now: Effect,
    healthy: Effect,
    errors: Mapping[str, Any],
    known: Sequence[bool],
    at: Sequence[Place],
    vehicle: Vehicle,
) -> tuple[Change, ...]:
    """The changes of an effect, a parameter each.

    errors: standard errors of the numbers now, by parameter, for a healthy number that is known; known: whether healthy
    flights show each number of `at`.
    """
    spread = np.concatenate([np.atleast_1d(np.asarray(errors.get(p.name, np.nan), float)) for p in candidate.form])
    here, was, slope = raw(now, at), raw(healthy, at), slopes(healthy, at)
    found = []
    for p in candidate.form:
        own = [i for i, place in enumerate(at) if place.parameter == p.name]
        whole = at[own[0]].whole
        values, deviations = here[own] - was[own], spread[own]
        if whole > 0.0:
            size = whole * slope[own]
            values, deviations = 1.0 + values / size, deviations / size
        told = [known[i] and bool(np.isfinite(d)) for i, d in zip(own, deviations, strict=True)]
        if not any(told):
            continue
        # A factor is the number itself; what adds to a number of the file changes that one.
        added = whole > 0.0 and at[own[0]].absent != whole and candidate.cls.declared is not None
        name = candidate.cls.in_the_file(vehicle, own[0], 0)[0] if added else p.name
        unit = "" if whole > 0.0 or p.unit == "-" else p.unit
        found.append(Change(name, whole > 0.0, _plain(values, told), _plain(deviations, told), unit))
    return tuple(found)


def _plain(values: Any, told: Sequence[bool]) -> Numbers:
    out = [float(v) if t else None for v, t in zip(values, told, strict=True)]
    return out[0] if len(out) == 1 else out
