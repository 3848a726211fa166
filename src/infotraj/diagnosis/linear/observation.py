"""The flights at hand and the model that they question: what every stage of a diagnosis works on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from infotraj.diagnosis.linear.candidates import Candidate, Place, places, read, written
from infotraj.diagnosis.linear.healthy import Healthy
from infotraj.diagnosis.linear.sums import Blocks
from infotraj.diagnosis.measure.lapped import Lapped
from infotraj.diagnosis.measure.residual import AXES, FlightSamples
from infotraj.effects.base import Effect
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_DENSE = 0.012  # s between rows: the column of a lag is right to 1 % then, at a time constant of 30 ms


@dataclass(frozen=True)
class Member:
    """An effect that is in the model now, as a candidate with its values. `held`: it may not be taken out."""

    candidate: Candidate
    effect: Effect
    held: bool = False

    def places(self, vehicle: Vehicle) -> list[Place]:
        """Its fitted numbers."""
        return places(self.candidate, vehicle)


@dataclass(frozen=True)
class Observation:
    """Flights as samples, their transforms, their blocks, and a vehicle.

    ignored: axes of no weight; command_step: s, the longest time between rows with commands; healthy: what these
    flights are held against, in place of the vehicle file; balance: axes of which only the balance over seconds counts;
    scatter: by label and place, what a number differs by from flight to flight, usual sizes; still: label and place of
    numbers that stay absent.
    """

    vehicle: Vehicle
    samples: tuple[FlightSamples, ...]
    transforms: tuple[tuple[Lapped, ...], ...]
    blocks: Blocks
    ignored: frozenset[str] = frozenset()
    command_step: float = 0.0
    healthy: Healthy | None = None
    balance: frozenset[str] = frozenset()
    scatter: Mapping[tuple[str, int], float] = field(default_factory=dict)
    still: frozenset[tuple[str, int]] = frozenset()

    @property
    def flights(self) -> list[Flight]:
        """The flights themselves."""
        return [s.flight for s in self.samples]

    @property
    def turned(self) -> tuple[bool, ...]:
        """About which of the body's axes it turns as recorded, where forces beside the origin are predicted."""
        return tuple(a in self.ignored for a in AXES["rate"])

    @cached_property
    def coarse(self) -> tuple[FlightSamples, ...]:
        """The same samples for how predictions change with a number: means of fewer points, the IMU without its noise.

        Of a slow log all points: between rows that are far apart actuators move by more than fewer can say.
        """
        return tuple(
            replace(s, prepared=s.prepared.of(coarse=dense, quiet=True))
            for s, dense in ((s, float(np.median(np.diff(s.flight.t))) <= _DENSE) for s in self.samples)
        )

    def model(self, members: Sequence[Member]) -> Model:
        """The vehicle with these effects, and with what is healthy beside them."""
        taken = {m.candidate.label for m in members}
        base = self.healthy.effects if self.healthy is not None else {}
        return Model(self.vehicle, [*(e for k, e in base.items() if k not in taken), *(m.effect for m in members)])

    def base(self, candidate: Candidate) -> Effect:
        """A candidate as it is before anything is found: absent, or healthy."""
        return candidate.absent(self.vehicle) if self.healthy is None else self.healthy.values(candidate, self.vehicle)

    def raw(self, model: Model) -> list[list[Array]] | None:
        """Residuals of all flights; None where the model cannot be evaluated."""
        try:
            # Numbers far from any flight may overflow: such a model is not one.
            with np.errstate(all="ignore"):
                found = [s.residual(model) for s in self.samples]
        except InputError:
            return None
        return found if all(np.isfinite(x).all() for flight in found for x in flight) else None

    def of_flight(self, number: int) -> Observation:
        """One of the flights alone, for its residual: blocks are those of all."""
        return replace(self, samples=(self.samples[number],))

    def without_axes(self, axes: AbstractSet[str]) -> Observation:
        """The same flights with these axes, by name, left out of everything that is weighed.

        About an axis whose torque is not believed the vehicle turns as it was recorded to, for forces beside it.
        """
        made = replace(self, ignored=self.ignored | axes)
        if made.turned == self.turned:
            return made
        return replace(made, samples=tuple(replace(s, prepared=s.prepared.turning(made.turned)) for s in self.samples))


def packed(members: Sequence[Member], vehicle: Vehicle) -> tuple[Array, list[tuple[int, Place]]]:
    """Fitted numbers of all members, each in units of its scale, and whose they are."""
    x, owner = [], []
    for number, m in enumerate(members):
        at = m.places(vehicle)
        x.append(read(m.effect, at) / [p.scale for p in at])
        owner += [(number, p) for p in at]
    return (np.concatenate(x) if x else np.zeros(0)), owner


def unpacked(members: Sequence[Member], vehicle: Vehicle, x: Array) -> list[Member]:
    """The members with fitted numbers x."""
    out, start = [], 0
    for m in members:
        at = m.places(vehicle)
        values = x[start : start + len(at)] * np.array([p.scale for p in at])
        values = np.clip(values, [p.low for p in at], [p.high for p in at])
        out.append(replace(m, effect=written(m.candidate, at, values)))
        start += len(at)
    return out


def inward(value: float, place: Place, step: float) -> float:
    """A step of this size that stays within the bounds."""
    return step if value + step <= place.high else -step
