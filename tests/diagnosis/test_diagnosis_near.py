"""Fits that keep the columns they have: the same numbers, for a tenth of the evaluations."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.linear.sums import gathered
from infotraj.diagnosis.select.around import linearised
from infotraj.diagnosis.select.search import Search
from infotraj.effects import catalogue
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

FILE = Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml"
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.001, "velocity": 0.005}
HIDDEN = {"actuation_delay": {"delay": 0.012}, "com_offset": {"r": [0.004, -0.003, 0.0]}}


def candidate(name, *fixed):
    cls = catalogue()[name]
    return Candidate(cls, tuple(p for p in cls.parameters if not p.index), fixed)


@pytest.fixture(scope="module")
def first():
    vehicle, content = load_vehicle(FILE), yaml.safe_load(FILE.read_text())
    flights = [Flight(fly(content, HIDDEN, seconds=6.0, seed=k, noise=NOISE), {}) for k in (3, 4)]
    names = ("inertia_error", "com_offset", "actuation_delay", "rotor_lag", "steady_torque", "linear_drag")
    rotors = [candidate("rotor_effectiveness", ("rotor", k)) for k in range(4)]
    return linearised(observe(Model(vehicle), flights), [], [*map(candidate, names), *rotors])


def known(now):
    return list(dict.fromkeys(c.candidate for c in now.columns))


def test_the_residual_is_that_of_the_place_and_the_columns_stay(first):
    delay = candidate("actuation_delay")
    point = [Member(delay, delay.cls(delay=0.01))]
    moved, fresh = first.moved(point), linearised(first.observation, point, known(first), like=first, frozen=True)
    for a, b, before in zip(moved.found, fresh.found, first.found, strict=True):
        assert np.allclose(a.values[:, 0], b.values[:, 0], rtol=0, atol=1e-12)
        assert np.array_equal(a.values[:, 1:], before.values[:, 1:])
    at = next(i for i, c in enumerate(moved.columns) if c.candidate.name == "actuation_delay")
    assert moved.now[at] == pytest.approx(0.01 / moved.columns[at].scale)
    assert np.count_nonzero(moved.now) == 1


def test_sums_are_those_of_the_new_residual(first):
    delay = candidate("actuation_delay")
    moved = first.moved([Member(delay, delay.cls(delay=0.01))])
    again = gathered(moved.found, moved.weights, moved.observation.blocks)
    for name in ("gram", "plain", "believed"):
        mine, theirs = getattr(moved.sums, name), getattr(again, name)
        assert np.allclose(mine, theirs, rtol=1e-9, atol=1e-12 * np.abs(theirs).max()), name


def test_a_set_without_an_effect_is_the_same_with_the_columns_of_the_whole(first):
    search = Search(first.observation, tuple(known(first)), ())
    whole = search.best(first)
    assert set(whole.labels) == {"actuation_delay", "com_offset"}
    cheap = search.fitted(["com_offset"], whole)
    anew = search.fitted(["com_offset"], whole, rounds=8, go_on=True)
    lost = whole.solution.score - anew.solution.score
    assert lost > 30.0
    assert whole.solution.score - cheap.solution.score == pytest.approx(lost, rel=0.02)
    place = cheap.members[0].effect.r - anew.members[0].effect.r
    assert np.abs(place).max() < 2e-4
