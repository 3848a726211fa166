"""Delays, regions, ranges, quantities and samples of a search, by series whose numbers are known."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.flight import Flight
from infotraj.locating.healthy import Beside, _rms, _usual
from infotraj.locating.lags import lags
from infotraj.locating.locating import Located
from infotraj.locating.places import Place, find_places
from infotraj.locating.quantities import Quantity, cannot_name, held, quantities
from infotraj.locating.ranges import by_range, place_spans
from infotraj.locating.regions import Region, blocks_of, measured, region
from infotraj.locating.samples import Samples, _capped, samples
from infotraj.locating.search import Draws, describe_cells
from infotraj.locating.tree import _simplified, leaves
from infotraj.locating.windows import worst_windows
from infotraj.vehicle import load_vehicle

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"
QUAD = load_vehicle(VEHICLES / "quadrotor.yaml")
SOME = dict(red=np.ones(6), unit={"force": "N", "torque": "N m"}, force_from="", window=0.15, reasons={}, left_out={})


def error(t, measured, predicted=None, floor=0.1):
    """An equation error of which one axis alone is given, (n,)."""
    side, other = np.zeros((2, len(t), 6))
    side[:, 0], other[:, 0] = measured, 0.0 if predicted is None else predicted
    return EquationError(t, side, other, np.full(6, floor), **SOME)


@pytest.mark.parametrize("late", [0.02, -0.03])
def test_a_measurement_that_is_late_lags_by_that_much(late):
    """y(t - d) - y(t) is -d y' to first order."""
    t = 50.0 + 0.01 * np.arange(4000)
    noise = np.random.default_rng(0).normal(0, 0.02, len(t))

    def wave(time):
        return np.sin(2.1 * time) + 0.5 * np.sin(5.3 * time)

    found = lags([error(t, wave(t - late) + noise, wave(t))])[0]
    assert found.axis == "fx"
    assert found.delay == pytest.approx(late, rel=0.03)
    assert found.late
    # Noise of 0.02 beside an error of d times a slope of deviation sqrt(2.1^2 + 2.65^2) / sqrt(2).
    explained = late**2 * (2.1**2 + 2.65**2) / 2.0
    assert found.share == pytest.approx(explained / (explained + 0.02**2), abs=0.02)
    # Where the slope is known to 4000 rows of that noise.
    assert found.standard_error == pytest.approx(0.02 / np.sqrt(4000 * explained / late**2), rel=0.5)
    middle = len(found.lag) // 2
    assert found.auto[middle] == pytest.approx(1.0)
    assert (found.lag[0], found.lag[middle], found.lag[-1]) == pytest.approx((-0.5, 0.0, 0.5))
    assert np.sign(found.cross[middle]) == -np.sign(late)
    assert abs(found.cross[middle]) == pytest.approx(np.sqrt(found.share), abs=0.02)


def test_a_small_part_of_a_residual_is_no_delay_and_white_noise_has_no_memory():
    t = 0.01 * np.arange(4000)
    noise = np.random.default_rng(0).normal(0, 0.2, len(t))
    found = lags([error(t, np.sin(2 * (t - 0.02)) + noise, np.sin(2 * t))])[0]
    assert abs(found.delay) > 2.58 * found.standard_error
    assert not found.late
    # Of 4000 independent values a correlation lies within 2.58 / sqrt(4000), one in a hundred times not.
    assert found.band == pytest.approx(2.58 / np.sqrt(4000), rel=0.15)
    away = np.abs(found.lag) > 0.005
    assert np.mean(np.abs(found.auto[away]) > found.band) < 0.1


def test_the_residual_later_than_the_commands_stands_at_positive_lags():
    """What follows a change of the prediction after 0.2 s."""
    rng = np.random.default_rng(0)
    t = 0.01 * np.arange(6000)
    predicted = np.cumsum(rng.normal(0, 1, len(t)))
    slope = np.gradient(predicted, 0.01)
    later = np.concatenate([np.zeros(20), slope[:-20]])
    found = lags([error(t, predicted + 0.01 * later, predicted)])[0]
    assert found.lag[np.argmax(found.cross)] == pytest.approx(0.2)


