"""What a flight would tell: how far it would shift the odds between two explanations, or narrow a number.

Everything is Gaussian, as in the diagnosis: numbers as the flown flights left them, noise and coherence of each band as
they were there, and the next flight's data linear in the numbers. So what a flight can tell follows from its columns
alone, and no data of it are needed (Lindley 1956). Two explanations are told apart by the log odds that the next flight
adds (Box and Hill 1967); how often they pass the odds that a verdict asks for is drawn from both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.judge.groups import AS_PROBABLE
from infotraj.diagnosis.linear.candidates import variants
from infotraj.diagnosis.linear.observation import Member, Observation, inward, packed, unpacked
from infotraj.diagnosis.linear.sensitivities import SMALL, columns_of
from infotraj.diagnosis.noise.spectra import spectra
from infotraj.diagnosis.select.fit import Fit
from infotraj.effects.base import Effect
from infotraj.flight import Flight
from infotraj.rotations import Array

_DRAWS = 400
_JITTER = 1e-9


@dataclass(frozen=True)
class Belief:
    """What the flown flights say under one explanation: a fit, its free columns, their covariance (q, q)."""

    fit: Fit
    free: tuple[int, ...]
    covariance: Array

    @property
    def keys(self) -> list[tuple[str, int]]:
        """Label and place of every free number."""
        columns = self.fit.linear.columns
        return [(columns[i].candidate.label, columns[i].place) for i in self.free]

    @property
    def members(self) -> tuple[Member, ...]:
        """The model with all numbers as they were found, the file's too."""
        linear, solution = self.fit.linear, self.fit.solution
        return linear.members(self.fit.chosen, solution.theta, shift=0.0, straight=True)


def belief(fit: Fit) -> Belief:
    """What a fit leaves of its numbers, widened by how much the data scatter beyond the noise model."""
    free, covariance = fit.scorer.covariance(fit.chosen)
    return Belief(fit, tuple(int(i) for i in free), covariance * overdispersion(fit)[0])


@dataclass(frozen=True)
class Gram:
    """Products (q + 1, q + 1) of a flight's weighted columns; last: what one explanation predicts less the other."""

    products: Array


@dataclass(frozen=True)
class Question:
    """One explanation against another, or one alone (its numbers are asked for): `first`, `second`.

    odds: log odds of the first now, tempered; spread: by which log odds are tempered; straight: both are of one
    linearisation, and what they predict differs as that says.
    """

    first: Belief
    second: Belief | None
    odds: float = 0.0
    spread: float = 1.0
    straight: bool = False

    @cached_property
    def _own(self) -> list[int]:
        """Columns of the second explanation that the first has not."""
        if self.second is None:
            return []
        known = set(self.first.keys)
        return [i for i, k in zip(self.second.free, self.second.keys, strict=True) if k not in known]

    @cached_property
    def _sets(self) -> tuple[list[Effect], list[list[Effect]], Array]:
        """The base, the changed sets of effects, and how their differences combine to columns, (sets, q + 1)."""
        base, sets, parts = _moved(self.first.fit, self.first.free)
        factors = list(parts)
        count = len(self.first.free) + len(self._own) + 1
        combine = [np.eye(1, count, k).ravel() * f for k, f in enumerate(factors)]
        if self.second is not None:
            start, moved, factors = _moved(self.second.fit, self._own)
            for k, (s, f) in enumerate(zip(moved, factors, strict=True)):
                sets += [s, start]
                unit = np.eye(1, count, len(self.first.free) + k).ravel() * f
                combine += [unit, -unit]
            last = np.eye(1, count, count - 1).ravel()
            sets += [[m.effect for m in b.members] for b in (self.second, self.first)]
            combine += [last, -last]
        return base, sets, np.array(combine)

    def gram(self, observation: Observation) -> Gram:
        """The products of the columns on one flight, weighted as the flown flights' noise and coherence say."""
        base, sets, combine = self._sets
        found = columns_of(observation, base, [(s, 1.0) for s in sets])
        linear = self.first.fit.linear
        size = combine.shape[1]
        total = np.zeros((size, size))
        for s in spectra(observation.samples, observation.transforms, found):
            if s.axis not in linear.weights.axes:
                continue
            a = linear.weights.axes.index(s.axis)
            x = s.values[:, 1:] @ combine * np.sqrt(linear.weights.coherence[a] / linear.weights.noise[a])[s.band, None]
            total += x.T @ x
        if self.straight and self.second is not None:
            moved = self._numbers(self.second) - self._numbers(self.first)
            total[-1, :-1] = total[:-1, -1] = total[:-1, :-1] @ moved
            total[-1, -1] = moved @ total[:-1, -1]
        return Gram(total)

    def _numbers(self, own: Belief) -> Array:
        """The numbers of an explanation among all columns, (q,), usual sizes; 0 where it has none."""
        at = self._places
        out = np.zeros(len(self.first.free) + len(self._own))
        out[[at[k] for k in own.keys]] = own.fit.solution.theta[list(own.free)]
        return out

    def observed(self, flight: Flight) -> Observation:
        """A flight as the diagnosis would read it."""
        own = self.first.fit.linear.observation
        return observe(own.model([]), [flight], None, None)

    def told_apart(self, gram: Gram, rng: np.random.Generator) -> tuple[float, float]:
        """Probability that the right explanation passes the odds of a verdict after the flight, and the least of the
        two expected changes of the log odds (nats, tempered)."""
        if self.second is None:
            raise TypeError("one explanation alone is not told from another")
        size = len(gram.products) - 1
        first, second = self._placed(self.first, size), self._placed(self.second, size)
        likely = 1.0 / (1.0 + np.exp(-np.clip(self.odds, -50.0, 50.0)))
        forth = self._gains(gram, first, second, 0.0, rng)
        back = self._gains(gram, second, first, 1.0, rng)
        apart = likely * np.mean(self.odds + forth >= AS_PROBABLE)
        apart += (1.0 - likely) * np.mean(back - self.odds >= AS_PROBABLE)
        return float(apart), float(min(np.mean(forth), np.mean(back)))

    def _placed(self, own: Belief, size: int) -> Array:
        """Factor L (size, q) with L L^T the covariance of an explanation's numbers among all columns."""
        out = np.zeros((size, len(own.free)))
        out[[self._places[k] for k in own.keys]] = _factor(own.covariance)
        return out

    @cached_property
    def _places(self) -> dict[tuple[str, int], int]:
        """Where every free number stands among all columns."""
        at = {k: i for i, k in enumerate(self.first.keys)}
        if self.second is not None:
            labels = dict(zip(self.second.free, self.second.keys, strict=True))
            at |= {labels[i]: len(self.first.free) + k for k, i in enumerate(self._own)}
        return at

    def _gains(self, gram: Gram, true: Array, other: Array, sign: float, rng: np.random.Generator) -> Array:
        """Draws of the tempered log odds that the flight adds for an explanation when it is true."""
        whole = gram.products
        G, shift = whole[:-1, :-1], (1.0 - 2.0 * sign) * whole[:-1, -1]
        noise = rng.standard_normal((_DRAWS, len(whole))) @ _factor(whole).T
        theta = rng.standard_normal((_DRAWS, true.shape[1])) @ true.T
        # Of the data only products with the columns matter: what is measured less what the true one predicts.
        u = theta @ G + noise[:, :-1]
        v = theta @ shift + (1.0 - 2.0 * sign) * noise[:, -1]
        mine = _quadratic(u, G, true)
        others = 2.0 * v - whole[-1, -1] + _quadratic(u - shift, G, other)
        return 0.5 * (mine - others) / self.spread

    def errors_after(self, gram: Gram, label: str) -> tuple[Array, Array, list[int]]:
        """Standard errors now and after the flight of an effect's numbers, (m,) each, in their own units; places."""
        at = [k for k, (name, _) in enumerate(self.first.keys) if name == label]
        linear = self.first.fit.linear
        columns = [linear.columns[self.first.free[k]] for k in at]
        scale = np.array([abs(c.scale) * c.slope for c in columns])
        now = self.first.covariance
        factor = _factor(now)
        G = gram.products[: len(now), : len(now)] / self.spread
        after = factor @ np.linalg.solve(np.eye(len(now)) + factor.T @ G @ factor, factor.T)
        errors = [np.sqrt(np.maximum(np.diag(c)[at], 0.0)) * scale for c in (now, after)]
        return errors[0], errors[1], [self.first.keys[k][1] for k in at]

    def information(self, gram: Gram) -> float:
        """What the flight is expected to tell of all numbers together (nats), of those in the file too."""
        factor = _factor(self.first.covariance)
        G = gram.products[: len(factor), : len(factor)] / self.spread
        return float(0.5 * np.linalg.slogdet(np.eye(factor.shape[1]) + factor.T @ G @ factor)[1])


