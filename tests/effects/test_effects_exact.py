"""Every effect against an exact simulation that shares no code with it: time stamps, signs, parameters, order."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj import rotations
from infotraj.effects import catalogue, effect_class
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import parse_vehicle

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"
SECONDS = 2.5

OMAV = {
    "mass_offset": {"dm": 0.2},
    "inertia_error": {"dxx": 0.01, "dyy": -0.012, "dzz": 0.02},
    "com_offset": {"r": [0.01, -0.006, 0.008]},
    "thrust_scale": {"factor": 0.9},
    "rotor_effectiveness": {"rotor": 3, "factor": 0.8},
    "coaxial_loss": {"fraction": 0.15},
    "axial_inflow": {"k": 2e-4},
    "ground_effect": {"k": 0.3},
    "battery_sag": {"rate": 0.006},
    "rotor_interference": {"k": 0.06},
    "actuation_delay": {"delay": 0.0123},
    "rotor_lag": {"extra_time_constant": 0.03},
    "servo_lag": {"extra_time_constant": 0.04},
    "servo_rate_limit": {"max_rate": 2.0},
    "servo_backlash": {"half_width": 0.015},
    "servo_bias": {"bias": [0.01, -0.02, 0.015, 0.02, -0.01, 0.018]},
    "rotor_drag": {"k": 8e-5},
    "linear_drag": {"d": [0.3, 0.4, 0.5]},
    "quadratic_drag": {"d": [0.1, 0.2, 0.15]},
    "angular_damping": {"d": [0.05, 0.06, 0.07]},
    "steady_force": {"f": [0.8, -0.5, 0.6]},
    "steady_torque": {"t": [0.1, -0.08, 0.05]},
    "suspended_load": {"mass": 0.4, "length": 0.6},
    "gyro_bias": {"b": [0.03, -0.02, 0.05]},
    "accelerometer_bias": {"b": [0.2, -0.1, 0.15]},
    "imu_misalignment": {"rotvec": [0.02, -0.01, 0.015]},
    "time_offset": {"dt": 0.0137},
    "translational_lift": {"k": 6e-3},
    "thrust_exponent": {"n": 2.2},
    "sensor_lag": {"time_constant": 0.012},
}
QUADROTOR = {
    "mass_offset": {"dm": 0.04},
    "inertia_error": {"dxx": 0.001, "dyy": -0.001, "dzz": 0.002},
    "com_offset": {"r": [0.004, -0.003, 0.005]},
    "thrust_scale": {"factor": 0.9},
    "rotor_effectiveness": {"rotor": 2, "factor": 0.9},
    "moment_scale": {"factor": 1.4},
    "axial_inflow": {"k": 1e-4},
    "ground_effect": {"k": 0.4},
    "battery_sag": {"exponent": 1.7},
    "actuation_delay": {"delay": 0.01},
    "rotor_lag": {"extra_time_constant": 0.03},
    "rotor_drag": {"k": 5e-5},
    "linear_drag": {"d": [0.1, 0.12, 0.14]},
    "quadratic_drag": {"d": [0.05, 0.06, 0.07]},
    "angular_damping": {"d": [0.008, 0.006, 0.01]},
    "steady_force": {"f": [0.2, -0.3, 0.2]},
    "steady_torque": {"t": [0.01, -0.012, 0.008]},
    "gyroscopic": {"rotor_inertia": 3e-5},
    "suspended_load": {"mass": 0.08, "length": 0.5},
    "gyro_bias": {"b": [0.03, -0.02, 0.05]},
    "accelerometer_bias": {"b": [0.2, -0.1, 0.15]},
    "imu_misalignment": {"rotvec": [0.02, -0.01, 0.015]},
    "time_offset": {"dt": -0.0087},
    "hub_moment": {"k": 2e-6},
    "translational_lift": {"k": 4e-3},
    "thrust_exponent": {"n": 1.8},
    "sensor_lag": {"time_constant": 0.004},
}
# What acts only beside another: with that, and what of it is hidden.
BESIDE = {
    "wind": {"v": [4.0, -3.0, 0.8]},
    "pressure_centre": {"r": [0.02, -0.015, 0.03]},
}
ALONE = [("omav", *item) for item in OMAV.items()] + [("quadrotor", *item) for item in QUADROTOR.items()]
TOGETHER = {
    "actuators": (
        "omav",
        ["actuation_delay", "rotor_lag", "servo_lag", "servo_rate_limit", "servo_backlash", "servo_bias"],
    ),
    "thrust": (
        "omav",
        ["thrust_scale", "coaxial_loss", "axial_inflow", "ground_effect", "battery_sag", "rotor_interference"],
    ),
    "body": ("omav", ["mass_offset", "inertia_error", "com_offset", "suspended_load", "rotor_drag", "steady_force"]),
    "imu": ("omav", ["gyro_bias", "imu_misalignment", "time_offset", "com_offset", "angular_damping"]),
    "air": (
        "omav",
        [
            "wind",
            "pressure_centre",
            "linear_drag",
            "quadratic_drag",
            "rotor_drag",
            "axial_inflow",
            "translational_lift",
        ],
    ),
    "thrust curve": ("omav", ["thrust_exponent", "rotor_interference", "battery_sag", "coaxial_loss", "ground_effect"]),
    "filtered": (
        "quadrotor",
        ["sensor_lag", "time_offset", "gyro_bias", "imu_misalignment", "actuation_delay", "linear_drag", "hub_moment"],
    ),
    "filtered spin-up": ("quadrotor", ["sensor_lag", "gyroscopic", "com_offset"]),
    "spin-up": ("quadrotor", ["gyroscopic", "com_offset", "moment_scale", "rotor_lag", "linear_drag"]),
}

# Largest error (r.m.s.) of a prediction with the true effects: specific force in m/s^2 at the rows, derivative of the
# rate in rad/s^2 over each step. What limits it is the motion between the rows, which enters drag and gyroscopic
# torque (rate), the cable's swing (specific force) and play (its kink between two rows).
FORCE, TURN = 1e-6, 1e-5
LOOSER = {"suspended_load": (2e-3, 1e-5), "servo_backlash": (1e-6, 1e-3), "servo_rate_limit": (1e-5, 1e-4)}


@lru_cache
def vehicle_file(name):
    content = yaml.safe_load((VEHICLES / f"{name}.yaml").read_text())
    return {**content, "nominal_voltage": 15.2}


@lru_cache
def plain(name):
    return Flight(fly(vehicle_file(name), {}, seconds=SECONDS))


@lru_cache
def plain_with_voltage(name):
    flight = plain(name)
    return Flight(flight.table.assign(battery=15.2 - 0.1 * flight.t))


def model_of(name, *effects):
    known = catalogue()
    return Model(parse_vehicle(vehicle_file(name)), [known[e](**values) for e, values in effects])


def errors(model, flight):
    """R.m.s. errors of specific force, rate increments, turn and push, after the first 0.5 s."""
    prediction = model.predict(flight)
    t = flight.t
    rows = prediction.covered & (t > t[0] + 0.5)
    rows[-1] = False
    slope = np.diff(flight.get("wx", "wy", "wz"), axis=0) / np.diff(t)[:, None]
    k = prediction.kinematics
    differences = (
        (flight.get("ax", "ay", "az") - prediction.specific_force)[rows],
        slope[rows[:-1]] - prediction.angular_acceleration_mean[rows],
        (k.turn - k.turn_by_imu)[rows],
        (k.push - k.push_by_imu)[rows],
    )
    return [float(np.sqrt(np.mean(d**2))) for d in differences]


@pytest.mark.parametrize("name", ["omav", "quadrotor"])
def test_a_model_without_effects_is_exact_where_nothing_is_hidden(name):
    force, turn, turned, pushed = errors(model_of(name), plain(name))
    assert force < 1e-8
    assert turn < 1e-5
    assert turned < 1e-5
    assert pushed < 5e-3


@pytest.mark.parametrize(("name", "effect", "values"), ALONE, ids=[f"{n}-{e}" for n, e, _ in ALONE])
def test_the_true_effect_explains_the_flight_and_its_absence_does_not(name, effect, values):
    flight = Flight(fly(vehicle_file(name), {effect: values}, seconds=SECONDS))
    with_it = errors(model_of(name, (effect, values)), flight)
    without = errors(model_of(name), flight)
    force, turn = LOOSER.get(effect, (FORCE, TURN))
    if effect == "gyroscopic":
        turn = 1e-3
    assert with_it[0] < force
    assert with_it[1] < turn
    assert with_it[2] < 5e-4
    if effect in ("gyro_bias", "imu_misalignment", "time_offset"):
        assert without[2] > 5e-3
    elif effect == "sensor_lag":
        assert min(without[:2]) > 1e3 * force
        assert with_it[3] < 5e-3
    else:
        assert without[0] > 20 * force or without[1] > 20 * turn
    assert catalogue()[effect].cannot_show(parse_vehicle(vehicle_file(name)), flight) is None


@pytest.mark.parametrize("case", TOGETHER)
def test_effects_compose_in_the_order_of_the_catalogue(case):
    name, listed = TOGETHER[case]
    source = {**(OMAV if name == "omav" else QUADROTOR), **BESIDE}
    effects = [(e, source[e]) for e in listed]
    flight = Flight(fly(vehicle_file(name), effects, seconds=SECONDS))
    force, turn, turned, _ = errors(model_of(name, *effects), flight)
    loose = "suspended_load" in listed
    assert force < (2e-3 if loose else 1e-5)
    assert turn < 2e-3
    assert turned < 1e-3
    shuffled = model_of(name, *reversed(effects))
    np.testing.assert_allclose(
        shuffled.predict(flight).specific_force, model_of(name, *effects).predict(flight).specific_force, atol=1e-9
    )


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "effect", "other"),
    [
        (name, effect, other)
        for name in ("omav", "quadrotor")
        for effect in BESIDE
        for other in effect_class(effect).beside
        if (name, other) != ("omav", "hub_moment")  # it cancels there, in wind and without
    ],
)
def test_what_acts_beside_another_only_is_exact_there_and_alone_changes_nothing(name, effect, other):
    mine, source = (effect, BESIDE[effect]), OMAV if name == "omav" else QUADROTOR
    beside = (other, source.get(other, {"k": 2e-6}))
    flight = Flight(fly(vehicle_file(name), [mine, beside], seconds=SECONDS))
    with_it, without = errors(model_of(name, mine, beside), flight), errors(model_of(name, beside), flight)
    assert with_it[0] < FORCE
    assert with_it[1] < 2 * TURN
    assert without[0] > 1e3 * FORCE or without[1] > 1e3 * TURN
    alone = model_of(name, mine).predict(flight)
    np.testing.assert_array_equal(alone.specific_force, model_of(name).predict(flight).specific_force)
    np.testing.assert_array_equal(alone.angular_acceleration, model_of(name).predict(flight).angular_acceleration)


@pytest.mark.parametrize("effect", sorted(set(OMAV) | set(QUADROTOR)))
def test_what_the_air_does_sees_the_wind_and_nothing_else_does(effect):
    """`wind.beside` is what changes with the wind in the model, effect by effect; so for `pressure_centre`."""
    name, source = ("quadrotor", QUADROTOR) if effect in QUADROTOR else ("omav", OMAV)
    one = (effect, source[effect])
    plainly = model_of(name, one).predict(plain_with_voltage(name))
    for other, values in BESIDE.items():
        seen = model_of(name, one, (other, values)).predict(plain_with_voltage(name))
        same = np.array_equal(plainly.specific_force, seen.specific_force) and np.array_equal(
            plainly.angular_acceleration, seen.angular_acceleration
        )
        assert same == (effect not in effect_class(other).beside)


@pytest.mark.parametrize("name", ["omav", "quadrotor"])
def test_wind_on_a_drag_that_is_alike_on_all_axes_and_linear_is_a_steady_force(name):
    flight, d, v = plain(name), 0.2, np.array([4.0, -3.0, 0.8])
    drag = ("linear_drag", {"d": [d, d, d]})
    windy = model_of(name, drag, ("wind", {"v": v})).predict(flight)
    pushed = model_of(name, drag, ("steady_force", {"f": d * v})).predict(flight)
    np.testing.assert_allclose(windy.specific_force, pushed.specific_force, atol=1e-12)


def test_the_sensors_lag_is_that_of_a_first_order_filter_whatever_the_rows():
    """Rows far longer and far shorter than the time constant: the step from row to row is solved, not approximated."""
    for row, lag in ((0.02, 0.002), (0.005, 0.03), (0.001, 0.03)):
        hidden = {"sensor_lag": {"time_constant": lag}}
        flight = Flight(fly(vehicle_file("quadrotor"), hidden, seconds=SECONDS, row=row))
        force, turn, _, _ = errors(model_of("quadrotor", *hidden.items()), flight)
        assert force < 1e-5
        assert turn < 1e-3


def test_undoing_the_sensors_lag_hardly_raises_their_noise():
    """Else a fit would prefer a time offset, which raises none, whatever is there."""
    hidden = {"sensor_lag": {"time_constant": 0.008}}
    flight = Flight(fly(vehicle_file("quadrotor"), hidden, seconds=SECONDS))
    noise = np.random.default_rng(0).normal(0.0, 0.01, (len(flight.t), 3))
    noisy = Flight(
        flight.table.assign(**{c: flight.get(c)[:, 0] + x for c, x in zip(("wx", "wy", "wz"), noise.T, strict=True)})
    )
    spread = []
    for model in (model_of("quadrotor", *hidden.items()), model_of("quadrotor")):
        clean, rough = (model.predict(f).kinematics.turn_by_imu[:-1] for f in (flight, noisy))
        spread.append(np.std(rough - clean))
    assert spread[0] < 1.3 * spread[1]


def test_a_derived_channel_has_no_sensor_and_no_lag():
    flight, lag = plain("quadrotor"), ("sensor_lag", {"time_constant": 0.02})
    half = Flight(flight.table, {"derived": ["wx", "wy", "wz"]})
    with_it, without = (model_of("quadrotor", *e).predict(half) for e in ([lag], []))
    np.testing.assert_allclose(with_it.angular_acceleration, without.angular_acceleration, atol=1e-12)
    assert np.abs(with_it.specific_force - without.specific_force).max() > 0.1
    cls, vehicle = effect_class("sensor_lag"), parse_vehicle(vehicle_file("quadrotor"))
    assert cls.cannot_show(vehicle, half) is None
    none = Flight(flight.table, {"derived": ["wx", "wy", "wz", "ax", "ay", "az"]})
    assert "derived" in cls.cannot_show(vehicle, none)


def test_rotor_effectiveness_may_stand_more_than_once():
    effects = [
        ("rotor_effectiveness", {"rotor": 0, "factor": 0.85}),
        ("rotor_effectiveness", {"rotor": 7, "factor": 0.8}),
    ]
    flight = Flight(fly(vehicle_file("omav"), effects, seconds=SECONDS))
    assert errors(model_of("omav", *effects), flight)[0] < FORCE
    assert errors(model_of("omav", effects[0]), flight)[0] > 1e-2


@pytest.mark.parametrize(
    ("effect", "values"),
    [("moment_scale", {"factor": 1.5}), ("gyroscopic", {"rotor_inertia": 3e-5}), ("hub_moment", {"k": 1.7e-6})],
)
def test_what_cancels_in_equal_coaxial_pairs_cannot_show(effect, values):
    flight = Flight(fly(vehicle_file("omav"), {effect: values}, seconds=SECONDS))
    # Hub moments leave what the body's own turning makes of the distance between the two rotors.
    assert errors(model_of("omav"), flight)[1] < (2e-3 if effect == "hub_moment" else TURN)
    reason = catalogue()[effect].cannot_show(parse_vehicle(vehicle_file("omav")), flight)
    assert "cancel" in reason


def test_the_simulation_conserves_angular_momentum_as_its_rotors_speed_up():
    vehicle = vehicle_file("quadrotor")
    inertia = 3e-5
    flight = Flight(
        fly(vehicle, {"gyroscopic": {"rotor_inertia": inertia}, "thrust_scale": {"factor": 0.0}}, seconds=0.6)
    )
    speed = flight.numbered("rotor_")
    carried = inertia * speed @ [r["spin"] for r in vehicle["rotors"]]
    body = flight.get("wx", "wy", "wz") * [vehicle["inertia"][k] for k in ("xx", "yy", "zz")]
    body[:, 2] += carried
    world = rotations.to_world(flight.get("qw", "qx", "qy", "qz"), body)
    assert np.ptp(speed, axis=0).max() > 100.0
    np.testing.assert_allclose(world, np.broadcast_to(world[0], world.shape), atol=1e-7 * np.abs(carried).max() + 1e-9)


def test_the_simulation_converges_with_fourth_order():
    vehicle = vehicle_file("omav")
    runs = [fly(vehicle, {"linear_drag": {"d": [1, 1, 1]}}, seconds=1.0, substep=s) for s in (2.5e-3, 1.25e-3, 6.25e-4)]
    coarse, fine = (float((a - b).abs().max().max()) for a, b in pairwise(runs))
    assert 10 < coarse / fine < 25


def test_a_row_of_shift_between_command_and_response_is_seen():
    """The flight table's rule to the step: commands of row k act from t[k]; one row late is another model."""
    flight = plain("omav")
    table = flight.table.copy()
    commands = [c for c in table if c.startswith("cmd_")]
    table[commands] = table[commands].shift(1).bfill()
    exact, late = errors(model_of("omav"), flight), errors(model_of("omav"), Flight(table))
    assert late[0] > 1e4 * exact[0]