def test_a_gap_parts_the_series():
    t = 0.01 * np.arange(3000)
    t[1500:] += 7.0
    wave = np.sin(2 * (t - 0.03)), np.sin(2 * t)
    assert lags([error(t, *wave)])[0].delay == pytest.approx(0.03, rel=0.05)
    jumped = wave[0].copy(), wave[1].copy()
    jumped[1][1500:] += 100.0
    jumped[0][1500:] += 100.0
    assert lags([error(t, *jumped)])[0].delay == pytest.approx(0.03, rel=0.05)


def test_what_a_piece_is_off_by_is_no_delay_however_its_prediction_climbs():
    """One piece climbs and is off upwards, the other falls and is off downwards."""
    t = 0.01 * np.arange(6000)
    t[3000:] += 7.0
    sign = np.where(np.arange(6000) < 3000, 1.0, -1.0)
    noise = np.random.default_rng(0).normal(0.0, 0.1, 6000)
    predicted = sign * t + 0.5 * np.sin(2.0 * t)
    found = lags([error(t, predicted + 0.1 * sign + noise, predicted)])[0]
    assert abs(found.delay) < 3.0 * found.standard_error < 0.04
    assert not found.late


def place_of(values, where, inside=3.0, signed=False, seed=0):
    """The region of a residual of 1 that is `inside` where something holds of the values."""
    residual = np.where(where(values), inside, 1.0) * np.where(np.arange(len(values)) % 2, 1.0, -1.0)
    blocks = np.arange(len(values)) // 20
    return region(values, residual, blocks, signed, np.random.default_rng(seed))


@pytest.mark.parametrize(
    ("where", "side", "threshold"),
    [
        (lambda v: v > 1.0, "above", 1.0),
        (lambda v: v < -1.0, "below", -1.0),
        (lambda v: np.abs(v) > 1.2, "beyond", 1.2),
    ],
)
def test_a_region_is_the_side_of_a_threshold_on_which_the_error_is_larger(where, side, threshold):
    values = np.random.default_rng(1).standard_normal(4000)
    found = place_of(values, where, signed=True)
    share = where(values).mean()
    assert (found.side, found.threshold) == (side, pytest.approx(threshold, abs=0.01))
    assert found.samples == pytest.approx(share)
    assert found.squares == pytest.approx(9 * share / (9 * share + 1 - share))
    assert (found.inside, found.outside, found.ratio) == pytest.approx((3.0, 1.0, 3.0))
    assert found.low <= 3.0 <= found.high
    np.testing.assert_array_equal(found.holds(values), where(values))


def test_a_region_holds_a_twentieth_of_the_rows_and_no_more_than_three_fifths():
    values = np.random.default_rng(1).uniform(0.0, 1.0, 4000)
    assert place_of(values, lambda v: v > 0.99).samples == pytest.approx(0.05, abs=0.001)
    assert place_of(values, lambda v: v > 0.9).samples == pytest.approx(0.1, abs=0.02)
    assert place_of(values, lambda v: v > 0.2).samples <= 0.6


