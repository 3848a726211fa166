"""Small parts of `check` by series whose answer is known: streams, lags, ground and flight, commands."""

import numpy as np
import pytest
from check_series import ALL, HOVER, QUAD, T, flight

from infotraj.checking.actuation import RPM, carrying_findings, column_findings
from infotraj.checking.airborne import Airborne, airborne_rows, no_flight
from infotraj.checking.clocks import line, minimum, offset
from infotraj.checking.outliers import impossible_commands
from infotraj.checking.response import collective
from infotraj.checking.streams import Stream, stream
from infotraj.flight import Flight

# Streams


def test_a_stream_is_averaged_as_its_straight_lines_say():
    t = np.array([0.0, 0.1, 0.3, 0.4, 0.5])
    made = Stream(t, (t**2)[:, None], gap=0.25)
    fine = np.linspace(0.05, 0.45, 40001)
    assert made.mean([0.25], 0.4)[0, 0] == pytest.approx(np.mean(np.interp(fine, t, t**2)), abs=1e-5)
    assert made.at([0.2])[0, 0] == pytest.approx(0.05)


def test_nothing_is_known_of_a_stream_outside_its_samples_or_across_a_gap():
    made = Stream(np.array([0.0, 0.1, 0.2, 0.6, 0.7]), np.ones((5, 1)), gap=0.25)
    assert np.isnan(made.at([-0.01, 0.15, 0.4, 0.65, 0.71])[:, 0]).tolist() == [True, False, True, False, True]
    assert np.isnan(made.mean([0.1, 0.15, 0.3, 0.65], 0.08)[:, 0]).tolist() == [False, False, True, False]
    kept = stream(flight(px=np.where(T < 6.0, np.nan, 1.0), py=0.0, pz=0.0), ("px", "py", "pz"))
    assert kept.t[0] == pytest.approx(6.0)
    assert kept.gap == pytest.approx(0.05)


# Clocks


