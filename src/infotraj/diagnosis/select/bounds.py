"""Which fitted numbers stopped at a physical bound."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.diagnosis.linear.candidates import raw, read
from infotraj.diagnosis.linear.observation import Member
from infotraj.vehicle import Vehicle

_SHORT = 1e-3  # of the way from the absent value to a bound: nearer to it is at it


def beyond_bounds(members: Sequence[Member], vehicle: Vehicle) -> dict[str, str]:
    """Labels of members with a number at a physical bound that is not the absent value, and the reason.

    A fit may stop just short of a bound: what is left of the way there no longer pays.
    """
    found = {}
    for m in members:
        at = m.places(vehicle)
        for p, x, value in zip(at, read(m.effect, at), raw(m.effect, at), strict=True):
            bounds = [b for b in (p.low, p.high) if np.isfinite(b) and abs(b - p.absent) > 1e-9 * max(1.0, abs(b))]
            if any(abs(x - b) <= _SHORT * abs(b - p.absent) for b in bounds):
                found[m.candidate.label] = f"the fit ends at the physical bound of {p.parameter} ({value:.3g})"
    return found
