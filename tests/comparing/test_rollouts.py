"""Rollouts: order of the integrator against MuJoCo, actuators that go on, horizons, every model form the same."""

import importlib
from pathlib import Path

import mujoco
import numpy as np
import pandas as pd
import pytest

from infotraj import rotations
from infotraj.comparing.rollouts import Rollouts, mean_errors, parse_horizons, rollouts
from infotraj.effects.registry import catalogue
from infotraj.errors import UsageError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle, parse_vehicle

# The package offers the function under the module's name.
module = importlib.import_module("infotraj.comparing.rollouts")

QUADROTOR = Path(__file__).parents[2] / "config" / "vehicles" / "quadrotor.yaml"
ROW, FINE = 0.04, 5e-5  # s between rows; of MuJoCo's own steps


def in_mujoco(vehicle, seconds, seed):
    """A flight of the same rigid body in MuJoCo: random rotor commands, thrust set to its exact value in mid-step."""
    sites = "".join(
        f'<site name="s{i}" pos="{r.position[0]} {r.position[1]} {r.position[2]}"/>'
        for i, r in enumerate(vehicle.rotors)
    )
    motors = "".join(
        f'<general site="s{i}" gear="0 0 1 0 0 {-r.spin * r.moment_constant}"/>' for i, r in enumerate(vehicle.rotors)
    )
    inertia = vehicle.inertia
    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco><option timestep="{FINE}" integrator="RK4" gravity="0 0 {-vehicle.gravity}"/>
        <worldbody><body><freejoint/>
          <inertial pos="0 0 0" mass="{vehicle.mass}" diaginertia="{inertia.xx} {inertia.yy} {inertia.zz}"/>{sites}
        </body></worldbody><actuator>{motors}</actuator></mujoco>""")
    data = mujoco.MjData(model)
    rng = np.random.default_rng(seed)
    data.qpos[:3], data.qvel[:3], data.qvel[3:] = [0, 0, 30], [1, -0.5, 0.3], rng.normal(0, 1.5, 3)
    k_f, tau = vehicle.rotors[0].thrust_coefficient, vehicle.rotors[0].time_constant
    hover = np.sqrt(vehicle.mass * vehicle.gravity / 4 / k_f)
    rows, speed = [], None
    for k in range(round(seconds / ROW) + 1):
        command = hover * (1.0 + 0.1 * rng.standard_normal(4))
        speed = command.copy() if speed is None else speed
        rows.append([k * ROW, *data.qpos, *data.qvel, *command])
        for step in range(round(ROW / FINE)):
            middle = command + (speed - command) * np.exp(-(step + 0.5) * FINE / tau)
            data.ctrl[:] = k_f * middle**2
            mujoco.mj_step(model, data)
        speed = command + (speed - command) * np.exp(-ROW / tau)
    names = ["t", "px", "py", "pz", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"]
    return Flight(pd.DataFrame(rows, columns=[*names, *(f"cmd_rotor_{i}" for i in range(4))]))


@pytest.fixture(scope="module")
def mujoco_flight():
    return in_mujoco(load_vehicle(QUADROTOR), 1.2, seed=4)


def test_rollouts_agree_with_mujoco_to_fourth_order(mujoco_flight):
    model = Model(load_vehicle(QUADROTOR))
    errors = []
    for substeps in (1, 2, 4):
        found = rollouts(model, mujoco_flight, parse_horizons("5"), substeps=substeps)
        assert found.order == 4
        assert found.starts[0] >= 8
        errors.append([mean_errors([found])[m]["5"] for m in ("position", "velocity", "attitude", "rate")])
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all(orders > 3.5), (errors, orders)
    assert np.all(np.array(errors[-1]) < 1e-4)


def test_actuators_stand_where_the_commands_brought_them(mujoco_flight):
    """Started anew at each start (at the row's own command), the rotors would be off by their whole lag."""
    content = load_vehicle(QUADROTOR).model_dump(exclude_none=True)
    content["rotors"] = [{**r, "time_constant": 0.0} for r in content["rotors"]]
    horizons = parse_horizons("1")
    right = mean_errors([rollouts(Model(load_vehicle(QUADROTOR)), mujoco_flight, horizons)])["rate"]["1"]
    wrong = mean_errors([rollouts(Model(parse_vehicle(content)), mujoco_flight, horizons)])["rate"]["1"]
    assert wrong > 100 * right


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("linear_drag", {"d": [0.1, 0.2, 0.05]}),
        ("quadratic_drag", {"d": [0.1, 0.2, 0.05]}),
        ("rotor_drag", {"k": 8e-5}),
        ("axial_inflow", {"k": 2e-4}),
        ("angular_damping", {"d": [0.01, 0.01, 0.02]}),
        ("gyroscopic", {"rotor_inertia": 3e-5}),
        ("steady_force", {"f": [0.3, -0.2, 0.1]}),
        ("com_offset", {"r": [0.005, -0.003, 0.004]}),
        ("thrust_scale", {"factor": 0.9}),
        ("hub_moment", {"k": 2e-5}),
        ("thrust_exponent", {"n": 2.2}),
    ],
)
def test_linear_form_and_evaluation_state_by_state_agree(mujoco_flight, monkeypatch, name, values):
    model = Model(load_vehicle(QUADROTOR), [catalogue()[name](**values)])
    horizons = parse_horizons("1,10")
    fast = rollouts(model, mujoco_flight, horizons)
    monkeypatch.setattr(module.state_wrench, "active_features", lambda *_: None)
    slow = rollouts(model, mujoco_flight, horizons)
    plain = rollouts(Model(load_vehicle(QUADROTOR)), mujoco_flight, horizons)
    there = np.isfinite(slow.errors)
    assert np.array_equal(there, np.isfinite(fast.errors))
    assert np.abs(fast.errors - slow.errors)[there].max() < 1e-8
    assert np.abs(plain.errors - slow.errors)[there].max() > 1e-5


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("gyroscopic", {"rotor_inertia": 3e-4}),
        ("translational_lift", {"k": 0.02}),
        ("suspended_load", {"mass": 0.1, "length": 0.3}),
    ],
)
def test_a_rollout_is_pushed_by_what_the_model_predicts(mujoco_flight, name, values):
    """At recorded states the wrench, and so what an effect adds to it, is the prediction's own."""
    vehicle = load_vehicle(QUADROTOR)
    added = []
    for model in (Model(vehicle), Model(vehicle, [catalogue()[name](**values)])):
        prepared = module.Prepared(vehicle, mujoco_flight)
        state = module._states(model, prepared)[2:-2]
        attitude = rotations.matrix(state[:, 6:10])
        velocity = np.einsum("nji,nj->ni", attitude, state[:, 3:6])
        inputs = module.state_wrench.instants(model, prepared, prepared.recorded.t[2:-2])
        wrench = module.state_wrench.wrench(model, inputs, state[:, 2], velocity, attitude, state[:, 10:])
        force = vehicle.mass * model.predict(prepared).specific_force[2:-2]
        assert wrench[:, :3] == pytest.approx(force, rel=1e-3, abs=1e-3)
        inertia = np.diag([vehicle.inertia.xx, vehicle.inertia.yy, vehicle.inertia.zz])
        turning = np.linalg.solve(inertia, (wrench[:, 3:] - np.cross(state[:, 10:], state[:, 10:] @ inertia)).T).T
        predicted = model.predict(prepared).angular_acceleration[2:-2]
        assert turning == pytest.approx(predicted, rel=1e-3, abs=1e-2)
        added.append(np.abs(wrench).sum())
    assert added[0] != pytest.approx(added[1], rel=1e-4)


