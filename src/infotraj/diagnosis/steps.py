"""How the held-out error falls, effect by effect: what the waterfall shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj.comparing.equation_error import AXES, equation_error
from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.diagnosis.evidence import resampled
from infotraj.diagnosis.fitting import Fit
from infotraj.diagnosis.observation import Member, packed, unpacked
from infotraj.diagnosis.sums import held_out
from infotraj.rotations import Array


@dataclass(frozen=True)
class Steps:
    """labels (m,): the model as given, then each effect added; rmse (m, 6); low, high (m, 6): 95 %; floor (6,).

    unit: of force and of torque; axes: their names.
    """

    labels: tuple[str, ...]
    rmse: Array
    low: Array
    high: Array
    floor: Array
    unit: dict[str, str]
    axes: tuple[str, ...] = AXES


def steps(found: Diagnosis, seed: int = 0) -> Steps:
    """Equation error on held-out flights after each supported effect, the one that matters most first.

    The numbers of each step are fitted on the other folds (linearised at the fit to all), so no flight judges its own.
    """
    search = found.search
    held = [m for m in found.final.members if m.held]
    rise = {f.name: f.evidence.rise for f in found.findings if f.evidence is not None}
    free = [
        m
        for m in found.final.members
        if not m.held and found.finding(m.candidate.name).verdict in ("Supported", "Not separable")
    ]
    free.sort(key=lambda m: -rise.get(m.candidate.name, 0.0))
    labels = ["as given", *(f"+ {m.candidate.label.replace('_', ' ')}" for m in free)]
    rng = np.random.default_rng(seed)
    rmse, low, high = [], [], []
    floor, unit = np.full(6, np.nan), {}
    for k in range(len(free) + 1):
        made = search.fitted([*held, *free[:k]])
        squares, rows, flight, floor, unit = _errors(found, made)
        draws = resampled(flight, rng)
        with np.errstate(invalid="ignore", divide="ignore"):
            rmse.append(np.sqrt(squares.sum(axis=0) / rows.sum(axis=0)))
            spread = np.sqrt((draws @ squares) / (draws @ rows))
        low.append(np.quantile(spread, 0.025, axis=0))
        high.append(np.quantile(spread, 0.975, axis=0))
    return Steps(tuple(labels), np.array(rmse), np.array(low), np.array(high), floor, unit)


def _errors(found: Diagnosis, made: Fit):
    """Squared error and rows by block and axis (blocks, 6), each block under numbers that were fitted without it."""
    o = found.search.observation
    free = np.flatnonzero(~made.at_bound)
    x, owner = packed(made.members, o.vehicle)
    theta = np.zeros((len(made.sums.fold), len(x)))
    theta[:, free] = held_out(made.sums, free)[1]
    sides = np.sort(np.array([(p.low / p.scale, p.high / p.scale) for _, p in owner]).reshape(-1, 2), axis=1)
    numbers = np.clip(x + theta, *sides.T)
    squares, rows, flight, floors = [], [], [], []
    unit: dict[str, str] = {}
    for number, s in enumerate(o.samples):
        mine = np.flatnonzero(made.sums.flight == number)
        edges = np.linspace(s.flight.t[0], s.flight.t[-1] + 1e-9, 1 + len(mine))
        place = np.clip(np.searchsorted(edges, s.flight.t, side="right") - 1, 0, len(edges) - 2)
        values, which = np.unique(numbers[mine], axis=0, return_inverse=True)
        for k, value in enumerate(values):
            members: list[Member] = unpacked(made.members, o.vehicle, value)
            error = equation_error(o.model(members), s.flight)
            unit = error.unit
            squared = np.where(error.scored, error.residual, 0.0) ** 2
            for b in np.flatnonzero(which.ravel() == k):
                squares.append(squared[place == b].sum(axis=0))
                rows.append(error.scored[place == b].sum(axis=0).astype(float))
                flight.append(number)
        floors.append(error.floor)
    return np.array(squares), np.array(rows), np.array(flight), np.sqrt(np.mean(np.square(floors), axis=0)), unit
