"""A log may begin while the load swings: how it swings then is found from what is measured across the thrusts."""

import numpy as np
import pytest
from exact_simulation import fly
from test_effects_exact import errors, model_of, vehicle_file

from infotraj.effects import load
from infotraj.flight import Flight

LOAD = ("suspended_load", {"mass": 0.08, "length": 0.5})


@pytest.fixture(scope="module")
def swinging():
    """12 s of a quadrotor with drag, whose load hung still in the beginning."""
    return Flight(fly(vehicle_file("quadrotor"), [LOAD, drag()], seconds=12.0, motion=0.3))


def cut(flight, start):
    table = flight.table
    return Flight(table[table["t"] >= start].reset_index(drop=True))


def drag():
    return ("linear_drag", {"d": [0.1, 0.12, 0.2]})


@pytest.mark.parametrize("start", [1.7, 3.1, 4.4])
def test_a_log_that_begins_in_a_swing_is_explained(swinging, start):
    late = cut(swinging, start)
    with_load, without = errors(model_of("quadrotor", LOAD, drag()), late), errors(model_of("quadrotor", drag()), late)
    assert with_load[0] < 0.05 * without[0]


def test_at_rest_it_stays_at_rest(swinging):
    assert errors(model_of("quadrotor", LOAD, drag()), swinging)[0] < 2e-3


def test_what_an_accelerometer_adds_always_does_not_turn_the_cable(swinging):
    late = cut(swinging, 3.1)
    biased = Flight(late.table.assign(ax=late.table["ax"] + 0.3, ay=late.table["ay"] - 0.2))
    model = model_of("quadrotor", LOAD, drag())
    moved = model.predict(biased).specific_force - model.predict(late).specific_force
    assert np.sqrt(np.mean(moved[model.predict(late).covered] ** 2)) < 2e-3


def test_the_first_swing_is_looked_for_at_the_pendulum_s_own_frequency(monkeypatch):
    """A cable of 0.9 m under what holds the vehicle up: sqrt(g / l)."""
    asked = []

    def caught(across, swing, time, first, free):
        asked.append(free)
        return first, np.zeros(3)

    monkeypatch.setattr(load, "first_swing", caught)
    hidden = ("suspended_load", {"mass": 0.08, "length": 0.9})
    flight = Flight(fly(vehicle_file("quadrotor"), [hidden], seconds=6.0, motion=0.3))
    model_of("quadrotor", hidden).predict(flight)
    assert asked
    assert asked == pytest.approx([np.sqrt(9.81 / 0.9)] * len(asked), rel=0.05)


@pytest.mark.parametrize("rows", [2, 3, 4])
def test_a_flight_of_a_few_rows_has_a_load_too(swinging, rows):
    short = Flight(cut(swinging, 3.1).table.iloc[:rows])
    assert np.isfinite(model_of("quadrotor", LOAD).predict(short).specific_force).all()
