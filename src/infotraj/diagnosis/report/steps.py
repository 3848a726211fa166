"""How the error falls on flights that were not fitted, effect by effect: what the waterfall shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj.comparing.equation_error import AXES, equation_error
from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.diagnosis.judge.evidence import resampled
from infotraj.diagnosis.judge.verdicts import CONFIDENT
from infotraj.diagnosis.select.search import Fit
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
    made = found.final
    rise = {f.name: f.evidence.rise for f in found.findings if f.evidence is not None}
    labels = [x for x in made.labels if found.finding(x.split()[0]).verdict in CONFIDENT]
    labels.sort(key=lambda x: -rise.get(x.split()[0], 0.0))
    rng = np.random.default_rng(seed)
    rmse, low, high = [], [], []
    floor, unit = np.full(6, np.nan), {}
    for k in range(len(labels) + 1):
        squares, rows, flight, floor, unit = _errors(found, made, labels[:k])
        draws = resampled(flight, rng)
        with np.errstate(invalid="ignore", divide="ignore"):
            rmse.append(np.sqrt(squares.sum(axis=0) / rows.sum(axis=0)))
            spread = np.sqrt((draws @ squares) / (draws @ rows))
        low.append(np.quantile(spread, 0.025, axis=0))
        high.append(np.quantile(spread, 0.975, axis=0))
    said = ["as given", *(f"+ {label.replace('_', ' ')}" for label in labels)]
    return Steps(tuple(said), np.array(rmse), np.array(low), np.array(high), floor, unit)


def _errors(found: Diagnosis, made: Fit, labels: list[str]):
    """Squared error and rows by block and axis (blocks, 6), each block under numbers that were fitted without it."""
    linear = made.linear
    cut = linear.observation.blocks
    chosen = linear.labelled(labels)
    refitted = made.scorer.solution(made.chosen)
    # Numbers that stay as they were found beside the file's own errors stay so in every step.
    solution = made.scorer.solution(chosen) if np.allclose(refitted.theta, made.solution.theta) else made.solution
    folds = np.unique(cut.fold)
    given = [linear.members(chosen, theta, np.inf) for theta in solution.each]
    squares, rows = np.zeros((len(cut.flight), 6)), np.zeros((len(cut.flight), 6))
    floors = []
    unit: dict[str, str] = {}
    for number, s in enumerate(linear.observation.samples):
        own = np.flatnonzero(cut.flight == number)
        for f in np.unique(cut.fold[own]):
            members = given[int(np.searchsorted(folds, f))]
            error = equation_error(linear.observation.model(members), s.flight, start=found.start, stop=found.stop)
            unit = error.unit
            squared = np.where(error.scored, error.residual, 0.0) ** 2
            place = cut.at(number, s.flight.t)
            for b in own[cut.fold[own] == f]:
                squares[b] = squared[place == b].sum(axis=0)
                rows[b] = error.scored[place == b].sum(axis=0)
        floors.append(error.floor)
    return squares, rows, cut.flight, np.sqrt(np.mean(np.square(floors), axis=0)), unit
