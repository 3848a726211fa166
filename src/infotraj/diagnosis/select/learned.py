"""Learns from healthy flights what every number of the model is, and by how much it differs from flight to flight.

Every number is free, those of effects that the flights do not need, too: what they cannot show stays unknown, and is
no change where a later flight shows it. The numbers of one flight scatter about the common ones (batteries, air,
trim); how much each effect's do is found by marginal likelihood (MacKay 1992), near what is usual where flights are
few.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.linear.healthy import Healthy
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.linear.sums import Sums
from infotraj.diagnosis.select.around import Linear, linearised
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.prior import SCALES, SLAB, Scales, is_file_number, spikes
from infotraj.diagnosis.select.score import diluted
from infotraj.effects.inertia_products import InertiaProducts
from infotraj.effects.rigid_body import arm_length
from infotraj.effects.rotor_height import RotorHeight
from infotraj.effects.rotor_torque import RotorTorque
from infotraj.flight import Flight
from infotraj.rotations import Array

_ORDINARY = 1 / 15  # of an effect's usual size: what it differs by from flight to flight, where no file states it
_SPREAD = 2.0  # standard deviation of the logarithm by which an effect's scatter differs from what is usual
_LEVELS = (0.1, 0.3, 1.0, 3.0, 9.0, 27.0, 81.0)  # times what is usual
_SEEN = 1e-6  # squared standard deviations of the noise: what changes less does nothing here
_PASSES = 2
_LARGE = 0.1  # m: the arm of a vehicle of which a ruler tells places to 1 %
_TRIM = ("steady_force", "steady_torque")


def learned(now: Linear, flights: Sequence[Flight], wider: float) -> Healthy:
    """What these flights say of every number, around the model of `now`.

    wider: how much more the data scatter than the noise model says, a variance's factor.
    """
    columns, owners = _first(now)
    parts = _by_flight(now.sums, columns, wider)
    of_number = scattered(now, wider)
    scatter = np.array([of_number[owner] for owner in owners])
    told = [diluted(x, scatter) for x in parts]
    precision = sum((x[1:, 1:] for x in told), np.diag(_before(now, columns) ** -2.0))
    covariance = np.asarray(np.linalg.inv(precision), dtype=float)
    rather = covariance @ sum(x[0, 1:] for x in told)
    effects = {m.candidate.label: m.effect for m in now.point}
    return Healthy(effects, tuple(owners), rather, covariance, scatter, now.observation.balance, tuple(flights))


def around_fit(whole: Fit, known: Sequence[Candidate]) -> Linear:
    """The model of a fit, file numbers and all, with nothing held: what the model has already may change as well.

    Its numbers are refined together: a product of two that are off by 10 % is off by 1 %. What no flight tells (masses,
    inertias and thrusts by one factor) stays as near the file as files are.
    """
    now = linearised(whole.linear.observation, [replace(m, held=False) for m in straight(whole)], known)
    for _ in range(_PASSES):
        inside = {m.candidate.label for m in now.point}
        mine = [i for i in _first(now)[0] if now.columns[i].candidate.label in inside]
        total = np.sum(_by_flight(now.sums, mine, 1.0), axis=0)
        theta = now.now.copy()
        near = _as_files_are(now, whole, mine) ** -2.0
        theta[mine] += np.linalg.solve(total[1:, 1:] + np.diag(near), total[0, 1:] - near * theta[mine])
        point = now.members(now.labelled(sorted(inside & {c.label for c in now.choices})), theta, 0.0, True)
        now = linearised(now.observation, [replace(m, held=False) for m in point], known)
    return now


def straight(whole: Fit) -> tuple[Member, ...]:
    """The model of a fit with all its file numbers, those that were left to the linear solution, too.

    A number that hardly acts may be anywhere in the solution: where the model was computed with them all, it is that.
    """
    if whole.exact:
        return whole.linear.point
    return whole.linear.members(whole.chosen, whole.solution.theta, shift=0.0, straight=True)


def of_a_day(whole: Fit, labels: Collection[str]) -> tuple[Member, ...]:
    """The model of a fit beside healthy flights with these effects alone, all else as near as its day may have it."""
    chosen = tuple(i for i, label in zip(whole.chosen, whole.labels, strict=True) if label in labels)
    return whole.linear.members(chosen, whole.scorer.of_a_day(chosen), shift=0.0, straight=True)


def _as_files_are(now: Linear, whole: Fit, columns: Sequence[int]) -> Array:
    """Standard deviation of these numbers from absent: of the file where they are its own, else of effects."""
    chosen = {whole.linear.choices[i].label for i in whole.chosen}
    spike = now.spike(whole.scales)[list(columns)]
    effect = np.array([now.columns[c].candidate.label in chosen for c in columns])
    return np.where(effect | (spike == 0.0), np.hypot(spike, SLAB), spike)


def around_usual(now: Linear, known: Sequence[Candidate]) -> Linear:
    """The model with the steady force and torque that the flights have in the mean: usual, and nothing identified."""
    mine = [i for i, c in enumerate(now.columns) if c.candidate.name in _TRIM]
    total = np.sum(_by_flight(now.sums, mine, 1.0), axis=0)
    theta = np.zeros(now.sums.width)
    theta[mine] = np.linalg.solve(total[1:, 1:] + 1e-6 * np.eye(len(mine)), total[0, 1:])
    chosen = [i for i, c in enumerate(now.choices) if c.label in _TRIM]
    point = [replace(m, held=False) for m in now.members(chosen, theta, shift=np.inf)]
    return linearised(now.observation, point, known)


def scattered(now: Linear, wider: float = 1.0) -> dict[tuple[str, int], float]:
    """What each number differs by from flight to flight, usual sizes, by label and place.

    One scale for a number of an effect, times what is usual; that of all rotors is one. All numbers are free: it is not
    asked which the flights need.
    """
    columns, owners = _first(now)
    usual = _usual(now, columns)
    kinds = [(now.columns[c].candidate.name, now.columns[c].place) for c in columns]
    free = np.diag(_before(now, columns) ** -2.0)
    parts = _by_flight(now.sums, columns, wider)
    level = dict.fromkeys(kinds, 1.0)
    sizes = zip(kinds, np.sum(parts, axis=0).diagonal()[1:], strict=True)
    # Products of inertia, of which a change has no name, stay as free as they usually are.
    acts = {k for k, size in sizes if size > _SEEN and k[0] != InertiaProducts.name}

    def evidence(of: dict[tuple[str, int], float]) -> float:
        deviation = usual * np.array([of[k] for k in kinds])
        total = np.zeros_like(parts[0])
        value = 0.0
        for part in parts:
            total += diluted(part, deviation)
            inside = np.eye(len(usual)) + part[1:, 1:] * np.outer(deviation, deviation)
            value -= 0.5 * float(np.linalg.slogdet(inside)[1])
        precision = total[1:, 1:] + free
        value += 0.5 * float(total[0, 1:] @ np.linalg.solve(precision, total[0, 1:]) - np.linalg.slogdet(precision)[1])
        value -= 0.5 * float(total[0, 0])
        return value - 0.5 * float(np.sum((np.log(list(of.values())) / _SPREAD) ** 2))

    best = evidence(level)
    for _ in range(_PASSES if len(parts) > 1 else 0):
        before = best
        for kind in sorted(acts):
            for s in _LEVELS:
                trial = {**level, kind: s}
                reached = evidence(trial)
                if reached > best + 1e-6:
                    level, best = trial, reached
        if best - before < 1.0:
            break
    return {owner: float(u * level[k]) for owner, u, k in zip(owners, usual, kinds, strict=True)}


def _first(now: Linear) -> tuple[list[int], list[tuple[str, int]]]:
    """The first column of every number that has one, and whose it is."""
    first: dict[tuple[str, int], int] = {}
    for i, c in enumerate(now.columns):
        if not c.idle:
            first.setdefault((c.candidate.label, c.place), i)
    return list(first.values()), list(first)


def _usual(now: Linear, columns: Sequence[int]) -> Array:
    """What each number usually differs by from flight to flight, usual sizes."""
    days = [now.columns[c].candidate.cls.day for c in columns]
    return np.array([x if day is None else day for day, x in zip(days, _in_a_file(now, columns), strict=True)])


def _in_a_file(now: Linear, columns: Sequence[int]) -> Array:
    """What a file that is right to 1 % is off by in each number, usual sizes, or as much of what no file states."""
    o = now.observation
    owners = [(now.columns[c].candidate, now.columns[c].scale) for c in columns]
    of_file = spikes(owners, Scales(1.0), 0.0, o.vehicle)
    # A hand with a ruler is off by the same everywhere; places on a small vehicle come from its drawing.
    places = np.array([c.cls in (RotorTorque, RotorHeight) for c, _ in owners])
    of_file = np.where(places, min(1.0, arm_length(o.vehicle) / _LARGE) * of_file, of_file)
    return np.where(of_file > 0.0, of_file, _ORDINARY)


def _before(now: Linear, columns: Sequence[int]) -> Array:
    """Standard deviation of each number before a flight is seen, usual sizes.

    A file is as wrong as files are; effects are wide where flights tell them, and those of the thrust are not where
    flights tell a balance alone.
    """
    balance = bool(now.observation.balance)
    owners = [now.columns[c].candidate for c in columns]
    bounded = [(is_file_number(x) or (balance and x.cls.place == "thrust")) and x.name not in _TRIM for x in owners]
    return np.where(bounded, max(SCALES) * _in_a_file(now, columns), SLAB)


def _by_flight(sums: Sums, columns: Sequence[int], wider: float) -> list[Array]:
    """Products of the residual and these columns, (1 + q, 1 + q), of every flight over all axes."""
    at = np.array([0, *(1 + c for c in columns)])
    total = [sums.gram[:, sums.flight == f].sum(axis=(0, 1)) / wider for f in np.unique(sums.flight)]
    return [x[np.ix_(at, at)] for x in total]