def test_an_interval_of_a_ratio_is_what_resampled_blocks_give():
    """Squares of blocks that scatter: 40 inside and 160 outside, of chi-squared means of 25 rows each."""
    rng = np.random.default_rng(0)
    rows = np.arange(5000) < 1000
    scale = np.repeat(np.sqrt(rng.chisquare(4, 200) / 4), 25)
    residual = scale * np.where(rows, 2.0, 1.0) * rng.standard_normal(5000)
    found = measured(rows, residual, np.arange(5000) // 25, np.random.default_rng(1), "cell", 0.0)
    # A block's mean square scatters by sqrt(1/2 + 2/25 ..) of itself; a ratio of roots by half of that over sqrt(40).
    scatter = 0.5 * np.sqrt((0.5 + 3 / 25) * (1 / 40 + 1 / 160)) * found.ratio
    assert found.high - found.low == pytest.approx(2 * 1.96 * scatter, rel=0.3)


def test_blocks_are_of_one_flight_and_so_many_seconds():
    flight, t = np.repeat([0, 1], 6), np.tile(10.0 + np.arange(6.0), 2)
    assert blocks_of(flight, t, 2.0).tolist() == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5]


def test_ranges_hold_equally_many_rows_with_their_means_and_root_mean_squares():
    x = np.arange(1200.0)
    y = np.where(np.arange(1200) % 2, 3.0, -1.0) * (x >= 600)
    middle, mean, rms = by_range(x, y)
    assert middle == pytest.approx(49.5 + 100.0 * np.arange(12), abs=0.6)
    assert mean == pytest.approx(np.repeat([0.0, 1.0], 6), abs=0.02)
    assert rms == pytest.approx(np.repeat([0.0, np.sqrt(5.0)], 6), abs=0.02)


@pytest.mark.parametrize(
    ("side", "threshold", "spans"),
    [("above", 1.0, [(1.0, 3.0)]), ("below", 1.0, [(-2.0, 1.0)]), ("beyond", 1.0, [(-2.0, -1.0), (1.0, 3.0)]),
     ("beyond", 2.5, [(2.5, 3.0)])],
)  # fmt: skip
def test_a_place_lies_on_its_side_of_the_threshold(side, threshold, spans):
    at = SimpleNamespace(side=side, threshold=threshold)
    assert place_spans(at, -2.0, 3.0) == spans


def motion(seconds=10.0, **columns):
    t = np.arange(0.0, seconds, 0.01)
    return t, Flight(pd.DataFrame({"t": t, **{k: np.broadcast_to(v, t.shape) for k, v in columns.items()}}))


def test_quantities_are_those_of_the_motion():
    """Turned by 30 degrees about y, nose down: what goes ahead in the world goes ahead and up in the body."""
    half = np.radians(30.0) / 2.0
    commands = {f"cmd_rotor_{i}": 600.0 for i in range(4)}
    turned = {"qw": np.cos(half), "qx": 0.0, "qy": np.sin(half), "qz": 0.0}
    _, flight = motion(**turned, vx=3.0, vy=-4.0, vz=0.0, wx=1.0, wy=2.0, wz=-2.0, px=0.0, py=0.0, pz=1.5, **commands)
    found = {q.name: q for q in quantities(flight, QUAD, 0.15)}
    thrust = 4 * QUAD.rotors[0].thrust_coefficient * 600.0**2
    expected = {"speed": 5.0, "forward speed": 3.0 * np.cos(2 * half), "sideways speed": -4.0, "upward speed": 1.5,
                "tilt of the body": 30.0, "pitch": 30.0, "roll": 0.0, "turning rate": 3.0, "rate about z": -2.0,
                "height": 1.5, "thrust": thrust, "change of the rotors' thrust in fz": 0.0}  # fmt: skip
    for name, value in expected.items():
        assert np.median(found[name].values) == pytest.approx(value, abs=1e-6), name
    assert found["time"].values[-1] == pytest.approx(9.99)
    assert found["sideways speed"].signed
    assert not found["speed"].signed
    assert cannot_name(flight, QUAD) == ["battery"]
    assert cannot_name(Flight(flight.table[["t", "vx", "vy", "vz"]]), QUAD) == [
        "height", "tilt", "rate", "battery", "thrust",
    ]  # fmt: skip


