"""What is known of every number before a flight is seen: how far vehicle files are off, and how large effects are.

Every number of the vehicle file has a spike: it is near what the file says, by as much as files are off. How much that
is here, from exact to ten times ordinary, is learned from the flights, in common and for each kind of number. What is
missing has a slab: numbers of its usual size (spike and slab: George and McCulloch 1993). A number may have both: then
it is an effect only where it is far off for this file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.effects.base import Effect
from infotraj.effects.inertia_products import InertiaProducts
from infotraj.effects.rotor_height import RotorHeight
from infotraj.effects.rotor_torque import RotorTorque, arms
from infotraj.effects.sensor_place import SensorPlace
from infotraj.flight import Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

SLAB = 2.0  # usual sizes: standard deviation of the numbers of an effect
EACH = 5.0  # nats that a further effect costs before its numbers: of 150 effects one is missing
CHANGED = 3.4  # the same of what differs from healthy flights: it is asked where something did, one of 30 effects
REBUILT = 2.3  # nats more of what changes where parts are exchanged alone: ten times less likely than another
STATE = 2.0  # nats of a number that is found for one flight: it is told to an eighth of what it may be
SCALES = (0.05, 0.3, 1.0, 3.0, 9.0)  # of all numbers of a file together, times what their effects say (`Declared`)
KIND_SPREAD = 0.4  # standard deviation of the logarithm by which a kind's scale differs from the common one
OF_THE_LOG = ("clock", "mount")
IN_NO_FILE = ("air", "axes")  # kinds that files leave out
_AS_EVER = (*OF_THE_LOG, *IN_NO_FILE)  # kinds that are no worse for what a file says of the vehicle
TIMES = ("time", "clock")
STAMP = 0.1  # of the time between commands: their stamps are hardly more exact
PULL = 0.0015  # of a mass, a thrust: gravity is 9.78 to 9.83 m/s^2 from place to place (WGS 84), evenly


@dataclass(frozen=True)
class Scales:
    """How far this file is off, times 1 %: in common, and by kind of number. 0 in common: it is taken as it is.

    corrects: labels of what is no finding but corrects the file: it is chosen, and as far off as the file.
    """

    common: float
    kinds: dict[str, float] = field(default_factory=dict)
    corrects: frozenset[str] = frozenset()

    def of(self, kind: str) -> float:
        """The scale of a kind."""
        return 1.0 if kind in _AS_EVER and self.common > 0.0 else self.kinds.get(kind, self.common)

    def times(self, factor: float) -> Scales:
        """The same for a file that is further off by a factor."""
        return replace(self, common=factor * self.common, kinds={k: factor * x for k, x in self.kinds.items()})

    def cost(self) -> float:
        """Nats that kinds cost which differ from the common scale."""
        apart = np.log([x / self.common for x in self.kinds.values()])
        return float(0.5 * np.sum((apart / KIND_SPREAD) ** 2)) if len(apart) else 0.0


def is_file_number(candidate: Candidate) -> bool:
    """Whether a candidate's numbers are numbers of the vehicle file, or of the clocks and frames of its log."""
    return candidate.cls.declared is not None


def spikes(owners: Sequence[tuple[Candidate, float]], scales: Scales, command_step: float, vehicle: Vehicle) -> Array:
    """Standard deviation (p,) of every column's file number in usual sizes, 0 for a column that is no file number.

    owners: candidate and usual size of each column; command_step: s, the longest time between commands.
    """
    out = np.zeros(len(owners))
    if scales.common == 0.0:
        return out
    for i, (candidate, size) in enumerate(owners):
        if candidate.cls.declared is None:
            continue
        kind, most = candidate.cls.declared.kind, candidate.cls.declared.most
        out[i] = min(scales.of(kind), most) * candidate.cls.declared_deviation(vehicle, size)
        out[i] = np.hypot(out[i], stamped(candidate, command_step) / abs(size))
    return out


def stamped(candidate: Candidate, command_step: float) -> float:
    """How exactly stamps tell a candidate's times, s; 0 where its numbers are none."""
    declared = candidate.cls.declared
    return STAMP * command_step if declared is not None and declared.kind in TIMES else 0.0


def file_only(vehicle: Vehicle, known: Sequence[Candidate], flights: Sequence[Flight]) -> list[Candidate]:
    """Candidates for numbers of the file and of its logs that are no effect: they may be off, and are never named."""
    found: list[Candidate] = []
    if any(c.name == "com_offset" for c in known) and all(SensorPlace.cannot_show(vehicle, f) is None for f in flights):
        found.append(Candidate(SensorPlace, SensorPlace.parameters))
    if not vehicle.rotors or not any(c.name == "rotor_effectiveness" for c in known) or vehicle.inertia is None:
        return found
    of_arms: list[type[Effect]] = [RotorTorque]
    if any(c.name in RotorHeight.beside for c in known):
        of_arms.append(RotorHeight)
    for cls in of_arms:
        form = tuple(p for p in cls.parameters if not p.index)
        found += [Candidate(cls, form, (("rotor", i),)) for i in arms(vehicle)]
    return found


def price(candidate: Candidate, alike: int, flights: int, changed: bool = False) -> float:
    """Nats that naming this candidate costs before a flight is seen. alike: candidates of the same name; changed: it is
    asked what differs from healthy flights."""
    if candidate.cls in (RotorTorque, RotorHeight, SensorPlace, InertiaProducts):
        return float("inf")
    each = CHANGED + REBUILT * candidate.cls.built if changed else EACH
    return each + float(np.log(max(alike, 1))) + STATE * candidate.cls.states * flights
