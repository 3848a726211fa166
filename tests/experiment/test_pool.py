"""The pool scenario: lateral force, recorded flights as a robot, choosing by cost, and the interval of its gain."""

import numpy as np
import pandas as pd
import pytest

from infotraj import rotations
from infotraj.datasets import location, nanobench
from infotraj.errors import InputError, UsageError
from infotraj.evaluation import pool_choice
from infotraj.evaluation.lateral_force import lateral_force
from infotraj.experiment.real import pool as stage
from infotraj.flight import Flight
from infotraj.robots.pool import Pool, flat_attitude

GRAVITY = np.array([0.0, 0.0, 9.81])


def circle(speed, radius=1.0, drag=0.4, seconds=20.0, climb=0.0, start=0.0):
    """A circle flown with linear drag in body x and y: the attitude is what that needs, by fixed-point iteration."""
    t = np.arange(0, seconds, 0.01)
    angle = start + speed / radius * t
    position = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 1.2 + climb * np.sin(2 * angle)])
    rate = speed / radius
    vertical = 2 * climb * rate
    velocity = np.column_stack([-speed * np.sin(angle), speed * np.cos(angle), vertical * np.cos(2 * angle)])
    acceleration = np.column_stack(
        [-speed * rate * np.cos(angle), -speed * rate * np.sin(angle), -2 * vertical * rate * np.sin(2 * angle)]
    )
    attitude = flat_attitude(acceleration, np.zeros(len(t)))
    for _ in range(20):
        lateral = rotations.to_body(attitude, velocity) * [-drag, -drag, 0.0]
        attitude = flat_attitude(acceleration - rotations.to_world(attitude, lateral), np.zeros(len(t)))
    weight = np.linalg.norm(acceleration + GRAVITY, axis=1) / 9.81
    columns = {"t": t, "battery": np.full(len(t), 3.7)}
    for prefix in ("", "ref_"):
        columns |= {f"{prefix}p{a}": position[:, k] for k, a in enumerate("xyz")}
        columns |= {f"{prefix}q{a}": attitude[:, k] for k, a in enumerate("wxyz")}
    columns |= {f"cmd_rotor_{k}": 0.8 * np.sqrt(weight) for k in range(4)}
    return Flight(pd.DataFrame(columns))


def test_lateral_force_is_the_drag_that_acts():
    flown = lateral_force(circle(speed=1.0, drag=0.4))
    drag = -0.4 * flown.velocity[:, :2]
    np.testing.assert_allclose(flown.force, drag - drag.mean(axis=0), atol=0.005)
    assert flown.t[0] == pytest.approx(1.5)
    assert flown.t[-1] == pytest.approx(19.99 - 1.5)


def test_thrust_goes_with_the_square_of_throttle_times_voltage():
    one, two = circle(speed=1.0), circle(speed=1.0)
    two.table["battery"] *= 1.1
    np.testing.assert_allclose(lateral_force(two).thrust, 1.21 * lateral_force(one).thrust)


def test_rows_near_the_ground_and_a_spike_of_the_battery_do_not_count():
    flight = circle(speed=1.0)
    flight.table.loc[:499, "pz"] = 0.1
    flight.table.loc[1000:1010, "battery"] = 2.0
    flown = lateral_force(flight)
    assert flown.t[0] == pytest.approx(6.5)
    assert np.ptp(flown.thrust) < 0.01 * flown.thrust.mean()
    flight.table["pz"] = 0.1
    with pytest.raises(InputError, match="no row in flight"):
        lateral_force(flight)


def test_pool_answers_with_the_recorded_flight_only():
    recorded = {"a": circle(speed=1.0), "b": circle(speed=0.5)}
    robot = Pool(recorded)
    reference = robot.reference("b")
    assert robot.fly(reference) is recorded["b"]
    np.testing.assert_allclose(np.linalg.norm(reference.velocity[50:-50], axis=1), 0.5, atol=1e-3)
    with pytest.raises(UsageError, match="never flown"):
        robot.fly(Pool({"c": circle(speed=0.7)}).reference("c"))
    with pytest.raises(UsageError, match="no flight z"):
        robot.reference("z")