def test_the_thrust_of_a_commanded_wrench_is_its_force():
    cmd = {f"cmd_{a}": v for a, v in zip(AXES, (0.0, 3.0, 4.0, 20.0, 30.0, 40.0), strict=True)}
    _, flight = motion(**cmd)
    found = {q.name: q for q in quantities(flight, load_vehicle(VEHICLES / "crazyswarm2.yaml"), 0.15)}
    assert np.median(found["thrust"].values) == pytest.approx(5.0)


def test_thrust_that_grows_changes_the_axes_that_its_rotor_pushes():
    """One rotor of four gains 1 N a second: its arm's torque grows by as much a metre, and its reaction against it."""
    k, tau = QUAD.rotors[0].thrust_coefficient, QUAD.rotors[0].time_constant
    t = np.arange(0.0, 10.0, 0.01)
    rising = {f"cmd_rotor_{i}": np.sqrt((1.0 + (t if i == 1 else 0.0 * t)) / k) for i in range(4)}
    found = {q.name: q.values for q in quantities(Flight(pd.DataFrame({"t": t, **rising})), QUAD, 0.15)}
    x, y, _ = QUAD.rotors[1].position
    reaction = -QUAD.rotors[1].spin * QUAD.rotors[1].moment_constant
    late = slice(600, 900)  # long after the lag has settled
    assert tau < 0.1
    for axis, slope in zip(AXES, (0.0, 0.0, 1.0, y, -x, reaction), strict=True):
        values = found[f"change of the rotors' thrust in {axis}"][late]
        np.testing.assert_allclose(values, slope, atol=0.02 * max(abs(slope), 0.01))


def test_a_value_is_held_until_the_next_and_the_first_before_it():
    _, flight = motion(0.06, battery=np.array([np.nan, 12.0, np.nan, np.nan, 11.0, np.nan]))
    assert held(flight, ["battery"])[:, 0].tolist() == [12.0, 12.0, 12.0, 12.0, 11.0, 11.0]


def test_a_voltage_that_spikes_for_a_tenth_of_a_second_keeps_its_level():
    t = np.arange(0.0, 10.0, 0.01)
    volts = 12.0 - 0.1 * t
    volts[500:510] = 8.0
    volts[700:800] = 8.0
    _, flight = motion(battery=volts)
    (found,) = [q.values for q in quantities(flight, QUAD, 0.15) if q.name == "battery voltage"]
    assert found[505] == pytest.approx(11.5, abs=0.05)
    assert found[750] == pytest.approx(8.0, abs=0.05)


def test_samples_are_thinned_to_three_a_window_and_floors_weigh_by_their_rows():
    t = np.arange(0.0, 30.0, 0.01)
    errors = [error(t, np.sin(t), floor=0.1), error(t[:600], np.sin(t[:600]), floor=0.3)]
    errors[0].measured[::7, 1] = np.nan
    flights = [Flight(pd.DataFrame({"t": e.t, "battery": 12.0 - 0.01 * e.t})) for e in errors]
    force, torque = samples(flights, QUAD, errors)
    assert torque.spacing == pytest.approx(0.05)
    rows = [np.sum(torque.flight == k) for k in (0, 1)]
    assert rows == [600, 120]
    assert torque.floor == pytest.approx(np.full(3, np.sqrt((600 * 0.01 + 120 * 0.09) / 720)))
    assert not np.isnan(force.residual).any()
    assert (force.unit, torque.unit) == ("N", "N m")
    assert [q.name for q in torque.quantities] == ["time", "battery voltage"]
    # What is too much is thinned alike, to the end of every flight.
    capped = _capped([np.arange(9000), np.arange(100)])
    assert [len(r) for r in capped] == [4500, 50]
    assert capped[0][-1] >= 8998


def rows_of(residual, *named, floor=0.5):
    n = len(residual)
    found = tuple(Quantity(k, k, "m/s", v, signed) for k, v, signed in named)
    axes, flight = ("fx",), np.zeros(n, dtype=int)
    return Samples(axes, residual[:, None], np.array([floor]), "N", flight, 0.05 * np.arange(n), 0.05, found)


