"""Data that cannot say which effect is missing: no name is supported, and the reason is given."""

from dataclasses import replace
from pathlib import Path

import exact_simulation
import numpy as np
import pandas as pd
import pytest
import yaml
from exact_simulation import fly
from scipy.spatial.transform import Rotation

from infotraj.checking.acceptance import accepting
from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.gates.agreement import contradictions, still_doubtful
from infotraj.diagnosis.gates.premises import _thin, doubts, examined
from infotraj.diagnosis.judge.verdicts import CONFIDENT
from infotraj.diagnosis.report.summary import as_dict, as_text
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import Vehicle

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"
CONTENT = {name: yaml.safe_load((VEHICLES / f"{name}.yaml").read_text()) for name in ("omav", "quadrotor")}
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.002, "velocity": 0.01}
DRAG = {"omav": {"linear_drag": {"d": [0.5, 0.5, 0.8]}}, "quadrotor": {"linear_drag": {"d": [0.1, 0.1, 0.1]}}}
SECONDS = 7.0
_made: dict[tuple[str, str], list] = {}


def tables(name, effects, count=2):
    key = name, repr(effects)
    if key not in _made:
        _made[key] = [fly(CONTENT[name], effects, seconds=SECONDS, seed=k, noise=NOISE) for k in range(count)]
    return [t.copy() for t in _made[key]]


def model(name, change=None):
    content = yaml.safe_load(yaml.safe_dump(CONTENT[name]))
    if change is not None:
        change(content)
    return Model(Vehicle.model_validate(content))


def flights(made):
    return [Flight(t, {"source": f"flight {k}"}) for k, t in enumerate(made)]


def said(model, made):
    return {d.about: d for d in doubts(model, made)}


def actuators(table):
    return [c for c in table if c.startswith(("cmd_", "rotor_", "tilt_"))]


def held(table):
    rows = np.arange(len(table)) // 20 * 20
    table[actuators(table)] = table[actuators(table)].to_numpy()[rows]
    return table


def sparse(table):
    table.loc[np.arange(len(table)) % 20 != 0, actuators(table)] = np.nan
    return table


def constant(table):
    table[actuators(table)] = table[actuators(table)].mean().to_numpy()
    return table


def backwards(table):
    table[actuators(table)] = table[actuators(table)].to_numpy()[::-1]
    return table


def at_random(table):
    rng = np.random.default_rng(1)
    x = table[actuators(table)].to_numpy()
    table[actuators(table)] = x.mean(axis=0) + x.std(axis=0) * rng.standard_normal(x.shape)
    return table


def late(table):
    x = table[actuators(table)].to_numpy()
    table = table.iloc[20:].reset_index(drop=True)
    table[actuators(table)] = x[:-20]
    return table


def tilts_reversed(table):
    columns = [c for c in table if "tilt_" in c]
    table[columns] *= -1
    return table


def one_spin(content):
    content["rotors"][1]["spin"] *= -1


def all_spins(content):
    for rotor in content["rotors"]:
        rotor["spin"] *= -1


def swapped(content):
    rotors = content["rotors"]
    other = 2 if len(rotors) > 4 else 1
    rotors[0], rotors[other] = rotors[other], rotors[0]


def in_turn(content):
    content["rotors"] = content["rotors"][2:] + content["rotors"][:2]


def tilts_in_turn(content):
    content["tilts"] = content["tilts"][1:] + content["tilts"][:1]


LOGS = {
    "10 Hz, held": (held, "actuator log"),
    "10 Hz, empty between": (sparse, "actuator log"),
    "constant": (constant, "actuator log"),
    "of another flight": (backwards, "commands"),
    "random": (at_random, "commands"),
    "100 ms late": (late, "time stamps"),
}
FILES = {
    ("quadrotor", "one spin"): (one_spin, "vehicle file", "spin of rotor_1 reversed"),
    ("quadrotor", "all spins"): (all_spins, "vehicle file", "all spins reversed"),
    ("quadrotor", "two rotors swapped"): (swapped, "vehicle file", "each other's place"),
    ("quadrotor", "rotors in turn"): (in_turn, "commands", "order of columns"),
    ("omav", "one spin"): (one_spin, "vehicle file", "spin of rotor_1 reversed"),
    ("omav", "two rotors swapped"): (swapped, "vehicle file", "each other's place"),
    ("omav", "tilts in turn"): (tilts_in_turn, "commands", "order of columns"),
}


