"""The flights at hand and the model that they question: what every stage of a diagnosis works on."""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace

import numpy as np

from infotraj.diagnosis.candidates import Candidate, Place, places, read, written
from infotraj.diagnosis.residual import AXES, FlightSamples
from infotraj.diagnosis.whitened import Blocks, Noise, whiten
from infotraj.diagnosis.whitening import Whitener
from infotraj.effects.base import Effect
from infotraj.errors import InputError
from infotraj.models import Model
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


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
    """Flights as samples, their noise, their blocks, and a vehicle.

    ignored: axes of no weight: no model says them; command_step: s, the longest time between rows with commands.
    """

    vehicle: Vehicle
    samples: tuple[FlightSamples, ...]
    noise: Noise
    blocks: Blocks
    ignored: frozenset[str] = frozenset()
    command_step: float = 0.0

    def model(self, members: Sequence[Member]) -> Model:
        """The vehicle with these effects."""
        return Model(self.vehicle, [m.effect for m in members])

    def raw(self, model: Model) -> list[list[Array]] | None:
        """Residuals of all flights; None where the model cannot be evaluated."""
        try:
            # Numbers far from any flight may overflow: such a model is not one.
            with np.errstate(all="ignore"):
                found = [s.residual(model) for s in self.samples]
        except InputError:
            return None
        return found if all(np.isfinite(x).all() for flight in found for x in flight) else None

    def whitened(self, raw: Sequence[Sequence[Array]]) -> Array:
        """Whitened residuals of all flights in one vector."""
        parts = []
        for s, flight in zip(self.samples, raw, strict=True):
            parts += [w.reshape(-1) for w in whiten(s, self.noise, [r[:, :, None] for r in flight])]
        return np.concatenate(parts)

    def split(self, columns: Array) -> list[list[Array]]:
        """Vectors (total, c) back to one (m, 3, c) a channel of a flight."""
        out, start = [], 0
        for s in self.samples:
            parts = []
            for c in s.channels:
                stop = start + 3 * len(c.last)
                parts.append(columns[start:stop].reshape(len(c.last), 3, -1))
                start = stop
            out.append(parts)
        return out

    def with_noise(self, noise: Noise) -> Observation:
        """The same flights under another noise model."""
        return replace(self, noise=_without(noise, self.ignored))

    def without_axes(self, axes: AbstractSet[str]) -> Observation:
        """The same flights with these axes, by name, left out of everything that is weighed."""
        ignored = self.ignored | axes
        return replace(self, ignored=ignored, noise=_without(self.noise, ignored))


def _without(noise: Noise, axes: AbstractSet[str]) -> Noise:
    silent = Whitener(None, np.zeros(0), np.inf)
    return {
        key: tuple(silent if a in axes else w for a, w in zip(AXES[key.split()[0]], three, strict=True))
        for key, three in noise.items()
    }


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
