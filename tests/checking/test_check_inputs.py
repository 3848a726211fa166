"""What check says of the inputs that a vehicle takes: signs, surplus columns, units, and what is missing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from thrust_flights import MASS, by_speed, fly, signed, with_thrusts, with_wrench, without

from infotraj.checking import examine, load
from infotraj.comparing.equation_error import equation_error
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.dynamics.inputs import for_vehicle
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import parse_vehicle

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"


def test_commands_beyond_the_greatest_thrust_are_impossible():
    flight = fly(0.03, seconds=3.0)[0]
    vehicle = with_thrusts(thrust_coefficient=2e-6, max_speed=1500.0)
    wrong = flight.table["cmd_rotor_1"].where(np.arange(len(flight.t)) % 200 != 100, 6.0)
    found = {f.code: f for f in examine(Flight(flight.table.assign(cmd_rotor_1=wrong)), vehicle).findings}
    assert "outside 0..4.5: " in found["impossible_command"].what
    assert "impossible_command" not in {f.code for f in examine(flight, vehicle).findings}


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


def test_columns_of_which_one_beyond_the_vehicles_changes_are_not_picked_but_another_instance_is():
    plain, vehicle = by_speed(fly(seconds=3.0)[0])
    columns = {f"cmd_rotor_{i}": 900.0 for i in range(8)} | {"cmd_rotor_5": 1500.0 + np.sin(plain.t)}
    note = "outputs: a was chosen; a[1] would fit too (override with --set rotor_command.instance=1)"
    extra = Flight(plain.table.assign(**columns), {**plain.meta, "notes": [note]})
    (found,) = [f for f in examine(extra, vehicle).findings if f.code == "surplus_columns"]
    assert "8 columns cmd_rotor_* are in use, 1 of which change" in found.what
    assert "pick" not in found.remedy
    assert "infotraj import LOG --set rotor_command.instance=1 -o NEW.parquet" in found.remedy
    assert not found.settings


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


def test_of_a_log_with_measured_rotors_alone_these_are_named():
    plain, vehicle = by_speed(fly(seconds=3.0)[0])
    rpm = {f"rotor_{i}": plain.get(f"rotor_{i}")[:, 0] * 30.0 / np.pi for i in range(4)}
    commands = [f"cmd_rotor_{i}" for i in range(4)]
    (found,) = [
        f
        for f in examine(Flight(plain.table.assign(**rpm).drop(columns=commands)), vehicle).findings
        if f.code == "rotor_unit"
    ]
    assert found.what.startswith("the measured rotors make")
    assert found.channels == ("rotor_0..3",)
    assert found.settings == ("rotor.unit=rpm",)
    by_throttle = {**yaml.safe_load((VEHICLES / "betaflight_5inch.yaml").read_text()), "mass": MASS}
    measured = Flight(plain.table.drop(columns=commands))
    found = next(f for f in examine(measured, parse_vehicle(by_throttle)).findings if f.code == "rotor_unit")
    assert "the unit of rotor_0..3" in found.remedy


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


def test_throttles_for_a_file_of_speeds_and_speeds_for_one_of_throttles_are_told_apart_from_wrong_units():
    speeds, by_speed_file = by_speed(fly(seconds=3.0)[0])
    columns = [f"cmd_rotor_{i}" for i in range(4)]
    both = Flight(speeds.table.assign(**(speeds.table[columns] / speeds.table[columns].to_numpy().max())))
    throttles = Flight(both.table.drop(columns=[f"rotor_{i}" for i in range(4)]))
    content = yaml.safe_load((VEHICLES / "betaflight_5inch.yaml").read_text())
    by_throttle_file = parse_vehicle({**content, "mass": MASS})
    imported = Flight(speeds.table, {"channels": {"rotor_command": {"unit": "rpm"}}})
    for flight, vehicle, holds, write in (
        (throttles, by_speed_file, "holds throttle (0..1), the vehicle file's rotors take speeds", "thrust_polynomial"),
        (imported, by_throttle_file, "holds speeds (rad/s), the vehicle file's rotors take thrott", "thrust_coeff"),
    ):
        (found,) = [f for f in examine(flight, vehicle).findings if f.code == "rotor_unit"]
        assert holds in found.what
        assert write in found.remedy
    # With measured speeds beside them nothing is wrong: these are read.
    found = {f.code: f for f in examine(both, by_speed_file).findings}
    assert "rotor_unit" not in found
    assert found["commands_unread"].severity == "note"
    read = for_vehicle(both, by_speed_file)
    assert not read.has("cmd_rotor_0")
    assert read.has("rotor_0")
    assert for_vehicle(speeds, by_speed_file).has("cmd_rotor_0")
    assert Model(by_speed_file).prepare(both).recorded.rotor_commanded is False