@pytest.mark.long
@pytest.mark.parametrize("name", ["omav", "quadrotor"])
@pytest.mark.parametrize("case", LOGS)
def test_a_log_whose_actuators_do_not_say_is_doubted(case, name):
    spoil, premise = LOGS[case]
    made = flights([spoil(t) for t in tables(name, DRAG[name])])
    found = said(model(name), made)
    assert found[premise].counts
    assert {"tx", "ty", "tz"} <= set(found[premise].axes)


@pytest.mark.parametrize(("name", "case"), FILES)
def test_a_wrong_vehicle_file_is_named(name, case):
    change, premise, words = FILES[name, case]
    found = said(model(name, change), flights(tables(name, DRAG[name])))
    assert words in found[premise].reason


def test_reversed_tilts_are_named():
    found = said(model("omav"), flights([tilts_reversed(t) for t in tables("omav", DRAG["omav"])]))
    assert "all tilt axes reversed" in found["vehicle file"].reason


def hovering(name, effects, monkeypatch):
    path = exact_simulation.path_of

    def still(vehicle, rng):
        made = path(vehicle, rng)
        return made._replace(amplitude=0.0 * made.amplitude, turn=0.0 * made.turn)

    monkeypatch.setattr(exact_simulation, "path_of", still)
    return [fly(CONTENT[name], effects, seconds=SECONDS, seed=k, noise=NOISE) for k in range(2)]


@pytest.mark.parametrize("name", ["omav", "quadrotor"])
def test_hover_is_doubted(name, monkeypatch):
    (found,) = doubts(model(name), flights(hovering(name, DRAG[name], monkeypatch)))
    assert (found.about, found.axes) == ("motion", AXES)


@pytest.mark.parametrize(
    ("name", "case"),
    [("omav", "10 Hz, held"), ("omav", "of another flight"), ("quadrotor", "of another flight"), ("omav", "constant")],
)
def test_where_data_cannot_say_no_effect_is_supported(case, name):
    found = diagnose(model(name), flights([LOGS[case][0](t) for t in tables(name, DRAG[name])]))
    content = as_dict(found)
    assert content["verdict"]["supported"] == []
    assert {e["verdict"] for e in content["effects"]} == {"Not testable here"}
    assert not any(axis["judged"] for axis in content["axes"].values())
    reason = next(iter(content["refused"].values()))
    assert reason in content["verdict"]["summary"]
    assert any(reason == e["reason"] for e in content["effects"])
    assert found.model.effects == ()


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "case", "refused"),
    [
        ("quadrotor", "one spin", {"tz"}),
        ("quadrotor", "two rotors swapped", {"tx", "ty"}),
        ("quadrotor", "10 Hz, held", {"fz", "tx", "ty", "tz"}),
        ("omav", "one spin", {"tx", "tz"}),
    ],
)
def test_a_premise_that_fails_takes_its_axes_out_and_the_others_are_judged(name, case, refused):
    made = tables(name, DRAG[name])
    if case in LOGS:
        found = diagnose(model(name), flights([LOGS[case][0](t) for t in made]))
    else:
        found = diagnose(model(name, FILES[name, case][0]), flights(made))
    content = as_dict(found)
    assert {axis for axis, said in content["axes"].items() if not said["judged"]} == refused
    assert all(content["axes"][axis]["reason"] for axis in refused)
    assert all(0 <= content["axes"][axis]["coherence"] <= 1 for axis in ("fz", "tx", "ty", "tz"))
    assert content["verdict"]["supported"] == ["linear_drag"]
    assert np.allclose(found.finding("linear_drag").parameters["d"][:2], DRAG[name]["linear_drag"]["d"][:2], rtol=0.05)
    # The torque that a wrong file makes up is no steady torque, and no rotor is weak that stands in another's place.
    assert all(found.finding(n).verdict not in CONFIDENT for n in ("steady_torque", "rotor_effectiveness"))
    if case == "one spin" and name == "quadrotor":
        moment = found.finding("moment_scale")
        assert moment.verdict == "Not testable here"
        assert "not tz" in moment.reason
        assert "spin of rotor_1 reversed" in moment.reason


@pytest.mark.long
def test_a_refusal_that_is_accepted_is_judged_and_said():
    made = flights(tables("quadrotor", DRAG["quadrotor"]))
    found = diagnose(model("quadrotor", one_spin), [accepting(f, ["wrong_vehicle_file"]) for f in made])
    content = as_dict(found)
    assert content["axes"]["tz"]["judged"] or "spin of rotor_1" not in content["axes"]["tz"]["reason"]
    (entry,) = [e for e in content["accepted"] if e["code"] == "wrong_vehicle_file"]
    assert "spin of rotor_1 reversed" in entry["what"]
    assert "accepted wrong_vehicle_file (tz)" in as_text(found)


