"""Places: none where nothing is hidden, the right quantity where something is, sentences with numbers."""

import json
import re
from dataclasses import replace
from pathlib import Path

import fast_flyer
import numpy as np
import pytest
from click.testing import CliRunner

from infotraj.flight import Flight
from infotraj.locating import summary
from infotraj.locating.command import locate_command
from infotraj.locating.locating import locate
from infotraj.locating.regions import region
from infotraj.locating.search import Draws, Ranges, describe, shuffled
from infotraj.locating.sentences import place_lines, place_sentence
from infotraj.locating.windows import TimeWindow
from infotraj.models import load_model

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"
QUADROTOR, OMAV = VEHICLES / "quadrotor.yaml", VEHICLES / "omav.yaml"


def flown(path, hidden=None, seed=0, seconds=16.0, low=1.0):
    return Flight(fast_flyer.fly(path, seconds, seed, hidden, low=low))


def test_nothing_hidden_nothing_named():
    """Three flights here; the study of 120 is in docs/compare.md (tests/support/study_places.py)."""
    model = load_model(QUADROTOR)
    for seed in range(3):
        found = locate(model, [flown(QUADROTOR, seed=seed)])
        assert not found.places
        assert not found.windows
        assert "no place" in summary.as_text(found)


def test_an_error_in_single_windows_is_said_first_and_is_no_error_that_nothing_holds():
    found = locate(load_model(QUADROTOR), [flown(QUADROTOR, seconds=6.0)])
    lines = summary.as_text(
        replace(found, windows=(TimeWindow(0, "tx", 2.0, 3.0, 0.3, 29.5, 803.0, 0.9),))
    ).splitlines()
    assert lines[0].startswith("it fails in single windows of time")
    assert lines[0].endswith("no state or input goes with them:")
    assert "2.0 to 3.0 s: tx error is 29.5 times the rest of the flight, 803 times the floor" in lines[1]
    assert not [x for x in lines if "no place" in x or x.startswith("in time")]


@pytest.mark.parametrize(
    ("path", "hidden", "low", "group"),
    [
        (QUADROTOR, {"linear_drag": 0.1}, 1.0, "speed"),
        (QUADROTOR, {"ground_effect": 0.3}, 0.15, "height"),
        (QUADROTOR, {"battery_sag": 0.003}, 1.0, "time"),
        (OMAV, {"rotor_interference": 0.06}, 1.0, "tilt"),
        (OMAV, {"servo_lag": 0.03}, 1.0, "tilt rate"),
    ],
)
def test_the_hidden_effect_is_named_by_its_quantity_first(path, hidden, low, group):
    found = locate(load_model(path), [flown(path, hidden, seed=5, low=low)])
    assert found.places[0].group == group


def test_a_sentence_says_where_how_much_and_against_which_floor():
    flights = [flown(QUADROTOR, {"linear_drag": 0.1}, seed=k, seconds=10.0) for k in (1, 2)]
    found = locate(load_model(QUADROTOR), flights)
    lateral = next(p for p in found.places if p.axis == "fx")
    assert lateral.quantity.name == "forward speed"
    sentence = place_sentence(lateral)
    for part in ("fx error", "times the rest (", ", 95 %) where", "m/s", "of the samples hold", "floor", "follows"):
        assert part in sentence
    slope = np.polyfit(*lateral.trend, 1)[0]
    assert slope == pytest.approx(-0.1, rel=0.1)
    assert lateral.region.low < lateral.region.ratio < lateral.region.high
    assert all(leaf.samples > 0 for tree in found.trees.values() for leaf in tree)


def test_numbers_of_a_place_hold_the_mean_and_say_what_was_taken_out():
    """Drag of 0.1 N s/m under a constant 0.5 N: at each end of the speed the error is 0.5 - 0.1 v."""
    model, constant = load_model(QUADROTOR), 0.5
    flight = flown(QUADROTOR, {"linear_drag": 0.1}, seed=1, seconds=10.0)
    pushed = Flight(flight.table.assign(ax=flight.table["ax"] + constant / model.vehicle.mass))
    found = locate(model, [pushed])
    place = next(p for p in found.places if p.axis == "fx")
    sentence = place_sentence(place)
    said = re.search(r"with its mean it follows .*: (\S+) N at (\S+) m/s, (\S+) N at (\S+) m/s", sentence)
    first, slow, last, fast = map(float, said.groups())
    mean = float(re.search(r"taken off before: its mean of (\S+) N$", sentence)[1])
    assert mean == pytest.approx(place.mean, rel=0.01)
    assert (first, last) == pytest.approx((constant - 0.1 * slow, constant - 0.1 * fast), abs=0.02)
    small = place_sentence(replace(place, mean=0.1 * place.floor))
    assert "taken off" not in small
    assert "with its mean" not in small
    second = place_sentence(replace(place, taken=("height",)))
    assert second.endswith(f"taken off before: its mean of {mean:+.3g} N and what follows the height")
    assert "with its mean" not in second
    text = summary.as_text(found)
    assert "of all its squared error" in text
    # What a stranger reads once: short lines, and what is off every axis said at their head.
    assert "worst first, each axis beside its mean:" in text
    assert max(map(len, text.splitlines())) <= 110
    assert "taken off before: what follows the height" in place_lines(replace(place, taken=("height",)))