def test_a_tree_tells_the_corner_that_holds_the_error_in_units_of_the_floor():
    rng = np.random.default_rng(0)
    speed, height = rng.uniform(-3.0, 3.0, 4000), rng.uniform(0.0, 2.0, 4000)
    fast = np.abs(speed) > 2.0
    residual = np.where(fast, 4.0, 0.5) * np.where(np.arange(4000) % 2, 1.0, -1.0)
    worst, rest = leaves(rows_of(residual, ("speed", speed, True), ("height", height, False)), "fx")
    ((name, unit, side, cut),) = worst.conditions
    assert (name, unit, side, cut) == ("|speed|", "m/s", "above", pytest.approx(2.0, abs=0.01))
    assert (worst.over_floor, rest.over_floor) == pytest.approx((8.0, 1.0), rel=0.02)
    assert worst.samples == pytest.approx(fast.mean())
    assert worst.squares == pytest.approx(16 * fast.mean() / (16 * fast.mean() + 0.25 * (1 - fast.mean())), rel=0.01)
    (alone,) = leaves(rows_of(rng.standard_normal(4000), ("speed", speed, True)), "fx")
    assert alone.conditions == ()


def test_of_two_bounds_on_one_side_the_tighter_one_is_said():
    bounds = [("v", "m", "above", 1.0), ("v", "m", "above", 2.0), ("v", "m", "below", 5.0), ("v", "m", "below", 4.0)]
    assert _simplified(bounds) == [("v", "m", "above", 2.0), ("v", "m", "below", 4.0)]


def test_cells_gain_what_their_own_means_and_spreads_explain():
    """Two cells of means +-1 with a noise of 0.1: n / 2 ln of the variance as a whole over that in a cell."""
    rng = np.random.default_rng(0)
    cell = rng.integers(0, 2, 2000)
    residual = (2.0 * cell - 1.0 + 0.1 * rng.standard_normal(2000))[:, None]
    gain = describe_cells(cell, 2, residual, Draws.data(np.zeros(2000, dtype=int)))[0, 0]
    assert gain == pytest.approx(1000 * np.log(1.01 / 0.01), rel=0.03)


def test_a_healthy_flight_is_asked_for_the_error_at_the_place():
    values = np.linspace(-3.0, 3.0, 600)
    residual = np.where(values > 1.0, 2.0, 0.5)
    quantity = Quantity("speed", "speed", "m/s", values, signed=True)
    of = rows_of(residual, ("speed", values, True))
    every = np.ones(600, dtype=bool)
    at = Region("above", 1.0, 0.3, 0.9, 4.0, 3.0, 5.0, 2.0, 0.5, values > 1.0)
    place = Place("fx", "N", quantity, None, 0.01, 1.0, 0.5, 1.0, 0.1, at, (np.zeros(0), np.zeros(0)))
    assert _rms(of, place, every) == pytest.approx(2.0)
    # A region whose ratio may be 1 is none: the error is that of all rows.
    everywhere = replace(place, region=replace(at, low=0.9))
    assert _rms(of, everywhere, every) == pytest.approx(np.sqrt(np.mean(residual**2)))
    few = np.arange(600) >= 590
    assert np.isnan(_rms(of, place, few))
    cell = replace(place, cell=((-1.0, 0.5), (0.0, 9.0)), other=Quantity("height", "height", "m", values))
    both = rows_of(residual + 0.1 * (values < 0.2), ("speed", values, True), ("height", values, False))
    inside = (values >= 0.0) & (values <= 0.5)
    assert _rms(both, cell, every) == pytest.approx(np.sqrt(np.mean(both.residual[inside, 0] ** 2)))