def blown(table, rng):
    """The flight with air that pushes: an acceleration that follows the speed, and a wind."""
    turned = Rotation.from_quat(table[["qx", "qy", "qz", "qw"]].to_numpy())
    table[["ax", "ay", "az"]] -= 1.2 * turned.inv().apply(table[["vx", "vy", "vz"]].to_numpy() + rng.normal(0, 1, 3))
    return table


@pytest.mark.parametrize("name", ["omav", "quadrotor"])
def test_strong_air_shifts_a_correlation_and_is_no_late_stamp(name):
    rng = np.random.default_rng(3)
    found = doubts(model(name), flights([blown(t, rng) for t in tables(name, DRAG[name])]))
    assert not any(d.counts for d in found)


def test_a_response_that_is_early_on_one_axis_alone_is_said_and_refuses_nothing():
    def shifted(t, lag, frequencies=(0.5, 0.9, 1.6)):
        return sum(np.sin(2 * np.pi * f * (t - lag) + 3 * f) for f in frequencies)

    t = np.arange(0, 20, 0.01)
    noise = np.random.default_rng(0).normal(0, 0.01, (len(t), 6))
    predicted = np.stack([shifted(t + 0.1 * k, 0.0) for k in range(6)], axis=1)
    measured = predicted + noise
    measured[:, 3] = shifted(t + 0.3, -0.1)
    some = dict(floor=np.full(6, 0.01), red=np.ones(6), unit={}, force_from="", window=0.15, reasons={}, left_out={})

    def errors(measured, axes):
        keep = np.full((len(t), 6), np.nan)
        keep[:, axes] = measured[:, axes]
        return [EquationError(t, keep, predicted, **some)]

    def found(measured, axes):
        return contradictions(errors(measured, axes), model("quadrotor").vehicle)

    (alone,) = found(measured, [3])
    assert not alone.counts
    assert "100 ms before" in alone.reason
    assert not any(d.counts for d in found(measured, [2, 3, 4, 5]))
    every = np.stack([shifted(t + 0.1 * k, -0.1) for k in range(6)], axis=1) + noise
    (late,) = found(every, [2, 3, 4])
    assert late.counts
    assert late.code == "response_before_command"
    # What is left of a doubt beside the model that is given: what it explains is no response before its cause.
    better, same = errors(predicted + noise, [3]), errors(measured, [3])
    vehicle = model("quadrotor").vehicle
    other = replace(alone, code="rotors_saturated")
    assert still_doubtful((alone, other, late), better, vehicle) == (other, late)
    assert still_doubtful((alone, other, late), same, vehicle) == (alone, other, late)


@pytest.mark.parametrize("name", ["quadrotor", "omav"])
@pytest.mark.parametrize("order", ["right", "wrong"])
def test_thrust_on_an_arm_that_is_not_where_the_file_has_it_is_no_wrong_order(name, order):
    t = np.arange(0, 20, 0.01)

    def waves(*frequencies):
        return sum(np.sin(2 * np.pi * f * t + 3 * f) for f in frequencies)

    measured = np.stack([waves(0.4 + 0.1 * k, 1.1 + 0.13 * k) for k in range(6)], axis=1)
    predicted = measured.copy()
    if order == "wrong":
        predicted[:, 3] = waves(0.75, 1.9)
    # Five times as much of the thrust as of the torque itself.
    predicted[:, 3] += 5.0 * predicted[:, 2]
    measured += np.random.default_rng(0).normal(0, 0.01, measured.shape)
    some = dict(floor=np.full(6, 0.01), red=np.ones(6), unit={}, force_from="", window=0.15, reasons={}, left_out={})
    found = contradictions([EquationError(t, measured, predicted, **some)], model(name).vehicle)
    # Rotors that tilt push in every direction: what their arms do goes with no one force. One torque may be drowned.
    assert [d.code for d in found] == (["commands_unrelated"] if (name, order) == ("quadrotor", "wrong") else [])


@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_the_time_between_commands_is_that_of_the_commands_not_of_the_rows_they_straddle(offset):
    t = np.arange(0, 20, 0.01)
    rng = np.random.default_rng(0)
    values = rng.uniform(400, 600, (300, 4))
    # A row holds the mean of what acts over its step: half of it the old command where the new one falls between rows.
    first, second = (values[np.floor((t + shift + 1e-9) / 0.1).astype(int)] for shift in (0.0, offset * 0.01))
    table = pd.DataFrame({"t": t, **{f"cmd_rotor_{i}": 0.5 * (first + second)[:, i] for i in range(4)}})
    (doubt,) = [_thin(Flight(table), np.ones(len(t), dtype=bool), model("quadrotor").vehicle)]
    assert "every 100 ms only (10 Hz)" in doubt.reason


