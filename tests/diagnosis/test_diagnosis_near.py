"""Fits that keep the columns they have: the same numbers, for a tenth of the evaluations."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.diagnosis import held_members
from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.linear.candidates import Candidate, read, written
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.linear.sums import gathered
from infotraj.diagnosis.select.around import linearised
from infotraj.diagnosis.select.learned import around_fit, around_usual
from infotraj.diagnosis.select.predicting import left
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


@pytest.fixture(scope="module")
def best(first):
    """The search, and what it found: the delay and the centre of mass."""
    search = Search(first.observation, tuple(known(first)), ())
    return search, search.best(first)


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


def test_a_set_without_an_effect_is_the_same_with_the_columns_of_the_whole(best):
    search, whole = best
    assert set(whole.labels) == {"actuation_delay", "com_offset"}
    cheap = search.fitted(["com_offset"], whole)
    anew = search.fitted(["com_offset"], whole, rounds=8, go_on=True)
    lost = whole.solution.score - anew.solution.score
    assert lost > 30.0
    assert whole.solution.score - cheap.solution.score == pytest.approx(lost, rel=0.02)
    place = cheap.members[0].effect.r - anew.members[0].effect.r
    assert np.abs(place).max() < 2e-4


def test_a_channel_without_coefficients_says_nothing():
    """Of two flights one has its accelerometer in bursts that are too short for a window."""
    vehicle, content = load_vehicle(FILE), yaml.safe_load(FILE.read_text())
    tables = [fly(content, {}, seconds=6.0, seed=k, noise=NOISE) for k in (3, 4)]
    silent = (tables[1]["t"] % 0.8) > 0.12
    tables[1].loc[silent, ["ax", "ay", "az"]] = np.nan
    first = linearised(observe(Model(vehicle), [Flight(t, {}) for t in tables]), [], [candidate("linear_drag")])
    assert any(s.axis == "fx" and not len(s.band) for s in first.found)
    again = first.moved([])
    assert np.allclose(again.sums.gram, first.sums.gram)


def test_an_effect_that_the_model_has_keeps_its_form():
    """The model was made when nothing was known of speeds; its file has since been told the thrust coefficient."""
    vehicle, content = load_vehicle(FILE), yaml.safe_load(FILE.read_text())
    effect = catalogue()["gyroscopic"](momentum=0.02)
    (m,) = held_members(Model(vehicle, [effect]), Flight(fly(content, {}, seconds=1.0), {}))
    at = m.places(vehicle)
    assert [p.parameter for p in at] == ["momentum"]
    assert written(m.candidate, at, read(effect, at)).momentum == pytest.approx(0.02)


def numbers(members):
    return {m.candidate.name: m.effect for m in members}


def test_what_is_left_of_flights_is_that_of_the_model_as_it_is(first, best):
    """Without an effect the sums say the same of it; with those that were found it is the noise, and far less."""
    whole = best[1]
    before, after = left(whole, None), left(whole, whole.solution.each)
    np.testing.assert_allclose(before, first.absent.plain_error(np.zeros((2, first.sums.width))), rtol=1e-6)
    torque = [whole.linear.sums.axes.index(a) for a in ("tx", "ty")]
    assert (after[torque] < 0.05 * before[torque]).all()
    np.testing.assert_allclose(after, whole.linear.absent.plain_error(whole.solution.each), rtol=0.2)


def test_what_is_left_in_units_of_its_noise_is_what_the_weighted_sums_say(best):
    whole = best[1]
    sums, each = whole.linear.absent, whole.solution.each
    shares = left(whole, each, weighted=True) / left(whole, None, weighted=True)
    by_sums = whole.error(each).sum(axis=1) / whole.error(np.zeros_like(each)).sum(axis=1)
    torque = [sums.axes.index(a) for a in ("tx", "ty")]
    assert (shares[torque] < 0.05).all()
    # The sums have the model linear, and torques fall by a million.
    rest = np.delete(np.arange(len(shares)), torque)
    np.testing.assert_allclose(shares[rest], by_sums[rest], rtol=0.5)
    # With what was found it is about what is expected of noise.
    stays = left(whole, each, weighted=True)
    np.testing.assert_allclose(stays[rest], (whole.error(each).sum(axis=1) / sums.noise)[rest], rtol=0.5)
    assert (stays[rest] < 2.0).all()


def test_numbers_that_are_refined_together_are_those_of_the_flights_and_nothing_is_held(first, best):
    made = around_fit(best[1], known(first))
    found = numbers(made.point)
    assert found["actuation_delay"].delay == pytest.approx(0.012, abs=1e-3)
    assert found["com_offset"].r == pytest.approx([0.004, -0.003, 0.0], abs=5e-4)
    assert not any(m.held for m in made.point)


def test_where_nothing_is_identified_the_mean_torque_of_the_flights_is_a_steady_one(first):
    """A weight at (4, -3) mm beside the middle of the rotors turns the body by -r x F."""
    made = around_usual(first, known(first))
    weight = first.observation.vehicle.mass * first.observation.vehicle.gravity
    assert set(numbers(made.point)) == {"steady_torque"}
    torque = numbers(made.point)["steady_torque"].t
    assert torque == pytest.approx([0.003 * weight, 0.004 * weight, 0.0], abs=0.2 * 0.004 * weight)