def test_a_bias_is_asked_of_the_flights_that_say_it_and_counts_by_its_share_of_the_square():
    some = [SimpleNamespace(bias=np.array([b, 0, 0, 0, 0, 0])) for b in (0.3, np.nan, -0.1)]
    assert Beside((), (), (), tuple(some)).bias("fx").tolist() == [0.3, -0.1]
    overall = SimpleNamespace(
        bias=np.array([0.6, 0.04, 0, 0, 0, 0]), rmse=np.ones(6), floor=np.full(6, 0.1), rows=np.ones(6)
    )
    located = Located((), (), (), (), (), {}, (), overall, (), ())
    assert located.offsets == [("fx", 0.6, pytest.approx(0.36))]


def test_windows_of_noise_do_not_stand_out_and_a_window_has_its_share_of_the_squares():
    rng = np.random.default_rng(0)
    t = 50.0 + 0.01 * np.arange(3000)
    noise = np.repeat(rng.normal(0.0, 1.0, (600, 6)), 5, axis=0)
    quiet = EquationError(t, noise, np.zeros((3000, 6)), np.ones(6), **SOME)
    assert worst_windows([quiet]) == []
    loud = noise.copy()
    loud[1000:1200, 2] += np.where(np.arange(200) % 2, 6.0, -6.0)
    (found,) = worst_windows([EquationError(t, loud, np.zeros((3000, 6)), np.ones(6), **SOME)])
    assert (found.axis, found.start, found.stop) == ("fz", pytest.approx(60.0), pytest.approx(62.0))
    squares = (loud[:, 2] - loud[:, 2].mean()) ** 2
    assert found.share == pytest.approx(squares[1000:1200].sum() / squares.sum())
    assert found.rms == pytest.approx(np.sqrt(squares[1000:1200].mean()), rel=0.01)


def test_a_residual_that_remembers_itself_has_fewer_independent_values():
    """Each value is held for five rows: their correlations fall in a straight line over five lags."""
    t, rng = 0.01 * np.arange(4000), np.random.default_rng(0)
    white, held_for_five = rng.standard_normal(4000), np.repeat(rng.standard_normal(800), 5)
    predicted = np.cumsum(rng.standard_normal(4000))
    narrow, wide = (lags([error(t, predicted + x, predicted)])[0].band for x in (white, held_for_five))
    memory = 1.0 + 2.0 * np.sum((1.0 - np.arange(1, 5) / 5.0) ** 2)
    assert wide / narrow == pytest.approx(np.sqrt(memory), rel=0.15)


def test_every_healthy_flight_is_asked_by_itself():
    quantity = Quantity("speed", "speed", "m/s", np.ones(300))
    residual = np.repeat([0.5, 2.0, 1.0], 100)
    theirs = replace(rows_of(residual, ("speed", np.ones(300), False)), flight=np.repeat([0, 1, 2], 100))
    place = Place("fx", "N", quantity, None, 0.01, 1.0, 0.5, 1.0, 0.1, None, (np.zeros(0), np.zeros(0)))
    found = _usual(place, [rows_of(np.full(300, 3.0), ("speed", np.ones(300), False))], [theirs], 3)
    assert found.now == pytest.approx(3.0)
    assert found.rms == pytest.approx([0.5, 2.0, 1.0])
    assert np.isnan(_usual(place, [theirs], [], 2).rms).all()


@pytest.mark.parametrize(("size", "found"), [(0.7, 1), (0.35, 0)])
def test_a_place_is_one_whose_square_is_a_quarter_of_the_floor_s(size, found):
    """A slope whose mean square is the floor's times size^2."""
    speed = np.random.default_rng(0).uniform(-1.0, 1.0, 3000)
    slope = size * 0.5 * np.sqrt(3.0) * speed + 0.02 * np.random.default_rng(1).standard_normal(3000)
    made = find_places(rows_of(slope, ("speed", speed, False)), np.random.default_rng(0), draws=99)
    assert len(made.places) == found
    if found:
        assert made.places[0].excess >= 0.4
        assert made.places[0].explained == pytest.approx(1.0, abs=0.02)