def test_commands_that_the_log_has_and_the_table_does_not_are_not_said_to_be_missing():
    table = pd.DataFrame({"t": np.arange(0, 20, 0.033)})
    table[[f"cmd_rotor_{i}" for i in range(4)]] = np.random.default_rng(0).uniform(400, 600, (len(table), 4))
    meta = {"channels": {"rotor_command": {"rate_hz": 50.0}, "rate": {"rate_hz": 1000.0}}}
    doubt = _thin(Flight(table, meta), np.ones(len(table), dtype=bool), model("quadrotor").vehicle)
    assert doubt.reason == (
        "the table has a row every 33 ms, where the log has rate every 1 ms, rotor_command every 20 ms: "
        "import the log with --rows rate"
    )


# At the largest usual sizes, or beyond: none of these is a fault of the data.
LARGE = {
    "omav": (
        {"com_offset": {"r": [0.02, -0.02, 0.02]}},
        {"rotor_lag": {"extra_time_constant": 0.08}},
        {"servo_lag": {"extra_time_constant": 0.1}},
        {"servo_bias": {"bias": [0.026, -0.02, 0.026, 0.02, -0.026, 0.02]}},
        {"rotor_effectiveness": {"rotor": 3, "factor": 0.6}},
        {"thrust_scale": {"factor": 0.7}},
        {"suspended_load": {"mass": 0.5, "length": 0.6}},
        {"steady_torque": {"t": [0.3, -0.3, 0.3]}},
        {"time_offset": {"dt": 0.05}},
    ),
    "quadrotor": (
        {"com_offset": {"r": [0.02, -0.02, 0.02]}},
        {"moment_scale": {"factor": 0.5}},
        {"rotor_lag": {"extra_time_constant": 0.08}},
        {"actuation_delay": {"delay": 0.03}},
        {"thrust_scale": {"factor": 0.7}},
        {"rotor_effectiveness": {"rotor": 3, "factor": 0.7}},
        {"suspended_load": {"mass": 0.12, "length": 0.6}},
        {"angular_damping": {"d": [0.01, 0.01, 0.01]}},
        {"steady_force": {"f": [0.4, 0.3, -0.3]}},
        {"gyroscopic": {"rotor_inertia": 3e-5}},
    ),
}


@pytest.mark.long
@pytest.mark.parametrize(("name", "effects"), [(n, e) for n, many in LARGE.items() for e in many])
def test_large_effects_are_not_doubted(name, effects):
    made = [fly(CONTENT[name], effects, seconds=SECONDS, seed=3, noise=NOISE)]
    assert doubts(model(name), flights(made)) == ()


def degrees(table):
    table[["wx", "wy", "wz"]] *= 180 / np.pi
    return table


def conjugated(table):
    table[["qx", "qy", "qz"]] *= -1
    return table


def in_g(table):
    table[["ax", "ay", "az"]] /= 9.81
    return table


def imu_turned(table):
    for c in "wa":
        table[[f"{c}x", f"{c}y"]] = table[[f"{c}y", f"{c}x"]].to_numpy() * [1, -1]
    return table


@pytest.mark.parametrize(("spoil", "code"), [(degrees, "rate_unit"), (conjugated, "attitude_inverse"),
                                         (in_g, "acceleration_unit"), (imu_turned, "against the IMU's")])  # fmt: skip
def test_what_check_rejects_is_rejected(spoil, code):
    (flight,) = flights([spoil(tables("quadrotor", DRAG["quadrotor"])[0])])
    with pytest.raises(InputError, match=code) as raised:
        examined(flight, model("quadrotor").vehicle)
    assert "\n" not in str(raised.value)


def test_a_flight_of_another_vehicle_is_rejected():
    (flight,) = flights(tables("omav", DRAG["omav"], 1)[:1])
    with pytest.raises(InputError, match=r"12 columns cmd_rotor_\* are in use, and the vehicle has 4"):
        examined(flight, model("quadrotor").vehicle)


def test_dead_samples_are_emptied_and_good_ones_kept():
    table = tables("quadrotor", DRAG["quadrotor"])[0]
    rows = slice(800, 1000)
    table.iloc[rows, table.columns.get_indexer(["wx", "wy", "wz"])] = table.loc[800, ["wx", "wy", "wz"]].to_numpy()
    (flight,) = flights([table])
    cleaned = examined(flight, model("quadrotor").vehicle)
    assert np.isnan(cleaned.get("wx", "wy", "wz")[810:990]).all()
    assert np.isfinite(cleaned.get("wx", "wy", "wz")[:790]).all()
    np.testing.assert_array_equal(cleaned.get("px"), flight.get("px"))