def _moved(fit: Fit, wanted: Sequence[int]) -> tuple[list[Effect], list[list[Effect]], list[float]]:
    """The effects of a fit's point, and for each wanted column the effects with its number moved, and the factor."""
    linear = fit.linear
    vehicle = linear.observation.vehicle
    x, owner = packed(linear.point, vehicle)
    base = [m.effect for m in linear.point]
    first: dict[str, int] = {}
    for i, (number, _) in enumerate(owner):
        first.setdefault(linear.point[number].candidate.label, i)
    sets, factors = [], []
    for i in wanted:
        c = linear.columns[i]
        if c.candidate.label in first:
            at = first[c.candidate.label] + c.place
            place = owner[at][1]
            step = inward(x[at] * place.scale, place, SMALL * abs(place.scale)) / place.scale
            moved = x.copy()
            moved[at] += step
            sets.append([m.effect for m in unpacked(linear.point, vehicle, moved)])
            factors.append(1.0 / step)
            continue
        own = [v for h, v in zip(linear.choices, linear.variants, strict=True) if v is not None and i in h.columns]
        # What the fit has left since its columns were made has none of its own: it is where the file has it.
        variant = own[0] if own else variants(c.candidate, vehicle)[0]
        _, effect, size = next(point for point in variant.points if point[0] == c.place)
        sets.append([*base, effect])
        factors.append(c.scale / size)
    return base, sets, factors


def _factor(covariance: Array) -> Array:
    """L (q, q) with L L^T a covariance that may be singular."""
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    safe = np.where(size > 0, size, 1.0)
    scaled = covariance / np.outer(safe, safe)
    value, vector = np.linalg.eigh((scaled + scaled.T) / 2)
    return safe[:, None] * vector * np.sqrt(np.maximum(value, _JITTER * max(value.max(initial=0.0), 0.0)))


def _quadratic(u: Array, G: Array, factor: Array) -> Array:
    """2 ln p of data with products u (n, q), up to what all explanations share, numbers of covariance L L^T out."""
    inside = np.eye(factor.shape[1]) + factor.T @ G @ factor
    along = u @ factor
    return np.einsum("ni,ni->n", along, np.linalg.solve(inside, along.T).T) - np.linalg.slogdet(inside)[1]
