"""A vehicle file whose moments of inertia no body has: one of them is off, and it is said by how much at least."""

from __future__ import annotations

from infotraj.diagnosis.gates.doubt import Doubt
from infotraj.vehicle import Vehicle


def impossible_body(vehicle: Vehicle) -> list[Doubt]:
    """The note, where there is one. It refuses nothing: what these flights say of the moments is told with the file."""
    said = vehicle.inertia.doubt if vehicle.inertia is not None else ""
    reason = f"{vehicle.name}: {said}; measure the moments again"
    return [Doubt("impossible_inertia", "vehicle file", (), reason, refuses=False)] if said else []
