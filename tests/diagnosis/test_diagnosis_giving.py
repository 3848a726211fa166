"""The model that is given: no axis of flights that were not fitted is predicted worse for what is named."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from infotraj.diagnosis.judge import giving
from infotraj.diagnosis.judge.giving import _pruned
from infotraj.diagnosis.linear.candidates import Candidate, places
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.linear.sums import Sums
from infotraj.diagnosis.select.around import Column, Linear
from infotraj.diagnosis.select.prior import Scales
from infotraj.diagnosis.select.score import Choice
from infotraj.diagnosis.select.search import Fit
from infotraj.effects import catalogue
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml")
FLIGHTS = 4


@pytest.fixture(autouse=True)
def _linear(monkeypatch):
    """These fits have no flights: their sums say what is left."""

    def left(made, each):
        sums = made.linear.absent
        return sums.plain_error(np.zeros((FLIGHTS, sums.width)) if each is None else each)

    monkeypatch.setattr(giving, "_left", left)


def drag_on(sizes):
    """A fit of linear_drag, whose number on each axis is `sizes` (axes, flights), usual sizes, in each flight."""
    drag = catalogue()["linear_drag"]
    candidate = Candidate(drag, tuple(p for p in drag.parameters if not p.index))
    rng = np.random.default_rng(0)
    gram = np.zeros((3, FLIGHTS, 4, 4))
    for a in range(3):
        for k in range(FLIGHTS):
            x = np.zeros((200, 4))
            x[:, 1 + a] = rng.standard_normal(200)
            x[:, 0] = sizes[a][k] * x[:, 1 + a] + 0.1 * rng.standard_normal(200)
            gram[a, k] = x.T @ x
    flights = np.arange(FLIGHTS)
    sums = Sums(
        gram, gram, gram, np.full((3, FLIGHTS), 200.0), np.ones((3, FLIGHTS)), ("fx", "fy", "fz"), flights, flights
    )
    at = places(candidate, VEHICLE)
    columns = tuple(Column(candidate, i, p.scale, 0.0, -np.inf, np.inf) for i, p in enumerate(at))
    linear = Linear(
        SimpleNamespace(
            vehicle=VEHICLE, command_step=0.005, healthy=None, scatter={}, base=lambda c: c.absent(VEHICLE)
        ),
        (Member(candidate, candidate.absent(VEHICLE)),),
        columns,
        (Choice("linear_drag", (0, 1, 2), 3.0),),
        (None,),
        (),
        None,
        sums,
    )
    scales = Scales(0.0)
    return Fit(linear, (0,), scales, linear.scorer(scales).solution((0,)))


def test_what_holds_on_flights_that_were_not_fitted_stays():
    fit, lost, held_back = _pruned(drag_on([[1.0] * 4, [1.1] * 4, [0.9] * 4]))
    assert not lost
    assert not held_back
    np.testing.assert_allclose(fit.solution.theta, [1.0, 1.1, 0.9], atol=0.05)


def test_a_number_on_which_flights_do_not_agree_stays_absent_and_is_said():
    fit, lost, held_back = _pruned(drag_on([[1.0] * 4, [1.1] * 4, [1.0, -0.9, 1.1, -1.0]]))
    assert not lost
    assert "d[2]" in held_back["linear_drag"]
    assert "fz is predicted worse" in held_back["linear_drag"]
    assert fit.solution.theta[2] == 0.0
    (member,) = fit.members
    assert member.effect.values["d"][2] == 0.0
    assert member.effect.values["d"][0] == pytest.approx(1.0 * fit.linear.columns[0].scale, rel=0.05)


def test_an_effect_without_a_number_left_is_lost():
    _, lost, _ = _pruned(drag_on([[1.0, -0.9, 1.1, -1.0]] * 3))
    assert "predicted worse" in lost["linear_drag"]
