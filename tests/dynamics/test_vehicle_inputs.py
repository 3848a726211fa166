"""Inputs that are no rotor speed: thrusts, throttles, a wrench; what a log's signs and surplus columns do."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from click.testing import CliRunner

from infotraj.checking import examine, load
from infotraj.cli import cli
from infotraj.comparing.equation_error import equation_error
from infotraj.comparing.rollouts import parse_horizons, rollouts
from infotraj.diagnosis.adding import add
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.dynamics.inputs import for_vehicle
from infotraj.effects import catalogue
from infotraj.errors import InputError
from infotraj.flight import COMMANDED_WRENCH, Flight, read_flight
from infotraj.locating.locating import locate
from infotraj.models import Model
from infotraj.vehicle import parse_vehicle

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"
ROW, SUBSTEPS = 0.005, 4
ARM, KAPPA, MASS = 0.1, 0.012, 0.9
INERTIA = np.array([[6e-3, 2e-4, -1e-4], [2e-4, 7e-3, 3e-4], [-1e-4, 3e-4, 1.1e-2]])
PLACES = ARM * np.array([[1, -1, 0.1], [-1, -1, 0.1], [-1, 1, 0.1], [1, 1, 0.1]])
SPINS = (1, -1, 1, -1)
BODY = {
    "mass": MASS,
    "inertia": {"xx": 6e-3, "yy": 7e-3, "zz": 1.1e-2, "xy": 2e-4, "xz": -1e-4, "yz": 3e-4},
}


def with_thrusts(lag=0.0, **keys):
    rotors = [
        {
            "name": f"r{i}",
            "position": PLACES[i].tolist(),
            "spin": SPINS[i],
            "input": "thrust",
            "moment_constant": KAPPA,
            "time_constant": lag,
            **keys,
        }
        for i in range(4)
    ]
    return parse_vehicle({"name": "by_thrust", **BODY, "rotors": rotors})


def with_wrench(**keys):
    return parse_vehicle({"name": "by_wrench", **BODY, "inputs": "wrench", **keys})


def wrench_of(thrust):
    """Force and torque (.., 6) of four thrusts along body z, written out."""
    x, y = PLACES[:, 0], PLACES[:, 1]
    out = np.zeros((*thrust.shape[:-1], 6))
    out[..., 2] = thrust.sum(axis=-1)
    out[..., 3] = thrust @ y
    out[..., 4] = -thrust @ x
    out[..., 5] = -(thrust @ np.array(SPINS)) * KAPPA
    return out


@lru_cache
def fly(lag=0.0, factor=1.0, noise=0.0, drag=0.0, seconds=8.0, seed=0, yaw=1.0):
    """A rigid body in space, driven by four thrusts that follow their commands with a lag; Runge-Kutta, 4th order.

    A controller keeps it about hover and turns it about all axes. factor: of all thrusts; yaw: of the reaction torques;
    drag (N s/m): at the origin. The flight with thrust commands, and the same with the wrench that was commanded.
    """
    rng = np.random.default_rng(seed)
    n = round(seconds / ROW)
    mixer = np.linalg.inv(wrench_of(np.eye(4))[:, 2:].T)
    inverse, h = np.linalg.inv(INERTIA), ROW / SUBSTEPS
    pace, start = rng.uniform(1.0, 4.0, (3, 3)), rng.uniform(-3, 3, (3, 3))
    p, v, q, w = np.array([0.0, 0.0, 5.0]), np.zeros(3), np.array([1.0, 0, 0, 0]), np.zeros(3)
    thrust = np.full(4, MASS * 9.81 / 4)
    rows = {k: [] for k in ("p", "v", "q", "w", "a", "u")}

    def matrix(q):
        s, x, y, z = q / np.linalg.norm(q)
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - s * z), 2 * (x * z + s * y)],
                [2 * (x * y + s * z), 1 - 2 * (x * x + z * z), 2 * (y * z - s * x)],
                [2 * (x * z - s * y), 2 * (y * z + s * x), 1 - 2 * (x * x + y * y)],
            ]
        )

    def specific(q, v, thrust):
        return (factor * wrench_of(thrust)[:3] - drag * matrix(q).T @ v) / MASS

    def followed(command, thrust, time):
        """Thrusts some time after a command, exact for a first-order lag."""
        return command + (thrust - command) * (np.exp(-time / lag) if lag > 0 else 0.0)

    def slope(v, q, w, thrust):
        torque = factor * wrench_of(thrust)[3:] * [1.0, 1.0, yaw]
        s, x = q[0], q[1:]
        turn = 0.5 * np.concatenate([[-x @ w], s * w + np.cross(x, w)])
        return matrix(q) @ specific(q, v, thrust) - [0, 0, 9.81], turn, inverse @ (torque - np.cross(w, INERTIA @ w))

    for k in range(n):
        t = k * ROW
        wanted = 0.25 * np.sin(pace * t + start).sum(axis=1)
        level = np.cross(matrix(q).T @ [0.0, 0.0, 1.0], [0.0, 0.0, 1.0])
        torque = np.diag(INERTIA) * (80.0 * ([*wanted[:2], 0.0] - level) - 14.0 * (w - [0, 0, wanted[2]]))
        lift = MASS * (9.81 + 1.5 * np.sin(2.3 * t) + 1.0 * (5.0 - p[2]) - 1.5 * v[2])
        u = mixer @ [lift, *torque]
        now = u if lag == 0.0 and k == 0 else thrust
        for key, x in zip("pvqwau", (p, v, q, w, specific(q, v, now), u), strict=True):
            rows[key].append(x.copy())
        for i in range(SUBSTEPS):
            stages = [(0.0, None), (0.5, 0), (0.5, 1), (1.0, 2)]
            k_ = []
            for part, before in stages:
                d = (np.zeros(3), np.zeros(3), np.zeros(4), np.zeros(3)) if before is None else k_[before]
                x = [y + part * h * dy for y, dy in zip((p, v, q, w), d, strict=True)]
                dv, dq, dw = slope(x[1], x[2], x[3], followed(u, thrust, (i + part) * h))
                k_.append((x[1], dv, dq, dw))
            p, v, q, w = (y + h / 6 * (a + 2 * b + 2 * c + d) for y, a, b, c, d in zip((p, v, q, w), *k_, strict=True))
            q = q / np.linalg.norm(q)
        thrust = followed(u, thrust, ROW)
    out = {k: np.array(x) for k, x in rows.items()}
    table = pd.DataFrame({"t": np.arange(n) * ROW})
    names = {"p": "px py pz", "v": "vx vy vz", "q": "qw qx qy qz", "w": "wx wy wz", "a": "ax ay az"}
    sizes = {"p": 1e-4, "v": 1e-3, "q": 0.0, "w": 2e-3, "a": 2e-2}
    for key, columns in names.items():
        table[columns.split()] = out[key] + noise * sizes[key] * rng.standard_normal(out[key].shape)
    by_thrust = table.assign(**{f"cmd_rotor_{i}": out["u"][:, i] for i in range(4)})
    by_wrench = table.assign(**dict(zip(COMMANDED_WRENCH, wrench_of(out["u"]).T, strict=True)))
    return Flight(by_thrust, {"source": "by_thrust"}), Flight(by_wrench, {"source": "by_wrench"})


def errors(model, flight):
    """Greatest errors of the specific force at the rows and of the mean angular acceleration after half a second."""
    made = model.predict(flight)
    rows = flight.t > 0.5
    rows[-1] = False
    slope = np.diff(flight.get("wx", "wy", "wz"), axis=0) / np.diff(flight.t)[:, None]
    return (
        np.abs(made.specific_force - flight.get("ax", "ay", "az"))[rows].max(),
        np.abs(made.angular_acceleration_mean[:-1] - slope)[rows[:-1]].max(),
    )


@pytest.mark.parametrize("lag", [0.0, 0.04])
def test_a_body_driven_by_thrusts_is_predicted_from_thrusts_and_from_their_wrench(lag):
    by_thrust, by_wrench = fly(lag, seconds=3.0)
    for vehicle, flight in (
        (with_thrusts(lag), by_thrust),
        (with_wrench(time_constant=lag), by_wrench),
        (with_wrench(time_constant=lag, thrust_axis=[0, 0, 1]), without(by_wrench, "cmd_fx", "cmd_fy")),
    ):
        force, turn = errors(Model(vehicle), flight)
        assert force < 1e-9
        assert turn < 2e-4  # rates are interpolated between two rows, for the gyroscopic torque


def without(flight, *columns):
    return Flight(flight.table.drop(columns=list(columns)), dict(flight.meta))


def test_the_lag_that_the_file_leaves_out_is_rotor_lag_of_thrusts_and_of_a_wrench():
    known = catalogue()["rotor_lag"]
    for vehicle, flight in zip((with_thrusts(), with_wrench()), fly(0.04, seconds=3.0), strict=True):
        force, turn = errors(Model(vehicle, [known(extra_time_constant=0.04)]), flight)
        assert force < 1e-9
        assert turn < 2e-4
        assert errors(Model(vehicle), flight)[0] > 0.05


def test_what_is_the_same_for_all_rotors_scales_thrusts_and_a_wrench_alike():
    known = catalogue()
    for vehicle, flight in zip(
        (with_thrusts(0.03), with_wrench(time_constant=0.03)), fly(0.03, factor=0.8, seconds=3.0), strict=True
    ):
        assert errors(Model(vehicle, [known["thrust_scale"](factor=0.8)]), flight)[0] < 1e-9
        assert errors(Model(vehicle, [known["thrust_scale"](factor=0.8)]), flight)[1] < 2e-4
        assert errors(Model(vehicle), flight)[0] > 1.0
    by_thrust, by_wrench = fly(0.03, yaw=0.5, seconds=3.0)
    reaction = known["moment_scale"](factor=0.5)
    axis = with_wrench(time_constant=0.03, thrust_axis=[0, 0, 1])
    for vehicle, flight in ((with_thrusts(0.03), by_thrust), (axis, by_wrench)):
        assert errors(Model(vehicle, [reaction]), flight)[1] < 2e-4
        assert errors(Model(vehicle), flight)[1] > 0.1


ALIKE = {
    "thrust_scale": {"factor": 0.9},
    "battery_sag": {"rate": 0.01},
    "moment_scale": {"factor": 1.3},
    "rotor_lag": {"extra_time_constant": 0.02},
    "actuation_delay": {"delay": 0.0123},
    "mass_offset": {"dm": 0.1},
    "inertia_error": {"dxx": 1e-3, "dyy": 0.0, "dzz": -1e-3},
    "com_offset": {"r": [0.01, -0.02, 0.005]},
    "linear_drag": {"d": [0.2, 0.3, 0.1]},
    "steady_torque": {"t": [0.01, 0.02, -0.01]},
    "suspended_load": {"mass": 0.1, "length": 0.5},
}


@pytest.mark.parametrize("name", ALIKE)
def test_an_effect_does_to_a_wrench_what_it_does_to_the_thrusts_that_make_it(name):
    effect = catalogue()[name](**ALIKE[name])
    vehicles = with_thrusts(0.03), with_wrench(time_constant=0.03, thrust_axis=[0, 0, 1])
    made, plain = (
        [Model(v, e).predict(f) for v, f in zip(vehicles, fly(0.03, seconds=2.0), strict=True)] for e in ([effect], [])
    )
    for side in ("specific_force", "angular_acceleration"):
        np.testing.assert_allclose(*(getattr(p, side) for p in made), atol=1e-9)
    moved = [
        np.abs(getattr(made[0], s) - getattr(plain[0], s)).max() for s in ("specific_force", "angular_acceleration")
    ]
    assert max(moved) > 1e-2


def test_a_weak_rotor_of_thrusts_is_a_smaller_thrust():
    flight = fly(0.03, seconds=2.0)[0]
    weak = Flight(flight.table.assign(cmd_rotor_2=0.8 * flight.table["cmd_rotor_2"]))
    effect = catalogue()["rotor_effectiveness"](rotor=2, factor=0.8)
    vehicle = with_thrusts(0.03)
    assert effect.cannot_show(vehicle, flight) is None
    made = Model(vehicle, [effect]).predict(flight), Model(vehicle).predict(weak)
    np.testing.assert_allclose(*(p.angular_acceleration for p in made), atol=1e-9)
    np.testing.assert_allclose(*(p.specific_force for p in made), atol=1e-9)


def test_reaction_torques_that_cancel_are_seen_in_thrusts_and_throttles():
    flight = fly(0.03, seconds=2.0)[0]
    assert catalogue()["moment_scale"].cannot_show(with_thrusts(), flight) is None
    same = flight.table.assign(**{f"cmd_rotor_{i}": flight.table["cmd_rotor_0"] for i in range(4)})
    for vehicle in (with_thrusts(), with_thrusts(input="throttle", thrust_polynomial=[0.1, 0.5, 2.0])):
        assert "cancel" in catalogue()["moment_scale"].cannot_show(vehicle, Flight(same))


def test_commands_beyond_the_greatest_thrust_are_impossible():
    flight = fly(0.03, seconds=3.0)[0]
    vehicle = with_thrusts(thrust_coefficient=2e-6, max_speed=1500.0)
    wrong = flight.table["cmd_rotor_1"].where(np.arange(len(flight.t)) % 200 != 100, 6.0)
    found = {f.code: f for f in examine(Flight(flight.table.assign(cmd_rotor_1=wrong)), vehicle).findings}
    assert "outside 0..4.5: " in found["impossible_command"].what
    assert "impossible_command" not in {f.code for f in examine(flight, vehicle).findings}


def test_thrusts_give_rotor_speeds_only_by_a_thrust_coefficient():
    by_thrust, _ = fly(0.03, seconds=1.0)
    drag = catalogue()["rotor_drag"]
    assert drag.cannot_show(with_thrusts(), by_thrust) == (
        "no rotor speed: the rotors take a thrust and have no thrust_coefficient"
    )
    known = with_thrusts(0.03, thrust_coefficient=2e-6)
    assert drag.cannot_show(known, by_thrust) is None
    speeds = np.sqrt(by_thrust.numbered("cmd_rotor_") / 2e-6)
    content = yaml.safe_load(known.model_dump_json(exclude_none=True))
    for rotor in content["rotors"]:
        rotor.update(input="speed", time_constant=0.0)
    table = by_thrust.table.assign(**{f"cmd_rotor_{i}": speeds[:, i] for i in range(4)})
    instant = with_thrusts(0.0, thrust_coefficient=2e-6)
    made = [
        Model(vehicle, [drag(k=5e-4)]).predict(flight).specific_force
        for vehicle, flight in ((instant, by_thrust), (parse_vehicle(content), Flight(table)))
    ]
    np.testing.assert_allclose(*made, atol=1e-9)


def test_effects_of_single_rotors_are_not_testable_without_rotors_and_the_others_are():
    _, flight = fly(0.03, seconds=2.0)
    vehicle = with_wrench(nominal_voltage=16.8)
    none = {n: cls.cannot_show(vehicle, flight) for n, cls in catalogue().items()}
    single = {"rotor_effectiveness", "coaxial_loss", "axial_inflow", "ground_effect", "rotor_drag", "gyroscopic"}
    single |= {"hub_moment", "translational_lift", "thrust_exponent"}
    assert {n for n, why in none.items() if why == "no rotors in the vehicle file"} == single
    tilts = {"servo_lag", "servo_rate_limit", "servo_backlash", "servo_bias", "rotor_interference"}
    assert {n for n, why in none.items() if why == "the vehicle has no tilts"} == tilts
    assert "thrust_axis" in none["moment_scale"]
    assert {n for n, why in none.items() if why is None} == set(none) - single - tilts - {"moment_scale"}
    for name in single - {"rotor_effectiveness"}:
        effect = catalogue()[name](**{p.name: 0.1 for p in catalogue()[name].parameters})
        with pytest.raises(InputError, match="no rotors in the vehicle file"):
            Model(vehicle, [effect]).predict(flight)
    with pytest.raises(InputError, match="a vehicle with rotors"):
        Model(vehicle, [catalogue()["rotor_effectiveness"](rotor=0, factor=0.9)])


def test_a_users_effect_on_single_rotors_is_not_testable_on_a_wrench():
    class Push(catalogue()["linear_drag"]):
        name = "push"

        def rotor_force(self, along):
            raise AssertionError("there are no rotors")

    _, flight = fly(seconds=1.0)
    assert Push.cannot_show(with_wrench(), flight) == "no rotors in the vehicle file"


@pytest.mark.long
def test_a_wrench_is_compared_located_rolled_out_and_diagnosed():
    flights = [fly(0.05, noise=1.0, drag=0.25, seed=s)[1] for s in (1, 2, 3)]
    vehicle = with_wrench(thrust_axis=[0, 0, 1])
    model = Model(vehicle)
    found = diagnose(model, flights)
    assert set(found.supported) == {"linear_drag", "rotor_lag"}
    lag = next(e for e in found.model.effects if e.name == "rotor_lag")
    assert lag.extra_time_constant == pytest.approx(0.05, abs=0.003)
    assert found.finding("rotor_effectiveness").verdict == "Not testable here"
    ahead = [rollouts(m, flights[0], parse_horizons("20")).errors[..., 1].mean() for m in (model, found.model)]
    assert ahead[1] < 0.5 * ahead[0]
    assert equation_error(found.model, flights[0]).residual[200:-50].std(axis=0)[4] < 1e-3
    made = add(model, ["linear_drag", "rotor_lag"], flights)
    np.testing.assert_allclose(made.model.effects[0].d[:2], 0.25, rtol=0.1)
    located = locate(model, flights)
    assert not located.cannot_name or "thrust" not in located.cannot_name
    assert any("commanded wrench" in q.name for q in located.found[0].samples.quantities)


SQUARES = {"thrust_coefficient": 2e-6, "input": "speed"}


def by_speed(flight):
    """The same flight with its thrusts as speeds of rotors, and the vehicle that takes these."""
    speeds = np.sqrt(np.maximum(flight.numbered("cmd_rotor_"), 0.0) / 2e-6)
    columns = {f"cmd_rotor_{i}": speeds[:, i] for i in range(4)} | {f"rotor_{i}": speeds[:, i] for i in range(4)}
    return Flight(flight.table.assign(**columns), dict(flight.meta)), with_thrusts(**SQUARES)


def signed(flight):
    """Rotors 1 and 3, which turn clockwise, have negative speeds: commanded and measured."""
    columns = {f"{p}rotor_{i}": -flight.get(f"{p}rotor_{i}")[:, 0] for p in ("cmd_", "") for i in (1, 3)}
    return Flight(flight.table.assign(**columns), dict(flight.meta))


@pytest.mark.long
def test_signed_speeds_are_read_by_magnitude_by_every_command_and_stay_as_they_are_stored():
    plain, vehicle = by_speed(fly(seconds=3.0, drag=0.3)[0])
    other = signed(plain)
    model = Model(vehicle, [catalogue()["rotor_drag"](k=2e-4)])
    np.testing.assert_array_equal(model.predict(other).specific_force, model.predict(plain).specific_force)
    np.testing.assert_array_equal(equation_error(model, other).predicted, equation_error(model, plain).predicted)
    pd.testing.assert_frame_equal(for_vehicle(other, vehicle).table, plain.table)
    assert for_vehicle(plain, vehicle) is plain
    assert (other.table["cmd_rotor_1"] < 0).all()
    horizons = parse_horizons("10")
    np.testing.assert_array_equal(*(rollouts(model, f, horizons).errors for f in (other, plain)))
    places = [[(p.axis, p.gain) for p in locate(model, [f]).places] for f in (other, plain)]
    assert places[0] == places[1]
    fitted = [add(Model(vehicle), ["rotor_drag"], [f]).model.effects[0].k for f in (other, plain)]
    assert fitted[0] == fitted[1]


def test_check_says_once_that_signs_are_read_by_magnitude_and_rejects_nothing():
    plain, vehicle = by_speed(fly(seconds=6.0)[0])
    for believed in (vehicle, None):
        found = {f.code: f for f in examine(signed(plain), believed).findings}
        assert "impossible_command" not in found
        assert not [f for f in found.values() if f.severity in ("reject", "cut")]
    found = {f.code: f for f in examine(signed(plain), vehicle).findings}
    assert found["signed_speeds"].severity == "note"
    assert set(found["signed_speeds"].channels) == {"cmd_rotor_1", "cmd_rotor_3", "rotor_1", "rotor_3"}
    assert "signed_speeds" not in {f.code for f in examine(plain, vehicle).findings}


def test_a_rotor_that_turns_both_ways_is_a_warning_since_its_file_cannot_say_so():
    plain, vehicle = by_speed(fly(seconds=6.0)[0])
    turned = plain.get("cmd_rotor_2")[:, 0] * np.where(plain.t % 2.0 < 1.0, 1.0, -1.0)
    found = {f.code: f for f in examine(Flight(plain.table.assign(cmd_rotor_2=turned)), vehicle).findings}
    assert found["reversing_rotors"].severity == "warning"
    assert "signed_speeds" not in found


@pytest.mark.parametrize("value", [np.nan, 0.0, 900.0])
def test_surplus_motor_columns_that_are_unused_are_left_out_and_said(value):
    plain, vehicle = by_speed(fly(seconds=3.0)[0])
    extra = Flight(plain.table.assign(**{f"cmd_rotor_{i}": value for i in range(4, 8)}), dict(plain.meta))
    pd.testing.assert_frame_equal(for_vehicle(extra, vehicle).table, plain.table)
    np.testing.assert_array_equal(
        Model(vehicle).predict(extra).specific_force, Model(vehicle).predict(plain).specific_force
    )
    found = {f.code: f for f in examine(extra, vehicle).findings}
    assert found["unused_columns"].channels == tuple(f"cmd_rotor_{i}" for i in range(4, 8))
    assert "rotor_unit" not in found
    assert "surplus_columns" not in found


@pytest.mark.parametrize(("first", "pick"), [(0, "[0, 1, 2, 3]"), (4, "[4, 5, 6, 7]")])
def test_surplus_motor_columns_in_use_reject_the_flight_with_the_setting_that_picks(first, pick):
    plain, vehicle = by_speed(fly(seconds=3.0)[0])
    moving = {f"cmd_rotor_{i}": plain.get(f"cmd_rotor_{i % 4}")[:, 0] for i in range(4, 8)}
    still = {f"cmd_rotor_{i}": 0.0 for i in range(first)}
    extra = Flight(plain.table.assign(**moving, **still), dict(plain.meta))
    for command in (lambda: equation_error(Model(vehicle), extra), lambda: diagnose(Model(vehicle), [extra])):
        with pytest.raises(InputError) as caught:
            command()
        assert f"--set 'rotor_command.pick={pick}'" in str(caught.value)
        assert "\n" not in str(caught.value)
    found = {f.code: f for f in examine(extra, vehicle).findings}
    assert found["surplus_columns"].severity == "reject"
    assert found["surplus_columns"].settings == (f"rotor_command.pick={pick}",)


def test_a_log_without_the_inputs_of_its_vehicle_says_which_key_to_write():
    by_thrust, by_wrench = fly(seconds=3.0)
    with pytest.raises(InputError, match="write `inputs: wrench` in place of by_thrust's `rotors`"):
        Model(with_thrusts()).predict(by_wrench)
    with pytest.raises(InputError, match=r"no cmd_fx.*cmd_fx, cmd_fy, cmd_fz, cmd_tx"):
        Model(with_wrench()).predict(by_thrust)
    with pytest.raises(InputError, match=r"Write `thrust_axis: \[0, 0, 1\]`"):
        Model(with_wrench()).predict(without(by_wrench, "cmd_fx", "cmd_fy"))
    forces = without(by_wrench, "cmd_tx", "cmd_ty", "cmd_tz")
    with pytest.raises(InputError, match="leave `inertia` out of the vehicle file"):
        Model(with_wrench()).predict(forces)
    alone = with_wrench().model_copy(update={"inertia": None})
    made = equation_error(Model(alone), forces)
    assert made.scored[:, :3].any()
    assert set(made.reasons) == {"tx", "ty", "tz"}


def test_check_with_a_vehicle_asks_for_what_compare_needs():
    by_thrust, by_wrench = fly(seconds=3.0)
    for vehicle, flight in (
        (with_thrusts(), by_thrust),
        (with_thrusts(), by_wrench),
        (with_wrench(), by_thrust),
        (with_wrench(), by_wrench),
        (with_wrench(thrust_axis=[0, 0, 1]), without(by_wrench, "cmd_fx")),
        (with_wrench(), without(by_wrench, "cmd_fx")),
        (with_thrusts(), without(by_thrust, "cmd_rotor_3")),
    ):
        said = examine(flight, vehicle).unanswerable
        try:
            reasons = equation_error(Model(vehicle), flight).reasons
        except InputError:
            assert {"force errors", "torque errors"} <= set(said)
        else:
            assert ("force errors" in said, "torque errors" in said) == ("fx" in reasons, "tx" in reasons)
    assert "force errors" not in examine(by_wrench).unanswerable
    note = next(f for f in examine(by_wrench, with_thrusts()).findings if f.code == "cannot_answer")
    assert "`inputs: wrench`" in note.remedy


def test_check_of_a_flight_table_keeps_a_thrust_that_is_commanded_alone(tmp_path):
    flight = without(fly(seconds=3.0)[1], "cmd_fx", "cmd_fy")
    flight.write(tmp_path / "flight.csv")
    loaded = load(tmp_path / "flight.csv").flight
    np.testing.assert_allclose(loaded.get("cmd_fz"), flight.get("cmd_fz"))
    assert "force errors" not in examine(loaded, with_wrench(thrust_axis=[0, 0, 1])).unanswerable


@pytest.mark.parametrize(
    ("factor", "setting"), [(1000 / 9.80665, "rotor_command.scale=0.00980665"), (1e3, "rotor_command.scale=0.001")]
)
def test_thrusts_in_another_unit_are_found_with_the_setting_that_mends_them(factor, setting):
    flight, _ = fly(seconds=3.0)
    wrong = flight.table.assign(**{f"cmd_rotor_{i}": factor * flight.table[f"cmd_rotor_{i}"] for i in range(4)})
    found = {f.code: f for f in examine(Flight(wrong), with_thrusts()).findings}
    assert found["rotor_unit"].severity == "reject"
    assert found["rotor_unit"].settings == (setting,)
    assert "rotor_unit" not in {f.code for f in examine(flight, with_thrusts()).findings}


@pytest.mark.parametrize(
    ("low", "high", "unit"), [(0, 100, "percent"), (1000, 2000, "pwm_us"), (47, 2047, "dshot"), (0, 65535, "pwm16")]
)
def test_what_a_motor_was_told_instead_of_a_throttle_is_found_by_its_range(low, high, unit):
    flight, _ = fly(seconds=3.0)
    content = yaml.safe_load((VEHICLES / "betaflight_5inch.yaml").read_text())
    vehicle = parse_vehicle({**content, "mass": MASS})
    share = np.clip(flight.numbered("cmd_rotor_") / 8.0, 0, 1)
    told = flight.table.assign(**{f"cmd_rotor_{i}": low + (high - low) * share[:, i] for i in range(4)})
    found = {f.code: f for f in examine(Flight(told), vehicle).findings}
    assert found["rotor_unit"].settings == (f"rotor_command.unit={unit}",)


def test_every_command_takes_a_wrench_from_the_command_line(tmp_path):
    flight = fly(0.03, noise=1.0, seconds=4.0)[1]
    path, vehicle = tmp_path / "flight.parquet", tmp_path / "vehicle.yaml"
    flight.write(path)
    keys = {"inputs": "wrench", "thrust_axis": [0, 0, 1], "time_constant": 0.03}
    vehicle.write_text(yaml.safe_dump({"name": "by_wrench", **BODY, **keys}))
    new = tmp_path / "new.yaml"
    for line in (
        f"check {path} --vehicle {vehicle}",
        f"compare {vehicle} {path} --horizons 5 --recording {tmp_path / 'flight.rrd'}",
        f"locate {vehicle} {path}",
        f"add {vehicle} thrust_scale --fit {path} -o {new}",
        f"compare {new} {path} --against {vehicle}",
        f"design {vehicle} --flown {path} --candidates 3 --within 6s --figures {tmp_path} -o {tmp_path / 'ref.csv'}",
    ):
        done = CliRunner().invoke(cli, line.split())
        assert done.exit_code == 0, (done.output, done.exception)
    assert yaml.safe_load(new.read_text())["vehicle"]["inputs"] == "wrench"
    assert "by_wrench" in new.read_text()
    assert read_flight(path).table.equals(flight.table)