def test_wind_acts_in_rollouts(mujoco_flight):
    """On an even linear drag it is a steady force, by the linear form and state by state alike."""
    vehicle, d, v = load_vehicle(QUADROTOR), 0.2, np.array([3.0, -2.0, 0.5])
    drag = catalogue()["linear_drag"](d=[d, d, d])
    windy, pushed, still = (
        rollouts(Model(vehicle, [drag, *more]), mujoco_flight, parse_horizons("10"))
        for more in ([catalogue()["wind"](v=v)], [catalogue()["steady_force"](f=d * v)], [])
    )
    there = np.isfinite(windy.errors)
    assert np.abs(windy.errors - pushed.errors)[there].max() < 1e-9
    assert np.abs(windy.errors - still.errors)[there].max() > 1e-4


def test_an_effect_that_is_not_linear_is_evaluated_at_every_state(mujoco_flight):
    model = Model(load_vehicle(QUADROTOR), [catalogue()["ground_effect"](k=0.3)])
    prepared = module.Prepared(model.vehicle, mujoco_flight)
    grid = module._grid(mujoco_flight.t, 1)
    inputs = module.state_wrench.instants(model, prepared, grid.ravel())
    assert module.state_wrench.active_features(model, inputs) is None
    assert np.isfinite(rollouts(model, mujoco_flight, parse_horizons("3")).errors).any()


