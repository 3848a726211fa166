"""A doubt: why some axes of these flights cannot be judged, or what a reader must know before believing an answer."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from infotraj.checking.acceptance import accepted_codes
from infotraj.comparing.equation_error import AXES
from infotraj.diagnosis.measure.residual import FlightSamples
from infotraj.flight import Flight
from infotraj.vehicle import Vehicle


@dataclass(frozen=True)
class Doubt:
    """Why axes cannot be judged.

    code: as `--accept` takes it; about: the premise, or the axis; axes: of AXES, those that it takes out; reason: one
    line, with the numbers. refuses: False for what is said and takes nothing out. unordered: it is not known which
    column belongs to which actuator. accepted: the user has overruled it.
    """

    code: str
    about: str
    axes: tuple[str, ...]
    reason: str
    refuses: bool = True
    unordered: bool = False
    accepted: bool = False

    @property
    def counts(self) -> bool:
        """Whether it takes its axes out."""
        return self.refuses and not self.accepted

    def as_dict(self) -> dict[str, Any]:
        """For JSON, beside the findings about the flights."""
        severity = "refusal" if self.refuses else "warning"
        return {"code": self.code, "severity": severity, "what": self.reason, "axes": list(self.axes)}


def as_accepted(doubts: Iterable[Doubt], flights: Sequence[Flight]) -> tuple[Doubt, ...]:
    """The doubts, marked where every flight accepts them: they are drawn from all flights together."""
    common = frozenset.intersection(*(accepted_codes(f) for f in flights))
    return tuple(replace(d, accepted=d.code in common) for d in doubts)


def once(doubts: Iterable[Doubt]) -> tuple[Doubt, ...]:
    """The doubts, each only once."""
    return tuple({(d.code, d.about): d for d in doubts}.values())


def refused_axes(doubts: Iterable[Doubt]) -> dict[str, str]:
    """The axes fx .. tz that cannot be judged, with the first reason of each, in the order of AXES."""
    first: dict[str, str] = {}
    for doubt in doubts:
        for axis in doubt.axes if doubt.counts else ():
            first.setdefault(axis, doubt.reason)
    return {axis: first[axis] for axis in AXES if axis in first}


def with_mixed(refused: dict[str, str], samples: Sequence[FlightSamples]) -> dict[str, str]:
    """The refused axes, and those that cannot be told from them: force measured by a velocity in the world's axes."""
    forces = [a for a in AXES[:3] if a in refused]
    if not forces or not any(c.name == "velocity" for s in samples for c in s.channels):
        return refused
    reason = refused[forces[0]]
    every = {**{a: reason for a in AXES[:3]}, **refused}
    return {a: every[a] for a in AXES if a in every}


def of_residual(refused: Iterable[str]) -> frozenset[str]:
    """Names of these axes in the residual's channels: a force may be measured by the velocity's axes."""
    return frozenset(name for a in refused for name in ((a, "v" + a[1]) if a[0] == "f" else (a,)))


def reached(vehicle: Vehicle) -> tuple[str, ...]:
    """The axes on which this vehicle's actuators act: not the side force of rotors that all point up."""
    pushes = [vehicle.thrust_axis] if vehicle.inputs == "wrench" else [r.axis for r in vehicle.rotors]
    if vehicle.tilts or None in pushes:
        return AXES
    directions = np.abs([np.asarray(axis, dtype=float) / np.linalg.norm(axis) for axis in pushes if axis is not None])
    acts = [*(directions.max(axis=0) > 1e-3), True, True, True]
    return tuple(a for a, yes in zip(AXES, acts, strict=True) if yes)
