"""What changes of the mass and of the centre of mass are together: a load that was put on, or a part that is gone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.rotations import Array

_NAMED = ("Supported", "Not separable")
_SURE = 3.0  # standard errors of the mass: of one that may be none no place is told
_RIGHT = 1.0  # times 1 %: beside a file that is further off, a load is not told from what the file has wrong


@dataclass(frozen=True)
class AddedLoad:
    """mass: kg, below zero of a part that is gone, and its standard error. place (3,): m, its centre of mass from the
    body's origin in body axes, and standard errors (3,). or_else: names that the flights do not tell from a change of
    the mass or of its centre."""

    mass: float
    mass_error: float
    place: Array
    place_errors: Array
    or_else: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "mass": self.mass,
            "mass_error": self.mass_error,
            "place": self.place.tolist(),
            "place_errors": self.place_errors.tolist(),
            "or_else": list(self.or_else),
            "sentence": self.sentence(),
        }

    def sentence(self) -> str:
        """In words."""
        what = "a load" if self.mass > 0 else "a part gone"
        place, errors = (", ".join(f"{round(1000 * v)}" for v in x) for x in (self.place, self.place_errors))
        only = f", if it is no {' or '.join(self.or_else)}" if self.or_else else ""
        return (
            f"mass and centre of mass together{only}: {what} of {abs(self.mass):.3g} +- {self.mass_error:.2g} kg "
            f"at ({place}) +- ({errors}) mm from the body's origin"
        )


def added_load(found: Diagnosis) -> AddedLoad | None:
    """The load, where both changes are named; None where one is not, the mass is not sure, the file is wrong, or a
    coordinate of the centre stayed absent.

    First moments add up: m c = m0 c0 + dm r, with the mass m and the centre c after the change, m0 and c0 before it.
    Errors of mass and centre are taken as independent.
    """
    mass, centre = (next((f for f in found.findings if f.name == n), None) for n in ("mass_offset", "com_offset"))
    vehicle = found.model.vehicle
    if mass is None or centre is None or not vehicle.mass:
        return None
    if mass.verdict not in _NAMED or centre.verdict not in _NAMED:
        return None
    if found.healthy is None and found.whole.scales.common > _RIGHT:
        return None
    if any(label == centre.name for label, _ in found.whole.linear.observation.still):
        return None
    dm0, shift0 = 0.0, np.zeros(3)
    if found.healthy is not None:
        before = [found.healthy_numbers(f) for f in (mass, centre)]
        if before[0] is None or before[1] is None:
            return None
        dm0, shift0 = before[0]["parameters"]["dm"], np.array(before[1]["parameters"]["r"])
    more, sure = mass.parameters["dm"] - dm0, mass.standard_errors["dm"]
    if not abs(more) > _SURE * sure:
        return None
    m0, c0 = vehicle.mass + dm0, np.array(vehicle.center_of_mass) + shift0
    c = np.array(vehicle.center_of_mass) + np.array(centre.parameters["r"])
    place = ((m0 + more) * c - m0 * c0) / more
    errors = np.hypot((m0 + more) / more * np.array(centre.standard_errors["r"]), (c - place) / more * sure)
    or_else = dict.fromkeys(n for f in (mass, centre) for n in f.group if n not in (mass.name, centre.name))
    return AddedLoad(float(more), float(sure), place, errors, tuple(or_else))