def test_an_error_is_a_distance_and_an_angle(mujoco_flight):
    """One row is put elsewhere by known amounts: a rollout that ends there is off by them."""
    table, row = mujoco_flight.table.copy(), 22
    at = table.index[row]
    table.loc[at, ["px", "py"]] += [0.3, 0.4]
    table.loc[at, ["vy", "vz"]] += [0.6, 0.8]
    table.loc[at, "wz"] += 2.0
    turn = np.array([np.cos(0.1), np.sin(0.1), 0.0, 0.0])  # by 0.2 rad about x
    quaternion = ["qw", "qx", "qy", "qz"]
    table.loc[at, quaternion] = rotations.multiply(table.loc[[at], quaternion].to_numpy(), turn[None])[0]
    found = rollouts(Model(load_vehicle(QUADROTOR)), Flight(table), parse_horizons("1"))
    before = np.argmin(np.abs(found.t - table["t"][at] + ROW))
    assert found.errors[before, 0] == pytest.approx([0.5, 1.0, 0.2, 2.0], abs=2e-3)


def test_the_markers_of_a_body_roll_out_as_its_origin_does(mujoco_flight):
    """A point r of the body is at p + R r and moves with v + R (w x r): with r in the file the errors are the same."""
    vehicle, r = load_vehicle(QUADROTOR), np.array([0.04, -0.07, 0.1])
    table = mujoco_flight.table
    q, v, w = (table[list(c)].to_numpy() for c in (["qw", "qx", "qy", "qz"], ["vx", "vy", "vz"], ["wx", "wy", "wz"]))
    turned = rotations.matrix(q)
    place, moves = turned @ r, v + np.einsum("nij,nj->ni", turned, np.cross(w, r))
    there = {f"p{a}": table[f"p{a}"] + place[:, i] for i, a in enumerate("xyz")}
    seen = Flight(table.assign(**there, vx=moves[:, 0], vy=moves[:, 1], vz=moves[:, 2]))
    marked = Model(vehicle.model_copy(update={"measured_at": tuple(r)}))
    horizons = parse_horizons("3")
    origin, point = rollouts(Model(vehicle), mujoco_flight, horizons), rollouts(marked, seen, horizons)
    np.testing.assert_allclose(point.errors, origin.errors, atol=1e-9)
    assert np.abs(rollouts(Model(vehicle), seen, horizons).errors - origin.errors).max() > 1e-3


def test_the_mean_is_over_all_starts_of_all_flights_that_reach_the_horizon():
    horizons = parse_horizons("1,2")
    one, other = (np.full((n, 2, 4), np.nan) for n in (1, 3))
    one[0, 0, 0], other[:, 0, 0] = 9.0, [1.0, np.nan, 2.0]
    found = mean_errors([Rollouts(np.arange(len(e)) * 0.1, e, horizons) for e in (one, other)])
    assert found["position"] == {"1": 4.0, "2": None}


def test_horizons_in_steps_and_seconds_meet_the_same_row(mujoco_flight):
    found = rollouts(Model(load_vehicle(QUADROTOR)), mujoco_flight, parse_horizons("5,0.2s"))
    assert np.allclose(found.errors[:, 0], found.errors[:, 1], equal_nan=True)
    with pytest.raises(UsageError, match="horizon"):
        parse_horizons("1,ten")


def test_no_rollout_crosses_a_gap_or_starts_in_the_first_half_second(mujoco_flight):
    table = mujoco_flight.table.drop(index=[20, 21, 22, 23, 24]).reset_index(drop=True)
    found = rollouts(Model(load_vehicle(QUADROTOR)), Flight(table), parse_horizons("2"))
    assert found.t.min() >= 0.5
    gap = 19 * ROW
    starts = found.t[np.isfinite(found.errors[:, 0, 0])]
    assert not np.any((starts > gap - 2 * ROW + 1e-9) & (starts < gap + 6 * ROW - 1e-9))


def test_without_pose_or_inertia_the_reason_is_said(mujoco_flight):
    vehicle = load_vehicle(QUADROTOR)
    no_pose = Flight(mujoco_flight.table.drop(columns=["px", "py", "pz"]))
    assert rollouts(Model(vehicle), no_pose, parse_horizons("1")).reason == "the flight has no position"
    content = {**vehicle.model_dump(exclude_none=True)}
    content.pop("inertia")
    assert "inertia" in rollouts(Model(parse_vehicle(content)), mujoco_flight, parse_horizons("1")).reason
