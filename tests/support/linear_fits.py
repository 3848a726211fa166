"""Fits of effects from made columns, on one axis or on several: what search and verdicts see, without flights."""

from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from given_sums import given_sums

from infotraj.diagnosis.linear.candidates import Candidate, places
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.select.around import Column, Linear
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.prior import Scales
from infotraj.diagnosis.select.score import Choice
from infotraj.effects import catalogue
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml")
BLOCKS, ROWS = 40, 50


def linear_fit(
    names: Sequence[str],
    rows: Callable[[np.random.Generator, int], np.ndarray],
    chosen: Sequence[str],
    axes: tuple[str, ...] = ("fx",),
) -> tuple[SimpleNamespace, Fit]:
    """A search among effects of one column each, and the fit of those that are chosen. names: labels of effects.

    rows: residual and columns (ROWS, 1 + n) of block k, one after another for each of the axes, in units of the noise.
    Every block is a flight of its own. The search keeps what it was `asked` to
    fit: labels, and whether more was to be asked from there.
    """
    rng = np.random.default_rng(1)
    candidates = []
    for n in names:
        name, *rotor = n.split()
        form = tuple(p for p in catalogue()[name].parameters if not p.index)
        candidates.append(Candidate(catalogue()[name], form, tuple(("rotor", int(r)) for r in rotor)))
    gram = np.zeros((len(axes), BLOCKS, 1 + len(names), 1 + len(names)))
    for k in range(BLOCKS):
        for a, x in enumerate(np.reshape(rows(rng, k), (len(axes), ROWS, -1))):
            gram[a, k] = x.T @ x
    sums = given_sums(gram, np.full((len(axes), BLOCKS), float(ROWS)), axes)
    columns = tuple(Column(c, 0, places(c, VEHICLE)[0].scale, 0.0, -np.inf, np.inf) for c in candidates)
    observation: Any = SimpleNamespace(  # as much of an Observation as a search reads; no flight is weighed
        samples=(),
        vehicle=VEHICLE,
        command_step=0.005,
        healthy=None,
        scatter={},
        still=frozenset(),
        ignored=frozenset(),
        balance=frozenset(),
        base=lambda c: c.absent(VEHICLE),
    )
    point = tuple(Member(c, c.absent(VEHICLE)) for c in candidates)
    choices = tuple(Choice(n, (k,), 3.0) for k, n in enumerate(names))
    weights: Any = None
    linear = Linear(observation, point, columns, choices, (None,) * len(choices), (), weights, sums)
    scales = Scales(0.0)
    scorer = linear.scorer(scales)

    asked = []

    def fitted(labels, like, go_on=False):
        asked.append((tuple(labels), go_on))
        chosen = tuple(names.index(x) for x in labels)
        return Fit(linear, chosen, scales, scorer.solution(chosen))

    whole = fitted(chosen, None)
    asked.clear()
    return SimpleNamespace(fitted=fitted, afresh=lambda made: made, known=(), barred={}, asked=asked), whole
