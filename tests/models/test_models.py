"""The model along a flight, whatever channels it holds, and the model file."""

from __future__ import annotations

import pickle
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from infotraj.comparing.equation_error import equation_error
from infotraj.dynamics.actuators import body_wrench
from infotraj.dynamics.response import actuator_values
from infotraj.dynamics.rigid_body import accelerations
from infotraj.effects import effect_class
from infotraj.errors import InputError, UsageError
from infotraj.flight import Flight
from infotraj.models import Model, load_model, prepared, save_model
from infotraj.models.content import FileReference, Provenance
from infotraj.models.file import read_model
from infotraj.rotations import exp, multiply, to_body
from infotraj.vehicle import load_vehicle

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"
OMAV, QUADROTOR = VEHICLES / "omav.yaml", VEHICLES / "quadrotor.yaml"


def flight(vehicle, seconds=3.0, rate=200, seed=0):
    """Smooth motion and commands; what the IMU says follows from the attitude and is otherwise arbitrary."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * rate)) / rate
    w = 0.8 * np.sin(np.outer(t, [2.1, 1.7, 1.3]) + rng.uniform(-3, 3, 3))
    q = np.empty((len(t), 4))
    q[0] = [1, 0, 0, 0]
    for k in range(len(t) - 1):
        q[k + 1] = multiply(q[k], exp((t[k + 1] - t[k]) * 0.5 * (w[k] + w[k + 1])))
    place = np.array([0, 0, 1.5]) + np.sin(np.outer(t, [1.1, 1.4, 0.9]))
    speed = np.cos(np.outer(t, [1.1, 1.4, 0.9])) * [1.1, 1.4, 0.9]
    columns = {"t": t}
    for names, values in (
        (("px", "py", "pz"), place),
        (("qw", "qx", "qy", "qz"), q),
        (("vx", "vy", "vz"), speed),
        (("wx", "wy", "wz"), w),
        (("ax", "ay", "az"), np.broadcast_to([0.1, -0.2, 9.8], w.shape)),
    ):
        columns |= {name: values[:, i] for i, name in enumerate(names)}
    hover = 677 if vehicle.tilts else 1144
    columns |= {f"cmd_rotor_{i}": hover + 40 * np.sin(5 * t + i) for i in range(len(vehicle.rotors))}
    columns |= {f"cmd_tilt_{i}": 0.4 * np.sin(3 * t + i) for i in range(len(vehicle.tilts))}
    return Flight(pd.DataFrame(columns))


def effect_of(numbers):
    name, *own = numbers
    return effect_class(numbers[name])(**{k: numbers[k] for k in own})


def changed(f, **columns):
    return Flight(f.table.assign(**columns), dict(f.meta))


@pytest.mark.parametrize("path", [OMAV, QUADROTOR])
def test_a_vehicle_file_is_a_model_that_agrees_with_the_first_principles_model(path):
    model = load_model(path)
    v, f = model.vehicle, flight(model.vehicle)
    prediction = model.predict(f)
    rotor, tilt = actuator_values(v, f.t, f.numbered("cmd_rotor_"), f.numbered("cmd_tilt_"))
    q, w = f.get("qw", "qx", "qy", "qz"), f.get("wx", "wy", "wz")
    up = np.array([0.0, 0.0, v.gravity])
    acceleration, angular = accelerations(v, q, w, body_wrench(v, rotor, tilt))
    np.testing.assert_allclose(prediction.specific_force, to_body(q, acceleration + up), atol=1e-9)
    np.testing.assert_allclose(prediction.angular_acceleration, angular, atol=1e-9)
    assert prediction.covered.all()
    assert set(prediction.testable.values()) == {None}
    assert np.isnan(prediction.angular_acceleration_mean[-1]).all()


def test_what_the_vehicle_file_leaves_out_is_not_predicted(tmp_path):
    content = yaml.safe_load(QUADROTOR.read_text())
    full = load_model(QUADROTOR)
    f = flight(full.vehicle)
    for missing, axes, kept in (("inertia", "t", "specific_force"), ("mass", "f", "angular_acceleration")):
        path = tmp_path / f"{missing}.yaml"
        path.write_text(yaml.safe_dump({k: v for k, v in content.items() if k != missing}))
        model = load_model(path)
        prediction = model.predict(f)
        lost = "angular_acceleration" if missing == "inertia" else "specific_force"
        assert np.isnan(getattr(prediction, lost)).all()
        np.testing.assert_allclose(getattr(prediction, kept), getattr(full.predict(f), kept), atol=1e-12)
        assert all((missing in (r or "")) == (a[0] == axes) for a, r in prediction.testable.items())


def test_a_center_of_mass_shows_in_the_specific_force_without_a_known_inertia(tmp_path):
    content = yaml.safe_load(QUADROTOR.read_text())
    path = tmp_path / "v.yaml"
    path.write_text(yaml.safe_dump({k: v for k, v in content.items() if k != "inertia"}))
    vehicle = load_vehicle(path)
    f = flight(vehicle)
    r = np.array([0.01, -0.02, 0.005])
    offset = effect_class("com_offset")(r=r)
    difference = Model(vehicle, [offset]).predict(f).specific_force - Model(vehicle).predict(f).specific_force
    w = f.get("wx", "wy", "wz")
    dw = np.gradient(w, f.t, axis=0)
    np.testing.assert_allclose(difference, -np.cross(dw, r) - np.cross(w, np.cross(w, r)), atol=1e-9)


def test_without_rates_a_center_of_mass_beside_the_origin_leaves_the_force_open():
    vehicle = load_vehicle(QUADROTOR).model_copy(update={"center_of_mass": (0.01, 0.0, 0.0)})
    f = flight(vehicle)
    f = Flight(f.table.drop(columns=["qw", "qx", "qy", "qz", "wx", "wy", "wz"]))
    prediction = Model(vehicle).predict(f)
    assert np.isnan(prediction.specific_force).all()
    assert {axis for axis, why in prediction.testable.items() if why and "rates" in why} == set(prediction.testable)
    error = equation_error(Model(vehicle), f)
    assert not error.scored.any()
    assert "rates" in error.reasons["fz"]
    centred = vehicle.model_copy(update={"center_of_mass": (0.0, 0.0, 0.0)})
    assert np.isfinite(Model(centred).predict(f).specific_force).all()


def test_velocity_and_rates_are_derived_from_the_pose_where_they_are_missing():
    model = Model(load_vehicle(QUADROTOR), [effect_class("linear_drag")(d=[0.1, 0.1, 0.1])])
    f = flight(model.vehicle)
    less = Flight(f.table.drop(columns=["vx", "vy", "vz", "wx", "wy", "wz"]))
    full, derived = model.predict(f), model.predict(less)
    inner = slice(2, -2)
    np.testing.assert_allclose(derived.specific_force[inner], full.specific_force[inner], atol=1e-4)
    np.testing.assert_allclose(derived.angular_acceleration[inner], full.angular_acceleration[inner], atol=1e-3)
    assert "derived" in derived.kinematics.reasons["turn"]
    assert derived.kinematics.turn is None


def test_measured_actuators_stand_in_for_missing_commands():
    vehicle = load_vehicle(OMAV)
    f = flight(vehicle)
    rotor, tilt = actuator_values(vehicle, f.t, f.numbered("cmd_rotor_"), f.numbered("cmd_tilt_"))
    measured = f.table.drop(columns=[c for c in f.table if c.startswith("cmd_")])
    measured[[f"rotor_{i}" for i in range(12)]] = rotor
    measured[[f"tilt_{i}" for i in range(6)]] = tilt
    model = Model(vehicle)
    np.testing.assert_allclose(
        model.predict(Flight(measured)).specific_force, model.predict(f).specific_force, atol=1e-9
    )
    lag = Model(vehicle, [effect_class("rotor_lag")(extra_time_constant=0.1)])
    assert "commands" in effect_class("rotor_lag").cannot_show(vehicle, Flight(measured))
    np.testing.assert_array_equal(
        lag.predict(Flight(measured)).specific_force, model.predict(Flight(measured)).specific_force
    )
    with pytest.raises(InputError, match="cmd_rotor_0"):
        model.predict(Flight(f.table.drop(columns=[c for c in f.table if c.startswith("cmd_")])))


def test_channels_at_their_own_rates():
    """Commands at 50 Hz are held, poses at 100 Hz lie between their samples; nothing else changes."""
    vehicle = load_vehicle(OMAV)
    f = flight(vehicle)
    commands = [c for c in f.table if c.startswith("cmd_")]
    held = f.table.copy()
    held.loc[held.index % 4 != 0, commands] = np.nan
    full = held.copy()
    full[commands] = full[commands].ffill()
    poses = ["px", "py", "pz", "qw", "qx", "qy", "qz", "vx", "vy", "vz"]
    half = held.copy()
    half.loc[half.index % 2 != 0, poses] = np.nan
    model = Model(vehicle, [effect_class("linear_drag")(d=[0.5, 0.5, 0.5])])
    expected = model.predict(Flight(full)).specific_force
    np.testing.assert_allclose(model.predict(Flight(held)).specific_force, expected, atol=1e-9)
    np.testing.assert_allclose(model.predict(Flight(half)).specific_force[:-2], expected[:-2], atol=1e-6)


def test_rows_without_commands_for_long_or_without_motion_are_not_covered():
    vehicle = load_vehicle(QUADROTOR)
    f = flight(vehicle)
    commands = [f"cmd_rotor_{i}" for i in range(4)]
    table = f.table.copy()
    table.loc[(f.t > 1.0) & (f.t < 2.0), commands] = np.nan
    covered = Model(vehicle).predict(Flight(table)).covered
    assert covered[f.t < 1.2].all()
    assert not covered[(f.t > 1.3) & (f.t < 2.0)].any()
    assert covered[f.t >= 2.0].all()
    kept = pickle.loads(pickle.dumps(Model(vehicle).predict(Flight(table))))
    assert np.array_equal(kept.covered, covered)
    late = Model(vehicle, [effect_class("time_offset")(dt=0.05)]).predict(f).covered
    assert not late[f.t < 0.049].any()
    assert late[f.t > 0.051].all()


def test_an_effect_whose_channel_is_missing_is_refused_by_name():
    vehicle = load_vehicle(QUADROTOR)
    f = flight(vehicle)
    model = Model(vehicle, [effect_class("linear_drag")(d=[0.1, 0.1, 0.1])])
    blind = Flight(f.table[[c for c in f.table if c[0] not in "pqv"]])
    with pytest.raises(InputError, match=r"linear_drag.*attitude"):
        model.predict(blind)
    assert np.isfinite(Model(vehicle).predict(blind).specific_force).all()


def test_long_flights_are_evaluated_in_segments_without_a_seam(monkeypatch):
    vehicle = load_vehicle(OMAV)
    f = flight(vehicle)
    effects = [
        effect_class("rotor_drag")(k=1e-4),
        effect_class("suspended_load")(mass=0.3, length=0.5),
        effect_class("actuation_delay")(delay=0.013),
        effect_class("time_offset")(dt=0.004),
    ]
    whole = Model(vehicle, effects).predict(f)
    monkeypatch.setattr(prepared, "SEGMENT", 128)
    parts = Model(vehicle, effects).predict(f)
    for name in ("specific_force", "specific_force_mean", "angular_acceleration", "angular_acceleration_mean"):
        np.testing.assert_allclose(getattr(parts, name), getattr(whole, name), atol=1e-10)


def test_a_prepared_flight_gives_the_same_and_forgets_nothing_of_other_models():
    vehicle = load_vehicle(OMAV)
    f = flight(vehicle)
    ready = Model(vehicle).prepare(f)
    models = [
        Model(vehicle),
        Model(vehicle, [effect_class("rotor_lag")(extra_time_constant=0.02)]),
        Model(vehicle, [effect_class("rotor_lag")(extra_time_constant=0.03)]),
        Model(vehicle, [effect_class("gyro_bias")(b=[0.1, 0, 0]), effect_class("servo_bias")(bias=[0.01] * 6)]),
        Model(vehicle, [effect_class("thrust_scale")(factor=0.8), effect_class("gyroscopic")(rotor_inertia=1e-4)]),
    ]
    for model in models * 2:
        np.testing.assert_array_equal(model.predict(ready).angular_acceleration, model.predict(f).angular_acceleration)
    with pytest.raises(UsageError, match="another vehicle"):
        Model(load_vehicle(QUADROTOR)).predict(ready)


@pytest.mark.parametrize("accelerometer", [True, False])
def test_each_number_of_an_imu_changes_what_follows_from_it(accelerometer):
    """What is kept of one model is no part of the next, whatever its IMU: clocks, biases, filter, mounting."""
    vehicle = load_vehicle(QUADROTOR)
    f = flight(vehicle)
    f = f if accelerometer else Flight(f.table.drop(columns=["ax", "ay", "az"]), dict(f.meta))
    of_imu = [
        {"name": "gyro_bias", "b": [0.1, 0.0, -0.05]},
        {"name": "time_offset", "dt": 0.01},
        {"name": "sensor_lag", "time_constant": 0.01},
    ]
    if accelerometer:
        of_imu += [
            {"name": "accelerometer_bias", "b": [0.3, -0.2, 0.1]},
            {"name": "imu_misalignment", "rotvec": [0.02, 0.01, -0.03]},
        ]
    beside = [effect_class("rotor_drag")(k=5e-5), effect_class("suspended_load")(mass=0.02, length=0.5)]
    models = [Model(vehicle, [*beside, *map(effect_of, own)]) for own in ([], *([x] for x in of_imu), of_imu)]
    ready = models[0].prepare(f)
    seen = []
    for model in [*models, *models[::-1]]:
        kept, anew = model.predict(ready), model.predict(f)
        for name in ("specific_force", "specific_force_mean", "angular_acceleration", "angular_acceleration_mean"):
            np.testing.assert_array_equal(getattr(kept, name), getattr(anew, name))
        for name in ("turn", "turn_by_imu", "push", "push_by_imu"):
            np.testing.assert_array_equal(getattr(kept.kinematics, name), getattr(anew.kinematics, name))
        seen.append(anew.specific_force)
    assert not any(np.array_equal(seen[0], x) for x in seen[1 : len(models)])


def test_each_factor_of_the_thrust_is_kept_apart():
    """Of models with several, in any order and beside lags and delays."""
    vehicle = load_vehicle(OMAV)
    f = flight(vehicle)
    factors = [
        {"name": "rotor_effectiveness", "rotor": 1, "factor": 0.9},
        {"name": "rotor_effectiveness", "rotor": 3, "factor": 0.8},
        {"name": "battery_sag", "rate": 0.01},
        {"name": "thrust_exponent", "n": 1.9},
        {"name": "coaxial_loss", "fraction": 0.1},
        {"name": "rotor_lag", "extra_time_constant": 0.03},
        {"name": "actuation_delay", "delay": 0.01},
    ]
    sets = [factors, factors[::-1], factors[1:], factors[2:], factors[:2], [factors[0]], [factors[1]], factors[3:6]]
    sets.append([{**factors[0], "factor": 0.7}, *factors[1:]])
    models = [Model(vehicle, [effect_of(x) for x in own]) for own in sets]
    ready = models[0].prepare(f)
    for model in [*models, *models[::-1]]:
        kept, anew = model.predict(ready), model.predict(f)
        for name in ("specific_force", "angular_acceleration"):
            np.testing.assert_array_equal(getattr(kept, name), getattr(anew, name))


def test_time_grows_with_the_rows():
    vehicle = load_vehicle(QUADROTOR)
    model = Model(vehicle, [effect_class("rotor_drag")(k=5e-5)])
    model.predict(flight(vehicle))
    short, long = (flight(vehicle, seconds=length) for length in (10.0, 40.0))
    trials = []
    # In turns, and often: a busy machine or the garbage of other tests takes time from some of them.
    for _ in range(9):
        for f in (short, long):
            start = time.process_time()
            model.predict(f)
            trials.append(time.process_time() - start)
    assert min(trials[1::2]) < 8 * min(trials[::2])


def test_a_model_file_comes_back_as_it_was_written(tmp_path):
    vehicle = load_vehicle(OMAV)
    effects = [
        effect_class("com_offset")(r=[0.008, -0.005, 0.01]),
        effect_class("rotor_effectiveness")(rotor=3, factor=0.8),
        effect_class("rotor_effectiveness")(rotor=5, factor=0.9),
        effect_class("servo_bias")(bias=[0.01] * 6),
    ]
    origin = Provenance(
        version="0.1.0",
        parent=FileReference(path="omav.yaml", sha256="0" * 64),
        flights=(FileReference(path="a.parquet", sha256="1" * 64),),
        error={"before": {"fx": 1.0}, "after": {"fx": 0.5}},
    )
    errors = [{"r": [1e-4, 1e-4, 2e-4]}, {"factor": 0.01}, {"factor": 0.01}, {"bias": [1e-3] * 6}]
    path = tmp_path / "new.yaml"
    save_model(Model(vehicle, effects), path, standard_errors=errors, provenance=origin)
    model, file = read_model(path)
    assert model.vehicle == vehicle
    assert [e.values for e in model.effects] == [e.values for e in effects]
    assert [e.standard_errors for e in file.effects] == errors
    assert file.provenance == origin
    f = flight(vehicle)
    np.testing.assert_array_equal(
        load_model(path).predict(f).specific_force, Model(vehicle, effects).predict(f).specific_force
    )
    assert [p.name for p in tmp_path.iterdir()] == ["new.yaml"]


def test_a_model_file_may_name_its_vehicle_beside_it(tmp_path):
    (tmp_path / "v.yaml").write_text(QUADROTOR.read_text())
    path = tmp_path / "m.yaml"
    path.write_text("vehicle: v.yaml\neffects:\n- {name: thrust_scale, parameters: {factor: 0.9}}\n")
    assert load_model(path).effects[0].factor == 0.9


@pytest.mark.parametrize("name", ["v.yaml", "m.yaml", "sub/../v.yaml"])
def test_no_model_is_saved_over_a_file_that_it_was_read_from(tmp_path, name):
    """Nor is the model that a diagnosis makes of its vehicle."""
    (tmp_path / "sub").mkdir()
    (tmp_path / "v.yaml").write_text(QUADROTOR.read_text() + "# a comment\n")
    (tmp_path / "m.yaml").write_text("vehicle: v.yaml\neffects: []\n")
    before = (tmp_path / name).read_text()
    for model in (load_model(tmp_path / "m.yaml"), load_model(tmp_path / name)):
        more = Model(model.vehicle, [effect_class("thrust_scale")(factor=0.9)])
        with pytest.raises(UsageError, match="the model was read from; expected a new file"):
            save_model(more, tmp_path / name)
    assert (tmp_path / name).read_text() == before
    save_model(more, tmp_path / "new.yaml")
    save_model(more, tmp_path / "new.yaml")
    with pytest.raises(UsageError, match="was read from"):
        save_model(Model(load_vehicle(tmp_path / "v.yaml")), tmp_path / "v.yaml")


WEAK = "{name: rotor_effectiveness, parameters: {rotor: 3, factor: 0.9}}"


@pytest.mark.parametrize(
    "effects",
    [
        f"{WEAK}, {WEAK.replace('3', '1')}",  # of two rotors
        "{name: rotor_lag, parameters: {extra_time_constant: -0.03}}",  # less than the file declares, down to nothing
        "{name: thrust_scale, parameters: {factor: 0.49999999}}",  # a fit that ends at a bound, rounded
        "{name: battery_sag, parameters: {rate: 0.003}}",  # one of its forms
        "{name: wind, parameters: {v: [0, 0, 5]}}",  # more than is looked for along z
    ],
)
def test_what_may_be_and_what_a_fit_writes_is_read(tmp_path, effects):
    path = tmp_path / "m.yaml"
    path.write_text(f"vehicle: {QUADROTOR}\neffects: [{effects}]\n")
    assert load_model(path).effects


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("vehicle: v.yaml\neffect: []\n", "effect: unknown key"),
        ("vehicle: v.yaml\neffects: [{name: thrust_scal}]\n", "thrust_scale"),
        ("vehicle: v.yaml\neffects: [{name: thrust_scale, parameters: {fctor: 1}}]\n", "unknown parameter fctor"),
        ("vehicle: v.yaml\neffects: [{name: com_offset, parameters: {r: [1, 2]}}]\n", "3 finite numbers"),
        ("vehicle: v.yaml\neffects: [{name: mass_offset, parameters: {dm: high}}]\n", "parameters.dm"),
        ("vehicle: v.yaml\neffects: [{name: mass_offset, parameters: {dm: .nan}}]\n", "dm is nan; expected finite"),
        ("vehicle: v.yaml\neffects: [{name: com_offset, parameters: {r: [0, .inf, 0]}}]\n", "expected finite"),
        ("vehicle: v.yaml\neffects: [{name: thrust_scale}]\n", "thrust_scale has no factor"),
        ("vehicle: v.yaml\neffects: [{name: rotor_effectiveness, parameters: {rotor: 3}}]\n", "has no factor"),
        ("vehicle: v.yaml\neffects: [{name: rotor_effectiveness, parameters: {factor: 0.9}}]\n", "has no rotor"),
        ("vehicle: v.yaml\neffects: [{name: battery_sag}]\n", "battery_sag has no rate or exponent"),
        (
            "vehicle: v.yaml\neffects: [{name: thrust_scale, parameters: {factor: -3}}]\n",
            "expected 0.5 to 2, its physical",
        ),
        ("vehicle: v.yaml\neffects: [{name: linear_drag, parameters: {d: [0, 0, -0.1]}}]\n", "expected 0 to 10"),
        (f"vehicle: v.yaml\neffects: [{WEAK}, {WEAK}]\n", "rotor_effectiveness 3 stands twice"),
        ("vehicle: v.yaml\nprovenance: {parent: {path: x, sha256: short}}\n", "sha256"),
        ("vehicle: nowhere.yaml\n", "nowhere.yaml"),
        ("vehicle: {name: x, mass: -1, rotors: []}\n", "mass"),
        ("vehicle: [\n", "cannot be read"),
        ("[]\n", "holds list"),
    ],
)
def test_a_broken_model_file_is_refused_in_one_line(tmp_path, text, word):
    (tmp_path / "v.yaml").write_text(QUADROTOR.read_text())
    path = tmp_path / "m.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_model(path)
    assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_impossible_body_is_refused():
    vehicle = load_vehicle(QUADROTOR)
    f = flight(vehicle)
    for effect, word in (
        (effect_class("mass_offset")(dm=-1.0), "mass"),
        (effect_class("inertia_error")(dxx=-0.01), "inertia"),
    ):
        with pytest.raises(InputError, match=word):
            Model(vehicle, [effect]).predict(f)