def test_the_same_seed_gives_the_same_answer():
    flight, model = flown(QUADROTOR, {"linear_drag": 0.05}, seconds=8.0), load_model(QUADROTOR)
    one, two = (summary.as_dict(locate(model, [flight], rng=np.random.default_rng(3))) for _ in range(2))
    assert json.dumps(one) == json.dumps(two)


def test_a_late_measurement_is_told_as_a_delay():
    found = locate(load_model(OMAV), [flown(OMAV, {"delay_rows": 3}, seed=4)])
    lags = {k.axis: k for k in found.lags}
    assert lags["fx"].late or lags["fy"].late
    late = lags["fx"] if lags["fx"].share > lags["fy"].share else lags["fy"]
    assert late.delay == pytest.approx(0.015, abs=0.006)


def test_a_mean_that_bends_with_the_quantity_is_found_exactly():
    rng = np.random.default_rng(0)
    x = rng.uniform(-1, 1, 2000)
    ranges = Ranges.of(x)
    heights = np.array([0.3, -1.0, 0.0, 2.0, 1.0])
    found = describe(ranges, ranges.mean(heights)[:, None], Draws.data(np.zeros(2000, dtype=int)))
    assert np.allclose(found.heights[0, 0], heights, atol=1e-6)
    assert found.explained[0, 0] == pytest.approx(1.0)


def test_a_spread_that_grows_counts_as_much_as_a_mean():
    rng = np.random.default_rng(0)
    x = rng.uniform(0, 1, 3000)
    data = Draws.data(np.zeros(3000, dtype=int))
    grows = describe(Ranges.of(x), (x * rng.standard_normal(3000))[:, None], data).gain[0, 0]
    even = describe(Ranges.of(x), rng.standard_normal((3000, 1)), data).gain[0, 0]
    assert even < 15
    assert grows > 20 * even


def test_shuffled_blocks_stay_in_their_flight_and_lose_no_row():
    flights = np.repeat([0, 1, 2], [100, 40, 60])
    for order in shuffled(flights, 8.0, 20, np.random.default_rng(0)):
        assert np.array_equal(np.sort(order), np.arange(200))
        assert np.array_equal(flights[order], flights)
        assert np.mean(np.diff(order) == 1) > 0.6


def test_flight_means_are_dealt_among_flights():
    """A residual that differs from flight to flight only is no evidence for a quantity that does so too."""
    rng = np.random.default_rng(0)
    flights = np.repeat(np.arange(7), 150)
    level, rise = rng.standard_normal(7), rng.standard_normal(7)
    residual = (level[flights] + 0.05 * rng.standard_normal(1050))[:, None]
    quantity = rise[flights] + 0.1 * rng.standard_normal(1050)
    gain = describe(Ranges.of(quantity), residual, Draws.of(flights, 20.0, 199, rng)).gain[:, 0]
    assert (gain[1:] >= gain[0]).mean() > 0.03


def test_the_region_is_where_the_error_is():
    rng = np.random.default_rng(0)
    x = rng.uniform(-2, 2, 4000)
    residual = np.where(np.abs(x) > 1.5, 4.0, 1.0) * rng.standard_normal(4000)
    found = region(x, residual, np.arange(4000) // 40, True, rng)
    assert found.side == "beyond"
    assert found.threshold == pytest.approx(1.5, abs=0.05)
    assert found.ratio == pytest.approx(4.0, rel=0.1)
    assert found.low < 4.0 < found.high
    assert found.samples == pytest.approx(0.25, abs=0.02)


@pytest.mark.long
def test_command_writes_json_and_figures(tmp_path):
    path = tmp_path / "a.parquet"
    flown(QUADROTOR, {"linear_drag": 0.1}, seconds=8.0).write(path)
    out, figures = tmp_path / "out.json", tmp_path / "figures"
    arguments = [QUADROTOR, path, "--json", out, "--figures", figures]
    done = CliRunner().invoke(locate_command, [str(a) for a in arguments], standalone_mode=False)
    assert done.exception is None, done.exception
    content = json.loads(out.read_text())
    assert content["places"][0]["group"] == "speed"
    assert content["places"][0]["region"]["ci95"][0] > 1.0
    assert {p.name for p in figures.glob("*.png")} == {"places.png", "residuals.png", "time.png", "lags.png"}
    assert "next: infotraj diagnose" in done.stderr


def test_a_diagnosis_comes_next_only_where_something_is_left(tmp_path):
    path = tmp_path / "a.parquet"
    said = []
    for hidden in ({}, {"linear_drag": 0.3}):
        flown(QUADROTOR, hidden, seconds=6.0).write(path)
        said.append(CliRunner().invoke(locate_command, [str(QUADROTOR), str(path)], standalone_mode=False))
    fits, drag = said
    assert "no place" in fits.stdout
    assert f"next: infotraj design {QUADROTOR} --flown {path} -o ref.csv" in fits.stderr
    assert "nothing is left to name" in fits.stderr
    assert f"next: infotraj diagnose {QUADROTOR} {path}" in drag.stderr
    assert "nothing is left" not in drag.stderr
