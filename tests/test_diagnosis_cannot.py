"""Data that cannot say which effect is missing: no name is supported, and the reason is given."""

from pathlib import Path

import exact_simulation
import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.premises import doubts, examined
from infotraj.diagnosis.summary import as_dict
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import Vehicle

VEHICLES = Path(__file__).parents[1] / "config" / "vehicles"
CONTENT = {name: yaml.safe_load((VEHICLES / f"{name}.yaml").read_text()) for name in ("omav", "quadrotor")}
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.002, "velocity": 0.01}
DRAG = {"omav": {"linear_drag": {"d": [0.5, 0.5, 0.8]}}, "quadrotor": {"linear_drag": {"d": [0.1, 0.1, 0.1]}}}
SECONDS = 7.0
_made = {}


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


@pytest.mark.parametrize("name", ["omav", "quadrotor"])
@pytest.mark.parametrize("case", LOGS)
def test_a_log_whose_actuators_do_not_say_is_doubted(case, name):
    spoil, premise = LOGS[case]
    made = flights([spoil(t) for t in tables(name, DRAG[name])])
    assert premise in doubts(model(name), made)


@pytest.mark.parametrize(("name", "case"), FILES)
def test_a_wrong_vehicle_file_is_named(name, case):
    change, premise, words = FILES[name, case]
    found = doubts(model(name, change), flights(tables(name, DRAG[name])))
    assert words in found[premise]


def test_reversed_tilts_are_named():
    found = doubts(model("omav"), flights([tilts_reversed(t) for t in tables("omav", DRAG["omav"])]))
    assert "all tilt axes reversed" in found["vehicle file"]


def hovering(name, effects, monkeypatch):
    path = exact_simulation._path

    def still(vehicle, rng):
        made = path(vehicle, rng)
        return made._replace(amplitude=0.0 * made.amplitude, turn=0.0 * made.turn)

    monkeypatch.setattr(exact_simulation, "_path", still)
    return [fly(CONTENT[name], effects, seconds=SECONDS, seed=k, noise=NOISE) for k in range(2)]


@pytest.mark.parametrize("name", ["omav", "quadrotor"])
def test_hover_is_doubted(name, monkeypatch):
    assert list(doubts(model(name), flights(hovering(name, DRAG[name], monkeypatch)))) == ["motion"]


@pytest.mark.parametrize("name", ["omav", "quadrotor"])
@pytest.mark.parametrize("case", ["10 Hz, held", "of another flight", "one spin"])
def test_where_data_cannot_say_no_effect_is_supported(case, name):
    made = tables(name, DRAG[name])
    if case in LOGS:
        found = diagnose(model(name), flights([LOGS[case][0](t) for t in made]))
    else:
        found = diagnose(model(name, one_spin), flights(made))
    said = as_dict(found)
    assert said["verdict"]["supported"] == []
    assert {e["verdict"] for e in said["effects"]} == {"Not testable here"}
    reason = next(iter(said["refused"].values()))
    assert reason in said["verdict"]["summary"]
    assert any(reason == e["reason"] for e in said["effects"])
    assert found.model.effects == ()


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


@pytest.mark.parametrize(("name", "effects"), [(n, e) for n, many in LARGE.items() for e in many])
def test_large_effects_are_not_doubted(name, effects):
    made = [fly(CONTENT[name], effects, seconds=SECONDS, seed=3, noise=NOISE)]
    assert doubts(model(name), flights(made)) == {}


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
                                         (in_g, "acceleration_unit"), (imu_turned, "_axes")])  # fmt: skip
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
