"""A channel that goes with the others by another factor than one is told; noise in the pose is no such thing."""

import numpy as np
import pytest
from check_flights import A, P, Q, V, W, named, simulated

from infotraj.checking import check, examine
from infotraj.flight import Flight
from infotraj.importing import derive
from infotraj.rotations import conjugate, exp, from_euler, multiply, to_euler

FLIGHT = simulated(3, duration=15.0)
Z = np.array([0.0, 0.0, 1.0])


def with_columns(**columns):
    return Flight(FLIGHT.table.assign(**columns), FLIGHT.meta)


def times(names, *factors):
    return with_columns(**{n: FLIGHT.table[n] * f for n, f in zip(names, factors, strict=True)})


def attitude(q):
    return with_columns(**dict(zip(Q, q.T, strict=True)))


def from_another_time(names):
    return with_columns(**{c: FLIGHT.table[c].to_numpy()[::-1] for c in names})


def late(flight, names, seconds):
    t = flight.table["t"]
    return Flight(flight.table.assign(**{n: np.interp(t - seconds, t, flight.table[n]) for n in names}), flight.meta)


def rejects(flight):
    return {f.code for f in check(flight) if f.severity == "reject"}


@pytest.mark.parametrize(
    ("spoilt", "code"),
    [
        (times(W, 0.5, 0.5, 0.5), "rates_unexplained"),
        (times(W, 1.0, -1.0, 1.0), "rates_unexplained"),
        (times(V, 0.5, 0.5, 0.5), "velocity_unexplained"),
        (times(V, 1.0, -1.0, 1.0), "velocity_unexplained"),
        (from_another_time(V), "velocity_unexplained"),
        (late(FLIGHT, W + A, 0.7), "rates_unexplained"),
    ],
    ids=["half rates", "one rate mirrored", "half velocity", "one velocity mirrored", "another time", "0.7 s late"],
)
def test_a_channel_that_no_reading_explains_is_rejected_and_no_setting_is_proposed(spoilt, code):
    (finding,) = [f for f in check(spoilt) if f.severity == "reject"]
    assert finding.code == code
    assert finding.settings == ()


@pytest.mark.parametrize("size", [1.0, 0.2])  # small angles in a wrong unit once fitted them as well
def test_a_pitch_of_the_other_sign_is_found_and_mended_by_one_setting(size):
    roll, pitch, yaw = to_euler(FLIGHT.table[Q].to_numpy()).T
    flight = attitude(from_euler(size * roll, -size * pitch, size * yaw))
    rates = derive.rate(flight.t, from_euler(size * roll, size * pitch, size * yaw), 0.05)
    columns = dict(zip(W, rates.T, strict=True))
    turned = Flight(flight.table.drop(columns=[*P, *V, *A]).assign(**columns), flight.meta)
    (finding,) = [f for f in check(turned) if f.severity == "reject"]
    assert finding.code == "attitude_sign"
    assert finding.settings == ("attitude.angle_signs=[1, -1, 1]",)


def test_a_clock_that_is_far_off_by_the_times_of_recording_has_a_setting():
    said = "imu: its stamps are late; --set rate.shift=-0.700 --set specific_force.shift=-0.700 takes that out"
    spoilt = late(FLIGHT, W + A, 0.7)
    (finding,) = [f for f in check(Flight(spoilt.table, {"notes": [said]})) if f.severity == "reject"]
    assert finding.code == "rates_unexplained"
    assert finding.settings == ("rate.shift=-0.700", "specific_force.shift=-0.700")


def test_noise_in_the_attitude_makes_the_factor_smaller_and_is_no_finding():
    rng = np.random.default_rng(4)
    noisy = multiply(FLIGHT.table[Q].to_numpy(), exp(0.02 * rng.standard_normal((len(FLIGHT.table), 3))))
    assert rejects(attitude(noisy)) == set()


@pytest.mark.parametrize("degrees", [90, -90, 180])
def test_a_tracked_body_that_was_set_up_turned_is_found_and_mended_by_one_setting(degrees):
    turned = attitude(multiply(FLIGHT.table[Q].to_numpy(), exp(np.deg2rad(degrees) * Z)))
    (finding,) = [f for f in check(turned) if f.severity == "reject"]
    assert finding.code == "attitude_frame"
    (setting,) = finding.settings
    sides = {90: "[y, -x, z]", -90: "[-y, x, z]", 180: "[-x, -y, z]"}
    assert setting == f"attitude.body={sides[-degrees] if degrees != 180 else sides[180]}"


def test_a_world_of_the_attitude_that_is_turned_is_found():
    turned = attitude(multiply(exp(np.deg2rad(90) * Z), FLIGHT.table[Q].to_numpy()))
    found = [f for f in check(turned) if f.severity == "reject"]
    assert [f.settings for f in found] == [("attitude.world=[y, -x, z]",)]


def test_an_imu_in_other_axes_is_not_a_vehicle_that_flies_upside_down():
    names = [*W, *A]
    found = [f for f in check(times(names, 1, -1, -1, 1, -1, -1)) if f.severity == "reject"]
    assert {s for f in found for s in f.settings} == {"rate.axes=[x, -y, -z]", "specific_force.axes=[x, -y, -z]"}


def test_one_clock_of_an_imu_moves_both_of_its_channels():
    (finding,) = [f for f in check(late(FLIGHT, W + A, 0.05)) if f.severity == "warning"]
    assert finding.code == "imu_clock_offset"
    moved = {s.split("=")[0]: float(s.split("=")[1]) for s in finding.settings}
    assert moved == pytest.approx({"rate.shift": -0.05, "specific_force.shift": -0.05}, abs=0.002)


@pytest.mark.parametrize(("seed", "degrees"), [(4, 30), (8, 10), (8, 20)])
def test_a_tracked_body_that_is_turned_is_no_late_gyroscope(seed, degrees):
    flight = simulated(seed, duration=15.0)
    turned = multiply(flight.table[Q].to_numpy(), conjugate(exp(np.deg2rad(degrees) * Z)))
    found = check(Flight(flight.table.assign(**dict(zip(Q, turned.T, strict=True))), flight.meta))
    assert not [f.code for f in found if f.code == "imu_clock_offset"]


def test_an_axis_of_noise_alone_does_not_hide_the_unit_of_the_others():
    t, rng = FLIGHT.table["t"].to_numpy(), np.random.default_rng(6)
    true = from_euler(0 * t, 0.3 * np.sin(2 * t) + 0.1 * np.sin(5.3 * t), 0 * t)  # it pitches, and nothing else
    rate = np.gradient(0.3 * np.sin(2 * t) + 0.1 * np.sin(5.3 * t), t)[:, None] * [0.0, 1.0, 0.0]
    rate = rate + 0.02 * rng.standard_normal(rate.shape)  # rad/s
    q = multiply(true, exp(8e-4 * rng.standard_normal((len(t), 3))))
    table = FLIGHT.table.drop(columns=[*P, *V, *A]).assign(**dict(zip(Q, q.T, strict=True)))
    in_degrees = Flight(table.assign(**dict(zip(W, np.rad2deg(rate).T, strict=True))), FLIGHT.meta)
    assert rejects(in_degrees) == {"rate_unit"}


def test_a_clean_flight_has_none():
    assert named(examine(FLIGHT)) == set()
