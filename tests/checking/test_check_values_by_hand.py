"""Small parts of `check` by series whose answer is known: values, sensors, time, coverage, units, contradictions."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from check_series import ALL, QUAD, T, flight, random

from infotraj.checking.cleaning import derived_again
from infotraj.checking.columns import dead_column_findings, dead_columns
from infotraj.checking.coverage import coverage, excitation_findings
from infotraj.checking.divergence import contradictions
from infotraj.checking.frozen import _all_still, _straight
from infotraj.checking.held import held_findings, held_streams, rates, repeat_chance
from infotraj.checking.identical import content_hash
from infotraj.checking.inertial import force_unit_findings
from infotraj.checking.kinematics import acceleration_of, acceleration_width, body_increment, channels, velocity_of
from infotraj.checking.motionless import motionless_rows
from infotraj.checking.outliers import impossible_values, pose_jumps, saturation, spikes
from infotraj.checking.resolution import quantised, step_size
from infotraj.checking.sizes import sizes
from infotraj.checking.streams import Stream, runs
from infotraj.checking.timing import gaps, jitter, order, time_unit
from infotraj.checking.voids import Void, emptied
from infotraj.flight import Flight
from infotraj.rotations import exp, multiply

# Values


def test_a_channel_may_stand_still_where_all_others_do():
    groups = [("wx", "wy", "wz"), ("fx", "fy", "fz"), ("vx", "vy", "vz")]
    still = dict.fromkeys([c for g in groups for c in g], 0.0)
    rows = np.ones(len(T), dtype=bool)
    assert _all_still(flight(**still), rows, groups[0], groups)
    assert not _all_still(flight(**{**still, "vx": 0.01 * T}), rows, groups[0], groups)
    assert not _all_still(flight(**still), rows, groups[0], groups[:1])


def test_rates_speeds_and_forces_have_an_end():
    def said(**columns):
        return [f.code for f in impossible_values(flight(**columns), T < 15.0)]

    few, many, ground = np.arange(len(T)) % 200 == 0, np.arange(len(T)) % 20 == 0, T >= 15.0
    rate = {"wy": 0.0, "wz": 0.0}
    assert said(wx=np.where(many, 80.0, 1.0), **rate) == ["rate_impossible"]
    assert said(wx=np.where(few, 80.0, 1.0), **rate) == said(wx=np.where(ground, 80.0, 1.0), **rate) == []
    assert said(wx=np.where(many, 60.0, 1.0), **rate) == []
    assert said(vx=np.where(many, 160.0, 1.0), vy=0.0, vz=0.0) == ["speed_impossible"]
    assert said(ax=0.0, ay=0.0, az=np.where(many, 510.0, 9.8)) == ["force_impossible"]
    assert said(ax=0.0, ay=0.0, az=np.where(many, 400.0, 9.8)) == []


def test_spikes_are_single_samples_far_from_their_neighbours():
    smooth = np.sin(T) + 0.01 * random(0)
    x = smooth.copy()
    x[[500, 900, 901]] += 3.0
    x[1300:1304] += 3.0  # of four in a row it may be so
    x[1700] += 0.4  # within the range of the channel
    ((column, when, share),) = spikes(flight(wx=x), ALL)
    assert column == "wx"
    assert [a for a, _ in when] == pytest.approx([T[500], T[900], T[901]])
    assert share == pytest.approx(3 / len(T))
    assert spikes(flight(wx=smooth), ALL) == []
    # Heavy tails are not spikes.
    assert spikes(flight(wx=np.random.default_rng(0).standard_t(3, len(T))), ALL) == []
    held = np.where((np.arange(len(T)) % 400) < 6, 900.0, 500.0 + random(1))
    assert spikes(flight(cmd_rotor_0=held), ALL) == []


def test_a_sensor_at_its_end_for_three_samples_again_and_again_is_saturated():
    wave = 12.0 * np.sin(2.0 * T) + 0.05 * random(0)
    findings, voids = saturation(flight(wx=np.clip(wave, -11.5, 11.7), wy=wave, wz=random(1)), ALL)
    assert [f.channels for f in findings] == [("wx",)]
    clipped = (wave <= -11.5) | (wave >= 11.7)
    assert findings[0].values["share"] == pytest.approx(clipped.mean(), rel=0.1)
    assert len(voids[0].times) == pytest.approx(clipped.sum(), rel=0.1)
    # An actuator at its end is none of a sensor's faults, nor is one at rest.
    motor = 500.0 + 200.0 * np.sin(2.0 * T) + random(2)
    findings, voids = saturation(
        flight(cmd_rotor_0=np.minimum(motor, 650.0), cmd_rotor_1=np.maximum(motor - 400, 0)), ALL
    )
    assert [(f.channels, f.severity) for f in findings] == [(("cmd_rotor_0",), "note")]
    assert voids == []


def test_a_pose_jumps_faster_than_20_m_per_s_and_twenty_times_its_speed():
    def said(step):
        place = 0.5 * np.sin(T) + np.where(T >= 15.0, step, 0.0)
        return [f.spans[0][0] for f in pose_jumps(flight(px=place, py=0.0, pz=1.0), ALL)]

    assert said(0.15) == []
    assert said(0.4) == [pytest.approx(T[999], abs=0.011)]


def test_steps_are_coarse_where_they_are_a_quarter_of_what_a_channel_shows():
    x = 0.5 * random(0)
    assert step_size(np.round(x / 0.1) * 0.1) == pytest.approx(0.1)
    assert step_size(x) is None
    # What has many values is not written in steps that anybody would see.
    assert step_size(np.round(x, 3)) is None

    def said(step):
        return [(f.severity, f.values["wx"]["of_spread"]) for f in quantised(
            flight(wx=np.round(x / step) * step, wy=random(1), wz=random(2)), ALL)]  # fmt: skip

    assert said(0.1) == []
    assert said(0.2) == [("note", pytest.approx(0.4, rel=0.05))]
    assert said(0.8)[0][0] == "warning"


# Sensors that stand still


def test_a_second_without_any_motion_is_none_of_flight():
    rng = np.random.default_rng(0)
    still = T < 12.0
    rate = {f"w{a}": np.where(still, 0.0, np.sin(3 * T)) + 0.01 * rng.standard_normal(len(T)) for a in "xyz"}
    force = {"ax": 0.02 * rng.standard_normal(len(T)), "ay": 0.0 * T, "az": 9.81 + 0.02 * rng.standard_normal(len(T))}
    assert motionless_rows(flight(**rate, **force))[T < 11.9].all()
    assert not motionless_rows(flight(**rate, **force))[T > 12.1].any()
    slow = {k: v + np.where(still, 0.1 * np.sin(3 * T), 0.0) for k, v in rate.items()}
    assert not motionless_rows(flight(**slow, **force)).any()
    pushed = {**force, "ax": force["ax"] + 0.5 * np.sin(4 * T)}
    assert not motionless_rows(flight(**rate, **pushed)).any()
    moved = {"px": np.where(T > 8.0, 0.1 * (T - 8.0), 0.0), "py": 0.0 * T, "pz": 0.0 * T}
    assert not motionless_rows(flight(**rate, **force, **moved))[T > 8.1].any()
    drifts = {"vx": np.where(T > 8.0, 0.3 * np.sin(2 * (T - 8.0)), 0.0), "vy": 0.0 * T, "vz": 0.0 * T}
    assert not motionless_rows(flight(**rate, **force, **drifts))[T > 9.0].any()
    # Motors that a controller moves fly, however calm the sensors are.
    motors = {f"rotor_{i}": 500.0 + 5.0 * np.sin(9 * T) for i in range(4)}
    assert not motionless_rows(flight(**rate, **force, **motors)).any()
    idle = {f"rotor_{i}": 500.0 + 0.0 * T for i in range(4)}
    assert motionless_rows(flight(**rate, **force, **idle))[T < 11.9].all()


def test_a_column_that_repeats_while_its_siblings_go_on_is_dead():
    x = {f"w{a}": np.sin(T) + 0.02 * random(k) for k, a in enumerate("xyz")}
    dead = (T > 12.0) & (T < 13.0)
    (found,) = dead_columns(flight(**{**x, "wy": np.where(dead, 0.3, x["wy"])}), ALL)
    assert (found.column, found.value) == ("wy", 0.3)
    np.testing.assert_array_equal(found.rows, dead)
    assert found.share == pytest.approx(dead.mean())
    (whole,) = dead_column_findings(flight(**x), [replace(found, share=0.998)])
    assert "in 100 % of the flight" in whole.what
    short = (T > 12.0) & (T < 12.3)
    assert dead_columns(flight(**{**x, "wy": np.where(short, 0.3, x["wy"])}), ALL) == []
    # Where all stand still it is no matter of one.
    assert dead_columns(flight(**{k: np.where(dead, 0.3, v) for k, v in x.items()}), ALL) == []


def test_a_motor_that_reads_zero_while_most_others_run_has_stopped():
    speed = {f"rotor_{i}": 500.0 + 20.0 * random(i) for i in range(4)}
    stopped = (T > 12.0) & (T < 13.0)
    found = dead_columns(flight(**{**speed, "rotor_2": np.where(stopped, 0.0, speed["rotor_2"])}), ALL, QUAD)
    assert [d.column for d in found] == ["rotor_2"]
    np.testing.assert_array_equal(found[0].rows, stopped)
    assert dead_columns(flight(**{k: np.where(stopped, 0.0, v) for k, v in speed.items()}), ALL, QUAD) == []
    # Of more than a hundredth of the flight it is a warning.
    (said,) = dead_column_findings(flight(**speed), found)
    assert (said.severity, said.spans) == ("warning", ((pytest.approx(12.01), pytest.approx(12.99)),))
    assert dead_column_findings(flight(**speed), [replace(found[0], share=0.009)])[0].severity == "note"


# Held samples


def test_a_stream_whose_samples_are_repeated_has_the_rate_of_its_samples():
    new = np.arange(len(T)) // 4 * 4
    x = random(0, 3)[new]
    rate = {f"w{a}": random(1, 3)[:, k] for k, a in enumerate("xyz")}
    made = flight(px=x[:, 0], py=x[:, 1], pz=x[:, 2], **rate)
    place, gyro = held_streams(made, ALL)
    assert (place.always, gyro.always) == (True, False)
    assert (place.hz, place.row_hz, place.period) == pytest.approx((25.0, 100.0, 0.04))
    np.testing.assert_array_equal(place.rows, np.arange(len(T)) % 4 != 0)
    assert not gyro.rows.any()
    assert rates([place, gyro])["px..pz"] == {"hz": pytest.approx(25.0), "held_from_hz": pytest.approx(100.0)}
    assert rates([place, gyro])["wx..wz"]["held_from_hz"] is None
    (said,) = held_findings([place, replace(gyro, rows=T < 7.0)], T < 15.0)
    assert "px..pz at 25 Hz in rows of 100 Hz, wx..wz now and then (20 % of the flight)" in said.what


def test_the_chance_to_repeat_is_that_of_the_column_that_repeats_most_rarely():
    """Columns whose new samples repeat in a half and in a tenth of the rows in which the other one changes."""
    rng = np.random.default_rng(0)
    x = np.zeros((4000, 2))
    for c, chance in enumerate((0.5, 0.1)):
        same = rng.random(4000) < chance
        fresh = rng.standard_normal(4000)
        last = np.maximum.accumulate(np.where(same, 0, np.arange(4000)))
        x[:, c] = fresh[last]
    assert repeat_chance(x) == pytest.approx(0.1, abs=0.02)
    assert np.isnan(repeat_chance(np.ones((100, 2))))


# Time


def test_a_gap_beside_the_ground_is_not_in_flight():
    """Half a second is lost between row 999 and row 1000: it counts where both of them are in the air."""
    lost = Flight(pd.DataFrame({"t": np.concatenate([T[:1000], T[1000:] + 0.5])}))
    row = np.arange(len(T))
    assert gaps(lost, row < 1000) == gaps(lost, row >= 1000) == []
    assert [f.code for f in gaps(lost, row < 1001)] == [f.code for f in gaps(lost, row >= 999)] == ["gaps"]


def test_gaps_jitter_and_order_of_times():
    t = np.concatenate([T[:1000], T[1000:] + 0.5])
    (found,) = gaps(Flight(pd.DataFrame({"t": t})), ALL)
    assert found.values["seconds"] == pytest.approx(0.51)
    assert found.values["share"] == pytest.approx(0.51 / (t[-1] - t[0]))
    assert found.severity == "note"
    assert gaps(Flight(pd.DataFrame({"t": t})), T < 14.0) == []
    assert gaps(Flight(pd.DataFrame({"t": np.concatenate([T[:1000], T[1000:] + 0.035])})), ALL) == []
    for spread, said in ((0.0015, False), (0.003, True)):
        made = T + np.random.default_rng(0).uniform(-spread, spread, len(T))
        assert bool(jitter(Flight(pd.DataFrame({"t": made})))) == said
    back = np.array([0.0, 0.1, 0.2, 0.15, 0.3, 0.3, np.nan, 0.4])
    table, findings = order(pd.DataFrame({"t": back, "x": np.arange(8.0)}))
    assert table["x"].tolist() == [0.0, 1.0, 2.0, 4.0, 7.0]
    assert [f.code for f in findings] == ["time_not_finite", "time_backwards", "duplicate_times"]


def test_time_in_milliseconds_is_put_right_with_what_was_derived_by_it():
    made = Flight(pd.DataFrame({"t": 1000.0 * T, "vx": 0.002, "vy": 0.0, "vz": 0.0}), {"derived": ["vx", "vy", "vz"]})
    right, (found,) = time_unit(made)
    np.testing.assert_allclose(right.t, T)
    np.testing.assert_allclose(right.get("vx"), 2.0)
    assert found.settings == ("time.unit=ms",)
    assert time_unit(Flight(pd.DataFrame({"t": 40.0 * T})))[1] == []


# What flights cover


def test_a_speed_that_was_not_logged_is_that_of_the_path():
    """A circle of 2 m in 4 s, its poses in every fifth row and to a millimetre."""
    t = np.arange(0.0, 8.0, 0.01)
    turn = 2 * np.pi * t / 4.0
    path = np.stack([np.cos(turn), np.sin(turn), np.ones(len(t))], axis=1)
    path += 0.001 * np.random.default_rng(3).standard_normal(path.shape)
    path[np.arange(len(t)) % 5 != 0] = np.nan
    made = Flight(pd.DataFrame({"t": t, "px": path[:, 0], "py": path[:, 1], "pz": path[:, 2]}))
    found = coverage(made, np.ones(len(t), dtype=bool))["speed"]
    assert found["q50"] == pytest.approx(np.pi / 2, rel=0.02)
    assert found["q99"] == pytest.approx(np.pi / 2, rel=0.03)


def test_coverage_is_by_quantiles_about_the_mean_and_by_where_the_power_lies():
    tilt = np.radians(20.0) * np.sin(2 * np.pi * 0.5 * T)
    turned = exp(np.outer(tilt, [1.0, 0.0, 0.0]))
    made = flight(vx=3.0 * np.sin(2 * np.pi * T), vy=0.0, vz=4.0, battery=12.0 + 0.1 * np.sin(2 * np.pi * 3.0 * T),
                  **{f"q{a}": turned[:, i] for i, a in enumerate("wxyz")})  # fmt: skip
    found = coverage(made, ALL)
    assert found["battery"]["rms"] == pytest.approx(0.1 / np.sqrt(2), rel=0.01)
    assert found["battery"]["frequency_90"] == pytest.approx(3.0, abs=0.15)
    assert (found["vx"]["q01"], found["vx"]["q50"], found["vx"]["q99"]) == pytest.approx((-3.0, 0.0, 3.0), abs=0.01)
    assert found["speed"]["q99"] == pytest.approx(5.0, abs=0.01)
    assert found["tilt"]["q99"] == pytest.approx(np.radians(20.0), abs=0.002)
    assert found["roll"]["q01"] == pytest.approx(-np.radians(20.0), abs=0.002)


def test_what_hardly_moves_is_said_not_to_be_taught():
    def said(speed, height):
        covered = {"speed": {"q99": speed}, "pz": {"q01": 1.0, "q50": 1.1, "q99": 1.0 + height}}
        return [set(f.values) for f in excitation_findings(covered)]

    assert said(0.8, 0.4) == [{"speed"}]
    assert said(1.2, 0.2) == [{"height_range"}]
    assert said(1.2, 0.4) == []


# Kinematics


def test_velocities_accelerations_and_rates_follow_from_the_pose():
    place = Stream(T, np.stack([0.5 * T**2, np.sin(T), 0.0 * T], axis=1), 0.05)
    at = np.array([7.0, 9.0])
    np.testing.assert_allclose(velocity_of(place, at, 0.1)[:, 0], at, atol=1e-9)
    np.testing.assert_allclose(acceleration_of(place, None, at, 0.1), [[1.0, -np.sin(x), 0.0] for x in at], atol=2e-3)
    speed = Stream(T, np.stack([T, np.cos(T), 0.0 * T], axis=1), 0.05)
    np.testing.assert_allclose(acceleration_of(None, speed, at, 0.1), [[1.0, -np.sin(x), 0.0] for x in at], atol=2e-3)
    turned = Stream(T, multiply(exp(np.array([0.9, 0.0, 0.4])), exp(np.outer(T - 5.0, [0.3, -0.2, 0.5]))), 0.05)
    np.testing.assert_allclose(body_increment(turned, at, 0.1)[0], [[0.3, -0.2, 0.5]] * 2, atol=1e-4)


def test_accelerations_are_taken_over_as_long_as_their_noise_asks():
    """sqrt(6) sigma / h^2 = 0.15 m/s^2: 10 mm of noise ask for 0.4 s, and no less than the width of velocities."""
    for sigma, width in ((0.01, 0.404), (0.001, 0.128), (1e-5, 0.1), (1.0, 0.4)):
        place = Stream(T, sigma * random(0, 3), 0.05)
        assert acceleration_width(place, 0.1) == pytest.approx(min(width, 0.4), rel=0.1), sigma


def test_half_a_second_beside_the_ground_is_not_looked_at_and_sizes_are_exceeded_by_a_twentieth():
    columns = {"px": 2.0 * np.sin(T), "py": 0.0, "pz": 0.0, "vx": 2.0 * np.cos(T), "vy": 0.0, "vz": 0.0}
    made = channels(flight(**columns), (T > 8.0) & (T < 14.0))
    assert made.centres[0] == pytest.approx(8.5, abs=0.02)
    assert made.centres[-1] == pytest.approx(13.5, abs=0.04)
    assert made.width == pytest.approx(0.08)
    found = sizes(made)
    assert found.speed == pytest.approx(np.percentile(np.abs(2.0 * np.cos(T)), 95), abs=0.01)
    assert found.path_speed == pytest.approx(2.0, abs=0.05)
    assert found.extent == pytest.approx(np.ptp(np.percentile(2.0 * np.sin(T), [5, 95])), abs=0.02)
    assert np.isnan(found.rate)


# Units of the accelerometer, and cells without a sample


@pytest.mark.parametrize(
    ("az", "code"),
    [(9.8, None), (13.0, None), (1.0, "acceleration_unit"), (96.0, "acceleration_unit"),
     (0.05, "acceleration_without_gravity"), (3.0, "acceleration_without_gravity"), (-9.8, "acceleration_axes")],
)  # fmt: skip
def test_what_carries_a_vehicle_is_one_g_upwards(az, code):
    made = flight(ax=0.1 * random(0), ay=0.1 * random(1), az=az + 0.01 * random(2))
    assert [f.code for f in force_unit_findings(made, ALL)] == ([code] if code else [])


def test_cells_are_emptied_at_their_times_in_their_columns_alone():
    made = emptied(flight(wx=1, wy=2.0), [Void("x", ("wx", "t", "none"), T[[3, 7]])])
    assert np.flatnonzero(np.isnan(made.get("wx"))[:, 0]).tolist() == [3, 7]
    assert np.isfinite(made.get("wy")).all()
    assert np.isfinite(made.t).all()
    assert runs(np.array([True, False, True, True])) == [(0, 1), (2, 4)]


def test_what_was_derived_of_held_samples_is_derived_again_of_those_that_are_left():
    place = np.where(np.arange(len(T)) % 4, np.nan, 3.0 * T)
    held = pd.Series(place).ffill().to_numpy()
    wrong = np.gradient(held, T)
    columns = {"px": held, "py": 0.0 * T, "pz": 0.0 * T, "vx": wrong, "vy": 0.0 * T, "vz": 0.0 * T}
    before = flight(meta={"derived": ["vx", "vy", "vz"]}, **columns)
    after = emptied(before, [Void("held", ("px", "py", "pz"), T[np.isnan(place)])])
    made = derived_again(after, before).get("vx")[:, 0]
    np.testing.assert_allclose(made[np.isfinite(made)], 3.0, atol=1e-6)
    assert np.isfinite(made[8:-8:4]).all()


# Contradictions, copies, straight lines


def contradicted(start, stop, turn):
    """A vehicle that sways about x at its rate, but for some seconds in which the gyro says `turn` more."""
    angle = 0.4 * np.sin(1.3 * T)
    turned = exp(np.outer(angle, [1.0, 0.0, 0.0]))
    rate = 0.4 * 1.3 * np.cos(1.3 * T) + np.where((start <= T) & (stop > T), turn, 0.0)
    rates = {"wx": rate + 0.01 * random(0), "wy": 0.01 * random(1), "wz": 0.01 * random(2)}
    made = flight(**rates, **{f"q{a}": turned[:, i] for i, a in enumerate("wxyz")})
    return contradictions(channels(made, ALL, most=None), False, 9.81)


def test_an_identity_is_broken_where_it_is_for_two_seconds_and_grossly():
    (found,) = contradicted(12.0, 14.0, 3.0)
    assert found.spans == ((pytest.approx(12.0), pytest.approx(14.0)),)
    assert found.severity == "warning"
    assert found.values["worst"] == pytest.approx(3.0, rel=0.05)
    assert found.values["usual"] < 0.02
    assert found.values["share"] == pytest.approx(2 / 19, rel=0.1)
    assert contradicted(12.0, 18.0, 3.0)[0].severity == "cut"
    assert contradicted(12.0, 13.0, 3.0) == contradicted(12.0, 14.0, 0.8) == []


def test_the_same_flight_at_another_time_is_a_copy_and_another_place_is_none():
    made = flight(px=np.sin(T), py=0.0, pz=1.0)
    later, higher = made.table.assign(t=T + 100.0), made.table.assign(pz=2.0)
    assert content_hash(Flight(later[later.columns[::-1]])) == content_hash(made)
    assert content_hash(Flight(higher)) != content_hash(made)


def test_rows_lie_on_a_straight_line_whatever_their_steps():
    t = np.array([0.0, 0.1, 0.4, 0.5, 1.1, 1.2, 1.3])
    on, level = _straight(t, np.outer(3.0 * t, [1.0, -2.0]))
    assert on[1:-1].all()
    assert not level.any()
    bent = np.outer(3.0 * t, [1.0, -2.0])
    bent[3, 1] += 0.01
    assert _straight(t, bent)[0].tolist() == [False, True, False, False, False, True, False]
    assert _straight(t, np.ones((7, 2)))[1][1:-1].all()


def test_a_stream_that_is_held_in_a_third_of_the_log_is_so_now_and_then_and_gaps_are_no_steps():
    new = np.where(T < 12.0, np.arange(len(T)) // 4 * 4, np.arange(len(T)))
    x = random(0, 3)[new]
    t = np.where(T < 15.0, T, T + 60.0)
    (held,) = held_streams(flight(t, px=x[:, 0], py=x[:, 1], pz=x[:, 2]), ALL)
    assert not held.always
    assert held.rows[(T > 6.0) & (T < 11.0)].mean() == pytest.approx(0.75, abs=0.01)
    assert not held.rows[T > 14.0].any()
    assert held.row_hz == pytest.approx(100.0)


def test_what_moves_for_a_moment_only_teaches_no_vertical_acceleration():
    """Most of the time is what counts: a jolt in one sample of a hundred is none."""

    def said(rms):
        return [set(f.values) for f in excitation_findings({"az": {"rms": rms, "q99": 9.0}})]

    assert said(0.01) == [{"vertical_acceleration"}]
    assert said(5.0) == []