def test_flat_attitude_carries_the_acceleration():
    rng = np.random.default_rng(0)
    acceleration, yaw = rng.normal(size=(50, 3)) * 3, rng.uniform(-3, 3, 50)
    attitude = flat_attitude(acceleration, yaw)
    lateral = rotations.to_body(attitude, acceleration + GRAVITY)
    np.testing.assert_allclose(lateral[:, :2], 0, atol=1e-9)
    np.testing.assert_allclose(rotations.to_euler(attitude)[:, 2], yaw, atol=1e-9)


def test_region_lies_within_epsilon_and_fills_it():
    rng = np.random.default_rng(0)
    visited = np.column_stack([np.linspace(0, 4, 200), np.zeros(200)])
    region = stage.region_around(visited, 0.5, 2000, rng)
    distance = np.linalg.norm(region[:, None] - visited, axis=2).min(axis=1)
    assert distance.max() <= 0.5
    # Uniform in the area: half of a straight tube's area lies beyond half of its width.
    inside = (region[:, 0] > 0.5) & (region[:, 0] < 3.5)
    assert np.mean(distance[inside] > 0.25) == pytest.approx(0.5, abs=0.04)


def test_unknown_settings_are_refused():
    with pytest.raises(UsageError, match="recorded or planned"):
        stage.Settings(region="guessed")


def small_pool():
    flights = {
        "P_slow_rep1": circle(0.4),
        "T_fast_rep1": circle(1.2, climb=0.05),
        "C_slow_rep1": circle(0.45, start=1.0),
        "C_medium_rep1": circle(0.8, climb=0.1, start=2.0),
        "C_fast_rep1": circle(1.15, climb=0.05, start=0.5),
    }
    rng = np.random.default_rng(0)
    for flight in flights.values():
        for axis in "xyz":
            flight.table[f"p{axis}"] += 2e-4 * rng.standard_normal(len(flight.table))
        for k in range(4):
            flight.table[f"cmd_rotor_{k}"] += 0.01 * rng.standard_normal(len(flight.table))
    return Pool(flights)


@pytest.mark.long
@pytest.mark.parametrize("lengthscale", [None, 1.0])
def test_the_flight_that_covers_the_task_is_chosen_and_teaches_most(lengthscale):
    settings = stage.Settings(region_points=150, restarts=1, lengthscale=lengthscale)
    table = stage.judge(small_pool(), [0], settings)
    assert list(table.columns) == list(stage.COLUMNS)
    assert (table["candidate"] != table["task"]).all()
    assert (table["candidate"] != table["prior"]).all()
    one = table[(table["task"] == "T_fast_rep1") & (table["prior"] == "P_slow_rep1")].set_index("candidate")
    assert one["chosen"].idxmax() == "C_fast_rep1"
    assert one["error"].idxmin() == "C_fast_rep1"
    assert one.loc["C_fast_rep1", "error"] < one.loc["C_fast_rep1", "error_before"]
    again = stage.judge(small_pool(), [0], settings)
    pd.testing.assert_frame_equal(table, again)


def test_the_cost_never_sees_a_force_of_task_or_candidate(monkeypatch):
    settings = stage.Settings(region_points=100, restarts=1)
    table = stage.judge(small_pool(), [0], settings)
    rng = np.random.default_rng(5)
    honest = stage.lateral_force

    def scrambled(recorded):
        flown = honest(recorded)
        if len(flown.velocity) and np.linalg.norm(flown.velocity, axis=1).mean() > 0.5:  # all but the priors
            return stage.LateralForce(flown.t, flown.velocity, flown.thrust, rng.normal(size=flown.force.shape))
        return flown

    monkeypatch.setattr(stage, "lateral_force", scrambled)
    other = stage.judge(small_pool(), [0], settings)
    np.testing.assert_array_equal(table["cost"], other["cost"])
    assert not np.allclose(table["error"], other["error"])


def made_up_table(gain, rng, tasks=8, priors=3, seeds=2, candidates=9):
    rows = []
    for task in range(tasks):
        level = rng.normal(0.2, 0.03)
        for prior in range(priors):
            for seed in range(seeds):
                error = level + 0.02 * rng.standard_normal(candidates)
                error[0] = np.median(error[1:]) - gain + 0.004 * rng.standard_normal()
                for k in range(candidates):
                    rows.append((f"t{task}", f"p{prior}", f"c{k}", seed, float(k), error[k], int(k == 0)))
    return pd.DataFrame(rows, columns=list(pool_choice.NEEDED))