def late(lag, noise=0.05, seed=0, unexplained=0.0):
    """A stream that is stamped `lag` late, its prediction at centres, and their blocks of 1 s."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 30.0, 0.01)
    f, phase = rng.uniform(0.2, 1.5, 6), rng.uniform(0.0, 6.28, 6)

    def signal(time):
        return np.sin(2 * np.pi * f[:, None] * time + phase[:, None]).sum(axis=0)[:, None] * np.ones(3)

    other = unexplained * np.sin(2 * np.pi * 1.7 * t)[:, None]
    x = signal(t - lag) + other + noise * rng.standard_normal((len(t), 3))
    centres = np.arange(1.0, 29.0, 0.03)
    return Stream(t, x, 0.05), signal(centres), centres, np.floor(centres).astype(int)


@pytest.mark.parametrize("lag", [0.037, -0.052, 0.0])
def test_a_lag_is_found_between_the_shifts_that_are_tried(lag):
    found = offset(*late(lag), width=0.02)
    assert found.lag == pytest.approx(lag, abs=max(5 * found.error, 5e-4))
    assert 1e-5 < found.error < 1e-3
    assert found.unexplained < 0.02
    assert len(found.segments) == 3
    assert all(abs(x - lag) < 5e-3 for _, x, _ in found.segments)


def test_a_lag_of_what_a_prediction_hardly_explains_is_none():
    """The share that is left of the stream: 2 of 2 + 3, and nearly all."""
    half = offset(*late(0.02, unexplained=2.0), width=0.02)
    assert half.unexplained == pytest.approx(2.0 / 5.0, abs=0.12)
    assert offset(*late(0.02, unexplained=9.0), width=0.02) is None


def test_the_error_of_a_lag_is_that_of_the_parabola_over_its_blocks():
    """Blocks whose parabolas have their least at +-0.01 s: the mean of ten of them is 0, to 0.01 / sqrt(9)."""
    shifts = np.arange(-0.05, 0.0501, 0.005)
    centre = np.where(np.arange(10) % 2, 0.01, -0.01)
    curve = (shifts[:, None] - centre) ** 2
    assert minimum(shifts, curve) == (pytest.approx(0.0, abs=1e-12), pytest.approx(0.01 / 3.0))
    moved = minimum(shifts, (shifts[:, None] - centre - 0.012) ** 2)
    assert moved == pytest.approx((0.012, 0.01 / 3.0))
    assert minimum(shifts, -curve) is None
    # At an end of what was tried the least is none.
    assert minimum(shifts, (shifts[:, None] - 0.05 * np.ones(10)) ** 2) is None


def test_a_line_through_segments_has_its_slope_and_the_error_of_its_scatter():
    t = np.arange(6.0)
    slope, error = line(tuple((x, 0.5 + 0.1 * x, 0.01) for x in t))
    assert slope == pytest.approx(0.1)
    assert error == pytest.approx(0.01 / np.sqrt(np.sum((t - t.mean()) ** 2)))
    scattered = line(tuple((x, 0.1 * x + s, 0.01) for x, s in zip(t, (0.1, -0.1, 0.1, -0.1, 0.1, -0.1), strict=True)))
    rest = np.array([0.1, -0.1] * 3)
    rest = rest - np.polyval(np.polyfit(t, rest, 1), t)
    assert scattered[1] == pytest.approx(np.sqrt(np.sum(rest**2) / 4 / np.sum((t - t.mean()) ** 2)))
    assert line(((0.0, 0.0, 0.1), (1.0, 1.0, 0.1)))[1] == np.inf


# In the air


def flying(height=1.0, on=(8.0, 20.0), motor=500.0):
    """Motors that run, and a height above a rest at 0.2 m, in part of the time."""
    begin, end = on
    up = (begin <= T) & (end > T)
    rotors = {f"rotor_{i}": np.where(up, motor + 5.0 * np.sin(7 * T + i), 40.0) for i in range(4)}
    return up, flight(px=np.sin(T), py=0.0, pz=0.2 + np.where(up, height, 0.0), **rotors)


def test_a_vehicle_flies_where_its_motors_run_and_it_is_away_from_its_rest_on_either_side():
    for height in (1.0, -1.0, 0.07):
        up, made = flying(height)
        found = airborne_rows(made)
        assert found.ground == pytest.approx(0.2)
        np.testing.assert_array_equal(found.rows, up)
    # Nearer than half a rotor's radius, or 5 cm, it rests.
    assert not airborne_rows(flying(0.04)[1]).rows.any()


def test_time_in_the_air_leaves_gaps_out():
    t = np.concatenate([np.arange(0.0, 2.0, 0.01), 30.0 + np.arange(0.0, 1.0, 0.01)])
    assert Airborne(np.ones(len(t), dtype=bool), "", None).seconds(t) == pytest.approx(2.98, abs=0.03)


@pytest.mark.parametrize(("seconds", "height", "code"), [(0.7, 1.0, "no_flight"), (5.0, 0.25, "low_flight"),
                                                         (5.0, 0.4, None)])  # fmt: skip
def test_a_flight_is_longer_than_a_second_and_higher_than_0_3_m(seconds, height, code):
    made = flying(height, (8.0, 8.0 + seconds))[1].between(5.0, 15.0)
    codes = [f.code for f in no_flight(made, airborne_rows(made))]
    assert codes == ([code] if code else [])


def test_a_part_that_is_too_short_and_all_in_the_air_is_no_fault_of_the_flight():
    whole = flying(1.0, (8.0, 15.0))[1]
    short = whole.between(9.0, 9.9)
    (found,) = no_flight(short, airborne_rows(short))
    assert found.code == "no_flight"
    assert "s are used, less than 1 s, all of it in the air" in found.what
    assert found.remedy.startswith("use more of it (--from, --to)")
    hop = flying(1.0, (8.0, 8.7))[1].between(5.0, 15.0)
    (found,) = no_flight(hop, airborne_rows(hop))
    assert found.what.startswith("the vehicle is in the air for 0.")
    assert found.remedy == "leave this log out"


def test_a_short_hop_above_0_3_m_is_no_low_flight():
    """For a twentieth of the time it is high."""
    _, made = flying(0.2, (8.0, 18.0))
    table = made.table.assign(pz=made.table["pz"] + np.where((T > 12.0) & (T < 12.5), 1.0, 0.0))
    assert no_flight(Flight(table), airborne_rows(Flight(table))) == []


# Commands


def rotors(values, **more):
    return flight(**{f"cmd_rotor_{i}": values for i in range(4)}, **more)


def codes(made, airborne=ALL, vehicle=QUAD):
    return {f.code: f for f in carrying_findings(made, airborne, vehicle)}


def test_rotor_commands_carry_the_weight_or_their_unit_is_another():
    assert codes(rotors(HOVER)) == {}
    assert codes(rotors(1.5 * HOVER)) == {}
    rpm = codes(rotors(HOVER * RPM))["rotor_unit"]
    assert rpm.values["ratio"] == pytest.approx(RPM**2)
    assert rpm.settings == ("rotor_command.unit=rpm",)
    assert codes(rotors(2.5 * HOVER))["rotor_unit"].settings == ()
    # Against what it felt in the air, not on the ground.
    falling = {"ax": 0.0, "ay": 0.0, "az": np.where(T < 15.0, 30.0, 9.81)}
    assert codes(rotors(HOVER, **falling), T >= 15.0) == {}
    mostly = {"ax": 0.0, "ay": 0.0, "az": np.where(T < 17.0, 30.0, 9.81)}
    assert codes(rotors(HOVER * RPM, **mostly), T >= 17.0)["rotor_unit"].values["ratio"] == pytest.approx(RPM**2)
    heavy = {"ax": 0.0, "ay": 0.0, "az": 12.0}
    assert codes(rotors(2.0 * HOVER, **heavy))["rotor_unit"].values["ratio"] == pytest.approx(4.0 * QUAD.gravity / 12.0)


def test_a_rotor_reverses_where_it_turns_both_ways_and_is_signed_where_it_turns_one():
    def said(x):
        return {
            f.code: f.channels for f in column_findings(flight(**{f"rotor_{i}": x[i] for i in range(4)}), ALL, QUAD)
        }

    wave = 500.0 + 10.0 * np.sin(T)
    both = np.where(T < 10.0, wave, -wave)
    seldom = np.where(T < 5.1, wave, -wave)
    assert said([wave] * 4) == {}
    assert said([wave, -wave, wave, -wave]) == {"signed_speeds": ("rotor_1", "rotor_3")}
    assert said([wave, both, wave, seldom]) == {"signed_speeds": ("rotor_3",), "reversing_rotors": ("rotor_1",)}


def test_commands_are_impossible_beyond_a_fiftieth_of_full_scale_and_below_zero():
    top = QUAD.rotors[0].max_speed
    thrust = QUAD.model_copy(update={"rotors": tuple(r.model_copy(update={"input": "throttle"}) for r in QUAD.rotors)})

    def said(x, vehicle=QUAD):
        return [f.values["share_of_flight"] for f in impossible_commands(rotors(x), ALL, vehicle)]

    some = np.arange(len(T)) % 50 == 0
    assert said(np.where(some, 1.01 * top, 600.0)) == []
    assert said(np.where(some, 1.03 * top, 600.0)) == [pytest.approx(0.02)]
    assert said(np.where(some, 1.05, 0.5), thrust) == [pytest.approx(0.02)]
    assert said(np.where(some, -0.02, 0.5), thrust) == [pytest.approx(0.02)]
    assert said(np.where(some, -0.005, 0.5), thrust) == []
    # Without a vehicle most samples tell a throttle.
    assert said(np.where(some, 1.05, 0.5), None) == [pytest.approx(0.02)]
    assert said(np.where(some, 900.0, 600.0), None) == []
    force = flight(cmd_fx=0.0, cmd_fy=0.0, cmd_fz=np.where(some, 90.0, 8.0))
    assert [f.code for f in impossible_commands(force, ALL, None)] == ["impossible_command"]
    assert impossible_commands(flight(cmd_fx=0.0, cmd_fy=0.0, cmd_fz=np.where(some, 70.0, 8.0)), ALL, None) == []


def test_a_collective_command_is_the_force_or_the_sum_of_squared_speeds():
    assert collective(rotors(3.0)).x[:, 0] == pytest.approx(np.full(len(T), 36.0))
    assert collective(flight(cmd_fx=1.0, cmd_fy=1.0, cmd_fz=7.0)).x[0, 0] == 7.0
    assert collective(rotors(3.0, cmd_tilt_0=0.1)) is None
