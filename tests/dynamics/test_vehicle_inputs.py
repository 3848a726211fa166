"""Inputs that are no rotor speed: thrusts, throttles and a wrench; speeds with a sign."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
import yaml
from click.testing import CliRunner
from thrust_flights import BODY, by_speed, errors, fly, signed, with_thrusts, with_wrench, without

from infotraj.cli import cli
from infotraj.comparing.equation_error import equation_error
from infotraj.comparing.rollouts import parse_horizons, rollouts
from infotraj.diagnosis.adding import add
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.dynamics.inputs import for_vehicle
from infotraj.effects import catalogue
from infotraj.errors import InputError
from infotraj.flight import Flight, read_flight
from infotraj.locating.locating import locate
from infotraj.models import Model
from infotraj.vehicle import parse_vehicle


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
    assert "commanded" in none["telemetry_offset"]
    others = {"moment_scale", "telemetry_offset"}
    assert {n for n, why in none.items() if why is None} == set(none) - single - tilts - others
    for name in single - {"rotor_effectiveness"}:
        every = catalogue()[name].parameters
        # Of several forms one.
        effect = catalogue()[name](**{p.name: 0.1 for p in every if not p.optional or p is every[0]})
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


def test_a_speed_below_zero_is_read_as_the_magnitude_that_it_is():
    """Rotors 1 and 3 turn the other way: the table that a model reads is the one without signs, in every row."""
    plain, vehicle = by_speed(fly(seconds=1.0)[0])
    other = signed(plain)
    assert (other.get("cmd_rotor_1") < 0.0).all()
    pd.testing.assert_frame_equal(for_vehicle(other, vehicle).table, plain.table)
    assert for_vehicle(plain, vehicle) is plain


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


@pytest.mark.long
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