def test_interval_finds_a_gain_and_no_other():
    rng = np.random.default_rng(2)
    found = pool_choice.overall(pool_choice.choices(made_up_table(0.02, rng)), rng).set_index("against")
    assert found.loc["median", "high"] < 0
    assert found.loc["median", "low"] < -0.01
    none = pool_choice.overall(pool_choice.choices(made_up_table(-0.02, rng)), rng).set_index("against")
    assert none.loc["median", "low"] > 0


def test_repeating_seeds_does_not_narrow_the_interval():
    rng = np.random.default_rng(3)
    table = made_up_table(0.01, rng)
    more = pd.concat([table.assign(seed=table["seed"] + 10 * k) for k in range(5)])
    once, five = (pool_choice.overall(pool_choice.choices(x), np.random.default_rng(0)) for x in (table, more))
    np.testing.assert_allclose(once[["low", "high"]], five[["low", "high"]])


def test_choosing_again_takes_the_least_cost_that_is_left():
    table = made_up_table(0.01, np.random.default_rng(4))
    left = pool_choice.choose_again(table, (table["candidate"] != "c0").to_numpy())
    assert set(left.loc[left["chosen"] == 1, "candidate"]) == {"c1"}
    assert (pool_choice.choices(left)["candidates"] == 8).all()


def test_summary_counts_the_rank_and_refuses_other_tables(tmp_path):
    table = pd.DataFrame(
        {
            "task": ["a"] * 3 + ["b"] * 3,
            "prior": "p",
            "candidate": ["x", "y", "z"] * 2,
            "seed": 0,
            "cost": [1.0, 2.0, 3.0] * 2,
            "error": [0.2, 0.1, 0.3, 0.1, 0.2, 0.3],
            "chosen": [1, 0, 0] * 2,
        }
    )
    table.to_csv(tmp_path / "pool.csv", index=False)
    where = {"table": tmp_path / "pool.csv", "summary": tmp_path / "s.csv", "markdown": tmp_path / "s.md"}
    stage.summarise_pool(**where)
    summary = pd.read_csv(tmp_path / "s.csv").set_index("task")
    assert summary.loc["a", "rank"] == 2
    assert summary.loc["b", "rank"] == 1
    assert summary.loc["a", "below_median"] == pytest.approx(0.0)
    assert summary.loc["b", "correlation"] == pytest.approx(1.0)
    assert "| b | 0.100 | 0.200 |" in (tmp_path / "s.md").read_text()
    table.drop(columns="error").to_csv(tmp_path / "pool.csv", index=False)
    with pytest.raises(InputError, match="error"):
        stage.summarise_pool(**where)


def test_real_flights_are_judged_without_their_own_task(tmp_path):
    folder = location.find_dataset(nanobench.NAME)
    if folder is None:
        pytest.skip(location.how_to_get(nanobench.NAME))
    good = nanobench.good_flights(folder)
    assert len(good) - 2 == 19  # candidates a task and prior
    names = ["B9_trefoil_fast_rep4", "B5_helix_slow_rep1", "B9_trefoil_fast_rep1", "B6_linear_ramp_rep2"]
    pool = Pool({name: nanobench.read(good[name]) for name in names})
    table = stage.judge(pool, [0], stage.Settings(restarts=0, region_points=200))
    one = table[table["task"] == names[0]].set_index("candidate")
    assert list(one.index) == names[2:]
    # The same trajectory flown again teaches the task; a vertical ramp cannot, and the cost knows it beforehand.
    assert one["chosen"].to_dict() == {names[2]: 1, names[3]: 0}
    assert one["error"].idxmin() == names[2]
    table.to_csv(tmp_path / "pool.csv", index=False)
    stage.summarise_pool(table=tmp_path / "pool.csv", summary=tmp_path / "s.csv", markdown=tmp_path / "s.md")
    assert "Without the candidates that follow" in (tmp_path / "s.md").read_text()
