"""What may be missing: the effects of the catalogue that these flights can show, and where to linearise them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, TypeVar

import numpy as np

from infotraj.effects.base import Effect, Parameter
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.models.own_effects import is_own, named, require_usable
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

Key = TypeVar("Key")
_NOTHING = 0.01  # of a positive number of the file: less is as good as none


@dataclass(frozen=True)
class Candidate:
    """An effect that may be missing. fixed: values chosen, not fitted (which rotor); form: what is fitted."""

    cls: type[Effect]
    form: tuple[Parameter, ...]
    fixed: tuple[tuple[str, int], ...] = ()

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.cls.name

    @cached_property
    def label(self) -> str:
        """Name, with what is fixed: `rotor_effectiveness 3`."""
        return " ".join([self.name, *(str(v) for _, v in self.fixed)])

    def absent(self, vehicle: Vehicle) -> Effect:
        """The effect at the values that change nothing."""
        values = {p.name: self.cls.absent(vehicle, p) for p in self.form}
        return self.cls(**dict(self.fixed), **_plain(values))

    def at(self, values: Mapping[str, Any]) -> Effect:
        """The effect with these values of its form."""
        return self.cls(**dict(self.fixed), **_plain(values))

    def count(self, vehicle: Vehicle) -> int:
        """How many numbers are fitted."""
        return sum(p.count(vehicle) for p in self.form)


@dataclass(frozen=True)
class Place:
    """Where in an effect's form one fitted number stands, and its coordinate: what is fitted in its place.

    The coordinate of a number that changes a positive one of the file (whole) is that one's logarithm, times whole: a
    factor of 2 is as far away as one of 1/2, and near the absent value it is the number itself. Of others it is the
    number. scale: usual size; low, high: bounds; absent: all of the coordinate.
    """

    parameter: str
    component: int
    scale: float
    low: float
    high: float
    absent: float
    whole: float = 0.0

    def coordinate(self, value: float) -> float:
        """The coordinate of a value."""
        if self.whole <= 0.0:
            return value
        return self.absent + self.whole * float(np.log(max(1.0 + (value - self.absent) / self.whole, _NOTHING)))

    def value(self, coordinate: float) -> float:
        """The value at a coordinate."""
        if self.whole <= 0.0:
            return coordinate
        return self.absent + self.whole * float(np.expm1((coordinate - self.absent) / self.whole))

    def slope(self, value: float) -> float:
        """By how much the value changes with its coordinate."""
        return 1.0 if self.whole <= 0.0 else max(1.0 + (value - self.absent) / self.whole, _NOTHING)


def places(candidate: Candidate, vehicle: Vehicle) -> list[Place]:
    """The fitted numbers of a candidate, in order."""
    return list(_places(candidate.cls, tuple(p.name for p in candidate.form), vehicle))


def firsts(keys: Iterable[Key]) -> dict[Key, int]:
    """The place of the first of each of these keys."""
    found: dict[Key, int] = {}
    for i, key in enumerate(keys):
        found.setdefault(key, i)
    return found


@lru_cache(maxsize=1024)
def _places(cls: type[Effect], form: tuple[str, ...], vehicle: Vehicle) -> list[Place]:
    found = []
    by_name = {p.name: p for p in cls.parameters}
    for p in (by_name[name] for name in form):
        count = p.count(vehicle)
        low, high = (np.broadcast_to(b, count) for b in cls.bounds(vehicle, p))
        absent = cls.absent(vehicle, p)
        scale = np.broadcast_to(cls.scale(vehicle, p), count)
        whole = float(cls.whole(vehicle, p))
        for i in range(count):
            at = Place(p.name, i, float(scale[i]) or 1.0, float(low[i]), float(high[i]), float(absent[i]), whole)
            found.append(replace(at, low=at.coordinate(at.low), high=at.coordinate(at.high)))
    return found


def only_more(candidate: Candidate, place: Place) -> bool:
    """Whether the effect only adds to a number of which the file may declare too much: a lag that is missing is longer,
    while one that corrects the file may be shorter."""
    least = next(p for p in candidate.cls.parameters if p.name == place.parameter).bounds[0]
    return least == place.absent and least > place.low


def raw(effect: Effect, at: Sequence[Place]) -> Array:
    """The fitted numbers of an effect as they are."""
    return np.array([float(np.atleast_1d(getattr(effect, p.parameter))[p.component]) for p in at])


def read(effect: Effect, at: Sequence[Place]) -> Array:
    """The coordinates of the fitted numbers of an effect."""
    return np.array([p.coordinate(v) for p, v in zip(at, raw(effect, at), strict=True)])


def slopes(effect: Effect, at: Sequence[Place]) -> Array:
    """By how much each fitted number of an effect changes with its coordinate."""
    return np.array([p.slope(v) for p, v in zip(at, raw(effect, at), strict=True)])


def written(candidate: Candidate, at: Sequence[Place], x: Array) -> Effect:
    """The effect whose fitted numbers have coordinates x."""
    values: dict[str, Any] = {}
    for place, value in zip(at, x, strict=True):
        values.setdefault(place.parameter, []).append(place.value(float(value)))
    return candidate.at(values)


@dataclass(frozen=True)
class Variant:
    """One linearisation of an absent candidate: the effects at which each column is a secant from the absent one.

    points: (place index, effect at the point, size of the step) of each column; start: values where a fit starts.
    """

    candidate: Candidate
    points: tuple[tuple[int, Effect, float], ...]
    start: Array


def variants(candidate: Candidate, vehicle: Vehicle) -> list[Variant]:
    """The linearisations of a candidate, one for each of its starts.

    A number that changes nothing on its own (the length of a cable without a load) has no column: it is held at the
    start's value.
    """
    at = places(candidate, vehicle)
    absent = np.array([p.absent for p in at])
    found = []
    for values in candidate.cls.starts(vehicle, candidate.form):
        start = read(candidate.at(values), at)
        alone = []
        for i in range(len(at)):
            x = absent.copy()
            x[i] = start[i]
            alone.append(written(candidate, at, x).is_absent(vehicle))
        held = np.where(alone, start, absent)
        points = []
        for i in range(len(at)):
            if alone[i]:
                continue
            x = held.copy()
            x[i] = start[i]
            points.append((i, written(candidate, at, x), float(start[i] - absent[i])))
        found.append(Variant(candidate, tuple(points), np.where(alone, start, absent)))
    return found


def candidates(
    known: Mapping[str, type[Effect]], vehicle: Vehicle, flights: Sequence[Flight]
) -> tuple[list[Candidate], dict[str, str]]:
    """The candidates that at least one flight can show, and for the other effects the reason why none can.

    InputError where an effect of the user's own fails.
    """
    found: list[Candidate] = []
    hidden: dict[str, str] = {}
    for name, cls in known.items():
        with named(cls):
            shown = _shown(cls, vehicle, flights)
        if isinstance(shown, str):
            hidden[name] = shown
        else:
            found += shown
    return found, hidden


def _shown(cls: type[Effect], vehicle: Vehicle, flights: Sequence[Flight]) -> list[Candidate] | str:
    """An effect's candidates, one for each rotor where it is of one, or why no flight can show it."""
    try:
        reasons = [cls.cannot_show(vehicle, flight) for flight in flights]
    except InputError as error:
        return str(error)
    if all(reasons):
        return str(reasons[0])
    form = cls.form(vehicle, flights[0])
    if any(tuple(p.name for p in cls.form(vehicle, f)) != tuple(p.name for p in form) for f in flights):
        return "the flights do not record the same channels for it"
    trial = Candidate(cls, form, _indices(cls, 0))
    start = trial.at(cls.starts(vehicle, form)[0])
    lacking = [r for r in (start.missing(vehicle, f) for f in flights) if r is not None]
    if lacking:
        return lacking[0]
    if is_own(cls):
        require_usable(start, vehicle, flights[0])
    count = len(vehicle.rotors) if trial.fixed else 1
    return [Candidate(cls, form, _indices(cls, i)) for i in range(count)]


def _indices(cls: type[Effect], value: int) -> tuple[tuple[str, int], ...]:
    return tuple((p.name, value) for p in cls.parameters if p.index)


def _plain(values: Mapping[str, Any]) -> dict[str, Any]:
    flat = {k: np.atleast_1d(np.asarray(v, dtype=float)) for k, v in values.items()}
    return {k: float(v[0]) if v.size == 1 else v.tolist() for k, v in flat.items()}
