"""Steps to the numbers of a set: with the columns that there are, with new ones, and by half."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.select import search as module
from infotraj.diagnosis.select.around import linearised
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.prior import Scales
from infotraj.diagnosis.select.search import Search
from infotraj.effects import catalogue
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

FILE = Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml"
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.001, "velocity": 0.005}


def candidate(name):
    cls = catalogue()[name]
    return Candidate(cls, tuple(p for p in cls.parameters if not p.index))


@pytest.fixture(scope="module")
def begun():
    """A vehicle a fifth heavier than its file, with drag: the model around half of its mass and a drag of nothing."""
    vehicle, true = load_vehicle(FILE), yaml.safe_load(FILE.read_text())
    hidden = {"mass_offset": {"dm": vehicle.mass / 5}, "linear_drag": {"d": [0.3, 0.3, 0.0]}}
    observation = observe(Model(vehicle), [Flight(fly(true, hidden, seconds=6.0, seed=3, noise=NOISE), {})])
    mass, drag = candidate("mass_offset"), candidate("linear_drag")
    known = [mass, drag]
    point = [Member(mass, mass.cls(dm=-0.4 * vehicle.mass)), Member(drag, drag.absent(vehicle))]
    now = linearised(observation, point, known)
    scales, chosen = Scales(3.0), now.labelled(["mass_offset", "linear_drag"])
    fit = Fit(now, chosen, scales, now.scorer(scales).solution(chosen), tuple(known), exact=True)
    return Search(observation, tuple(known), ()), fit


def count_columns(monkeypatch):
    made = []

    def counted(*args, **more):
        made.append(1)
        return linearised(*args, **more)

    monkeypatch.setattr(module, "linearised", counted)
    return made


def test_columns_are_made_anew_where_steps_with_the_old_ones_promise_more_and_not_where_they_settle(begun, monkeypatch):
    """Of half the mass a force makes twice as much: each step leaves more than a tenth of what it promised."""
    search, fit = begun
    made = count_columns(monkeypatch)
    there = search._settled(fit, fit.labels, 5, True)
    assert made
    assert abs(there.gain_left) < 1.0
    assert there.members[0].effect.dm == pytest.approx(search.observation.vehicle.mass / 5, rel=0.03)
    made.clear()
    again = search._settled(there, there.labels, 5, True)
    assert not made
    assert again.solution.theta == pytest.approx(there.solution.theta, rel=1e-3, abs=1e-3)


def test_the_columns_of_a_set_that_has_lost_an_effect_are_made_anew(begun, monkeypatch):
    search, fit = begun
    there = search._settled(fit, fit.labels, 5, True)
    made = count_columns(monkeypatch)
    without = search.fitted(["mass_offset"], there, go_on=True)
    assert made
    assert {m.candidate.name for m in without.linear.point} == {"mass_offset"}
    made.clear()
    search.fitted(["mass_offset"], there)
    assert not made


@pytest.mark.parametrize(
    ("errors", "asked", "taken"),
    [
        ([90.0], 1, 0),
        ([150.0, 95.0], 2, 1),
        ([150.0, 120.0, 110.0, 105.0, 102.0], 5, 4),
        ([150.0, 170.0, 90.0], 2, 0),
    ],
)
def test_a_step_is_halved_for_as_long_as_the_error_falls(errors, asked, taken, monkeypatch):
    """From an error of 100 to one of 80 that the linear model promises."""
    sums: Any = SimpleNamespace(width=1, whole_error=lambda _: 100.0)
    absent = SimpleNamespace(whole_error=lambda _: 80.0)
    now = SimpleNamespace(sums=sums, absent=absent, now=np.zeros(1), members=lambda chosen, x, **_: x)
    made: Any = SimpleNamespace(
        linear=now,
        chosen=(),
        exact=True,
        solution=SimpleNamespace(theta=np.ones(1)),
        next_point=lambda x: x[0],
        scales=None,
        held=None,
    )
    now.scorer = lambda *_: None
    search: Any = Search(None, (), ())  # type: ignore[arg-type]
    left = list(errors)
    tried = []

    def error(_, point):
        tried.append(float(point[0]))
        return left.pop(0)

    monkeypatch.setattr(Search, "_error", lambda self, like, point: error(like, point))
    monkeypatch.setattr(module, "linearised", lambda observation, point, *_, **__: point)
    assert search._stepped(made) == 0.5**taken
    assert tried == [0.5**k for k in range(asked)]
