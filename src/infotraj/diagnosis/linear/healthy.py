"""What healthy flights of a vehicle say of every number of its model, where later flights are held against them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from infotraj.diagnosis.linear.candidates import Candidate, Place, firsts, read, slopes, written
from infotraj.effects.base import Effect
from infotraj.flight import Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


@dataclass(frozen=True)
class Healthy:
    """The model as healthy flights have it, and how well they know it.

    effects: those that are not absent, by label; owners: label and place of each number that they could show;
    rather (q,), covariance (q, q): what the flights would rather have these numbers be than what `effects` and file
    say, and how well they know that, usual sizes; scatter (q,): what each differs by from healthy flight to healthy
    flight, standard deviation; balance: axes of torque of which the balance over seconds alone is predicted; flights:
    those that it was learned from, taken as level where they have no attitude.
    """

    effects: dict[str, Effect]
    owners: tuple[tuple[str, int], ...]
    rather: Array
    covariance: Array
    scatter: Array
    balance: frozenset[str]
    flights: tuple[Flight, ...]

    def prior(self, columns: Sequence[tuple[str, int]], alone: bool) -> Array:
        """Covariance (p, p) of these numbers, each given by label and place; 0 of what the flights could not show.

        One linearisation of a number counts, the first. alone: what the flights that are held against them differ by
        themselves is in their common numbers.
        """
        first = firsts(columns)
        inside = [k for k, owner in enumerate(self.owners) if owner in first]
        at = [first[self.owners[k]] for k in inside]
        out = np.zeros((len(columns), len(columns)))
        known = self.covariance + np.diag(self.scatter**2) if alone else self.covariance
        out[np.ix_(at, at)] = known[np.ix_(inside, inside)]
        return out

    def mean(self, columns: Sequence[tuple[str, int]]) -> Array:
        """What the flights would rather have these numbers be than what the model says, (p,), usual sizes."""
        first = firsts(columns)
        out = np.zeros(len(columns))
        for owner, value in zip(self.owners, self.rather, strict=True):
            if owner in first:
                out[first[owner]] = value
        return out

    def shown(self, known: Sequence[Candidate], hidden: dict[str, str]) -> tuple[list[Candidate], dict[str, str]]:
        """The candidates of which the healthy flights say anything; of the others, beside `hidden`, that they do not.

        Without the channels that an effect needs its healthy numbers are anybody's guess, not those of the file.
        """
        said = {label for label, _ in self.owners}
        left = [c for c in known if c.label in said]
        lost = {c.name for c in known} - {c.name for c in left}
        return left, hidden | dict.fromkeys(sorted(lost), "the healthy flights cannot show it")

    def values(self, candidate: Candidate, vehicle: Vehicle) -> Effect:
        """The effect with its healthy numbers."""
        return self.effects.get(candidate.label) or candidate.absent(vehicle)

    def numbers(self, candidate: Candidate, at: Sequence[Place], vehicle: Vehicle) -> Array:
        """The coordinates of the healthy numbers of an effect."""
        return read(self.values(candidate, vehicle), at)

    def errors(self, label: str, at: Sequence[Place]) -> Array:
        """Standard deviation of each coordinate of an effect's numbers; nan where the flights could not show it."""
        return self._of(label, at, np.hypot(np.sqrt(np.diag(self.covariance)), self.scatter))

    def _of(self, label: str, at: Sequence[Place], sizes: Array) -> Array:
        """Sizes (q,) as those of each coordinate of an effect's numbers; nan where the flights could not show it."""
        place = {owner: k for k, owner in enumerate(self.owners)}
        found = [place.get((label, i)) for i in range(len(at))]
        return np.array([np.nan if k is None else abs(p.scale) * sizes[k] for p, k in zip(at, found, strict=True)])

    def changed(self, candidate: Candidate, effect: Effect, at: Sequence[Place], vehicle: Vehicle) -> bool:
        """Whether an effect's numbers differ from the healthy ones."""
        return not np.allclose(read(effect, at), self.numbers(candidate, at, vehicle), rtol=0.0, atol=1e-12)

    def said(self, candidate: Candidate, at: Sequence[Place], vehicle: Vehicle) -> dict[str, Any]:
        """The healthy numbers, their standard errors, and what flights differ by, by parameter, for an answer."""
        effect = written(candidate, at, self.numbers(candidate, at, vehicle))
        slope = slopes(effect, at)

        def told(sizes: Array) -> dict[str, Any]:
            each: dict[str, Any] = {}
            for p, x in zip(at, sizes * slope, strict=True):
                each.setdefault(p.parameter, []).append(float(x) if np.isfinite(x) else None)
            return {k: v[0] if len(v) == 1 else v for k, v in each.items()}

        errors = told(self.errors(candidate.label, at))
        return {
            "parameters": {k: effect.values[k] for k in errors},
            "standard_errors": errors,
            "from_flight_to_flight": told(self._of(candidate.label, at, self.scatter)),
        }
