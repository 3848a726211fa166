"""Fits the numbers of a set of effects to all flights at once: weighted, bounded, nonlinear least squares.

Levenberg (1944) and Marquardt (1963) on the whitened residual, in units of each number's usual size, with bounds by
projection (Kelley, "Iterative methods for optimization", 1999, 5.4). Directions that the flights hardly determine are
held near the absent value by a weak prior and reported by their standard errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from infotraj.diagnosis.noise import PRIOR
from infotraj.diagnosis.observation import Member, Observation, inward, packed, unpacked
from infotraj.diagnosis.plain import mean_squares
from infotraj.diagnosis.sensitivities import SMALL
from infotraj.diagnosis.sums import Sums, block_sums
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_ROUNDS = 8
_NEAR = 0.3  # usual sizes from where the Jacobian was taken: nearer it counts as that of the place
_AS_EXPECTED = 0.1  # relative difference between the gain of a step and what the Jacobian said
_SHORT = 1e-3  # of the way from the absent value to a bound: nearer to it is at it
_SETTLED = 0.3  # change of the squared error (its unit: one noise variance) below which a fit stops


@dataclass(frozen=True)
class Fit:
    """members: with fitted values; cost: whitened squared error; sums: of the linearisation there (all numbers).

    at_bound: for each number whether it lies at a bound. plain: mean squared error by axis, not whitened (`plain`).
    """

    members: tuple[Member, ...]
    cost: float
    sums: Sums
    at_bound: Array
    plain: Array


def fit(observation: Observation, members: Sequence[Member], rounds: int = _ROUNDS) -> Fit | None:
    """Fits all numbers of `members`, from their present values. None where no model of them can be evaluated."""
    vehicle = observation.vehicle
    x, owner = packed(members, vehicle)
    sides = np.sort(np.array([(p.low / p.scale, p.high / p.scale) for _, p in owner]).reshape(-1, 2), axis=1)
    low, high = sides.T
    x = np.clip(x, low, high)
    r = _residual(observation, members, x)
    if r is None:
        return None
    absent = np.array([p.absent / p.scale for _, p in owner])
    cost, damping = _penalised(r, x, absent), 1e-4
    jacobian, taken_at = np.zeros((len(r), 0)), None
    for _ in range(rounds):
        if taken_at is None:
            jacobian, taken_at = _jacobian(observation, members, x, r, owner), x
        gram = jacobian.T @ jacobian + np.eye(len(x)) / PRIOR**2
        right = jacobian.T @ r - (x - absent) / PRIOR**2
        gained, expected = 0.0, 1.0
        for _ in range(6):
            step = _step(gram, right, damping, x, low, high)
            trial = np.clip(x + step, low, high)
            moved = _residual(observation, members, trial)
            if moved is not None and (reached := _penalised(moved, trial, absent)) < cost:
                step = trial - x
                expected = float(2 * right @ step - step @ gram @ step)
                gained = cost - reached
                off = (r - moved) - jacobian @ step
                x, r, cost = trial, moved, reached
                damping = max(damping * 0.1, 1e-9)
                break
            damping = max(damping * 10, 1e-3)
            if np.max(np.abs(step), initial=0.0) < 1e-5:
                break
        far = np.max(np.abs(x - taken_at), initial=0.0) > _NEAR
        if gained < _SETTLED:
            if not far:
                break
            taken_at = None
        elif abs(gained / expected - 1.0) < _AS_EXPECTED:
            # Broyden's update (1965): most effects are so nearly linear that another Jacobian would say the same.
            jacobian = jacobian + np.outer(off, step / (step @ step))
        else:
            taken_at = None
    if taken_at is None:
        jacobian = _jacobian(observation, members, x, r, owner)
    joint = observation.split(np.concatenate([r[:, None], jacobian], axis=1))
    sums = block_sums(observation.samples, observation.noise, observation.blocks, joint)
    at_bound = (x <= low + 1e-6) | (x >= high - 1e-6)
    fitted = tuple(unpacked(members, vehicle, x))
    raw = observation.raw(observation.model(fitted))
    plain = mean_squares(observation.samples, sums.axes, raw, observation.ignored)
    return Fit(fitted, float(r @ r), sums, at_bound, plain)


def _penalised(r: Array, x: Array, absent: Array) -> float:
    return float(r @ r + np.sum(((x - absent) / PRIOR) ** 2))


def beyond_bounds(members: Sequence[Member], vehicle: Vehicle) -> dict[str, str]:
    """Labels of members with a number at a physical bound that is not the absent value, and the reason.

    A fit may stop just short of a bound: what is left of the way there no longer pays.
    """
    found = {}
    for m in members:
        for p in m.places(vehicle):
            value = float(np.atleast_1d(getattr(m.effect, p.parameter))[p.component])
            bounds = [b for b in (p.low, p.high) if np.isfinite(b) and abs(b - p.absent) > 1e-9 * max(1.0, abs(b))]
            if any(abs(value - b) <= _SHORT * abs(b - p.absent) for b in bounds):
                found[m.candidate.label] = f"the fit ends at the physical bound of {p.parameter} ({value:.3g})"
    return found


def _residual(observation: Observation, members: Sequence[Member], x: Array) -> Array | None:
    raw = observation.raw(observation.model(unpacked(members, observation.vehicle, x)))
    return None if raw is None else observation.whitened(raw)


def _jacobian(observation: Observation, members: Sequence[Member], x: Array, r: Array, owner) -> Array:
    """Minus the derivative of the residual by each number in usual sizes, (samples, p)."""
    columns = np.zeros((len(r), len(x)))
    for i, (_, place) in enumerate(owner):
        step = inward(x[i] * place.scale, place, SMALL * abs(place.scale)) / place.scale
        moved = x.copy()
        moved[i] += step
        there = _residual(observation, members, moved)
        if there is not None:
            columns[:, i] = (r - there) / step
    return columns


def _step(gram: Array, right: Array, damping: float, x: Array, low: Array, high: Array) -> Array:
    """The damped step of the numbers that are free to move."""
    free = ~(((x <= low) & (right < 0)) | ((x >= high) & (right > 0)))
    step = np.zeros(len(x))
    if free.any():
        g = gram[np.ix_(free, free)]
        size = np.sqrt(np.maximum(np.diag(g), 1e-12))
        scaled = g / np.outer(size, size) + damping * np.eye(len(size)) + 1e-10 * np.eye(len(size))
        step[free] = np.linalg.solve(scaled, right[free] / size) / size
    return step
