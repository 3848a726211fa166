"""Which fitted numbers stopped at a physical bound, or where their effect adds nothing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.diagnosis.linear.candidates import only_more, raw, read
from infotraj.diagnosis.linear.observation import Member
from infotraj.vehicle import Vehicle

_SHORT = 1e-3  # of the way from the absent value to a bound: nearer to it is at it


def beyond_bounds(members: Sequence[Member], vehicle: Vehicle) -> dict[str, str]:
    """Labels of members with a number at a physical bound that is not the absent value, and the reason.

    A fit may stop just short of a bound: what is left of the way there no longer pays.
    """
    found = {}
    for m in members:
        values = raw(m.effect, m.places(vehicle))
        for k in _ended(m, vehicle):
            parameter = m.places(vehicle)[k].parameter
            found[m.candidate.label] = f"the fit ends at the physical bound of {parameter} ({values[k]:.3g})"
    return found


def below_file(members: Sequence[Member], vehicle: Vehicle) -> dict[str, str]:
    """Labels of members that add nothing to a number of the file because these flights ask for less, and the words."""
    found = {}
    for m in members:
        at = m.places(vehicle)
        for p, x in zip(at, read(m.effect, at), strict=True):
            if not m.held and only_more(m.candidate, p) and x == p.absent:
                found[m.candidate.label] = (
                    f"the fit ends at {p.parameter} {p.absent:g}, the least that the effect may add; these flights ask "
                    "for less than the file declares, and `infotraj diagnose` says what it should declare"
                )
    return found


def parts_beyond(m: Member, vehicle: Vehicle) -> tuple[int, ...]:
    """The numbers of a vector that are at a physical bound, where others of it are not; places in the effect's form."""
    at, ended = m.places(vehicle), _ended(m, vehicle)
    inside = {p.parameter for k, p in enumerate(at) if k not in ended and read(m.effect, at)[k] != p.absent}
    return tuple(k for k in ended if at[k].parameter in inside)


def _ended(m: Member, vehicle: Vehicle) -> list[int]:
    at = m.places(vehicle)
    out = []
    for k, (p, x) in enumerate(zip(at, read(m.effect, at), strict=True)):
        bounds = [b for b in (p.low, p.high) if np.isfinite(b) and abs(b - p.absent) > 1e-9 * max(1.0, abs(b))]
        if any(abs(x - b) <= _SHORT * abs(b - p.absent) for b in bounds):
            out.append(k)
    return out
