"""Lateral forces, tracking errors, intervals and references of recorded flights, by motions that are known."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from infotraj.evaluation.angular_acceleration import AxisErrors, prediction_error
from infotraj.evaluation.intervals import bootstrap_mean
from infotraj.evaluation.lateral_force import counted_rows, derivative, lateral_force, resample, rms
from infotraj.evaluation.pool_choice import by_task, choose_again, overall
from infotraj.evaluation.proportions import proportion
from infotraj.flight import Flight
from infotraj.residual.learning_data import LearningData
from infotraj.robots.pool import flat_attitude, set_point_reference
from infotraj.rotations import exp, to_body, to_world

T = np.arange(0.0, 12.0, 0.01)


def flown():
    """It sways along x at half a hertz, turned by 90 degrees to the left, and pushes along its own z."""
    sway = np.sin(np.pi * T)
    turned = np.broadcast_to(exp(np.array([0.0, 0.0, np.pi / 2])), (len(T), 4))
    columns = {"t": T, "px": sway, "py": 0.0 * T, "pz": np.where(T < 1.0, 0.2, 1.0)}
    columns |= {f"q{a}": turned[:, i] for i, a in enumerate("wxyz")}
    volts = np.full(len(T), 4.0)
    volts[500:503] = 1.0
    columns |= {f"cmd_rotor_{i}": 0.5 + 0.0 * T for i in range(4)} | {"battery": volts}
    return Flight(pd.DataFrame(columns))


def test_a_lateral_force_is_what_moves_the_body_sideways_in_its_own_axes():
    found = lateral_force(flown())
    # What goes along x of the world goes to the right of a body that looks to the left.
    sway = -(np.pi**2) * np.sin(np.pi * found.t)
    expected = np.stack([0.0 * sway, -sway], axis=1)
    np.testing.assert_allclose(found.force, expected - expected.mean(axis=0), atol=0.35)
    assert np.std(found.force[:, 1]) > 10.0 * np.std(found.force[:, 0])
    np.testing.assert_allclose(found.velocity[:, 1], -np.pi * np.cos(np.pi * found.t), atol=0.1)
    # Four rotors at half of the throttle and 4 V, a spike of three rows left out.
    np.testing.assert_allclose(found.thrust, 4 * (0.5 * 4.0) ** 2)
    assert found.t[0] == pytest.approx(2.5, abs=0.02)
    assert found.t[-1] == pytest.approx(T[-1] - 1.5, abs=0.02)


def test_rows_count_in_the_air_and_a_second_and_a_half_within():
    height, running = np.where((T > 2.0) & (T < 10.0), 0.5, 0.3), T > 3.0
    kept = T[counted_rows(T, height, running)]
    assert (kept[0], kept[-1]) == pytest.approx((4.51, 8.49), abs=0.011)
    assert not counted_rows(T, 0.0 * T, running).any()


def test_derivatives_are_those_of_a_cubic():
    cubic = np.outer(T**3, [1.0, -2.0])
    np.testing.assert_allclose(derivative(cubic, 1), np.outer(3 * T**2, [1.0, -2.0]), atol=1e-6)
    np.testing.assert_allclose(derivative(cubic, 2), np.outer(6 * T, [1.0, -2.0]), atol=1e-5)
    assert resample(np.array([0.0, 2.0]), np.array([[1.0, 3.0], [5.0, 7.0]]), np.array([0.5])).tolist() == [[2.0, 4.0]]
    assert rms(np.array([[3.0, 4.0], [0.0, 0.0]])) == pytest.approx(2.5)


def test_an_error_is_absolute_by_axis_and_beside_a_model_s_prediction():
    made = AxisErrors(T[:2], np.array([[1.0, 2.0, 3.0], [3.0, 4.0, 5.0]]))
    assert made.by_axis.tolist() == [2.0, 3.0, 4.0]
    assert made.mean == 3.0
    data = LearningData.__new__(LearningData)
    object.__setattr__(data, "t", T[:1])
    object.__setattr__(data, "inputs", np.zeros((1, 6)))
    object.__setattr__(data, "outputs", np.array([[1.0, -2.0, 0.5]]))
    assert prediction_error(None, data).absolute.tolist() == [[1.0, 2.0, 0.5]]

    class Half:
        """Predicts half of it."""

        def mean(self, inputs):
            return 0.5 * data.outputs

    assert prediction_error(Half(), data).absolute.tolist() == [[0.5, 1.0, 0.25]]


def test_a_bootstrap_has_the_interval_of_a_mean_and_strata_weigh_alike():
    x = np.random.default_rng(0).normal(3.0, 2.0, 200)
    found = bootstrap_mean(x)
    assert found.mean == pytest.approx(x.mean())
    assert (found.high - found.low) == pytest.approx(2 * 1.96 * x.std() / np.sqrt(200), rel=0.05)
    uneven = bootstrap_mean([1.0, 1.0, 1.0, 4.0], ["a", "a", "a", "b"])
    assert (uneven.mean, uneven.low, uneven.high, uneven.runs) == (2.5, 2.5, 2.5, 4)


def test_a_proportion_has_its_exact_interval():
    found = proportion(3, 20)
    assert found.share == pytest.approx(0.15)
    assert stats.binom.sf(2, 20, found.low) == pytest.approx(0.025)
    assert stats.binom.cdf(3, 20, found.high) == pytest.approx(0.025)
    assert stats.binom.cdf(3, 20, found.bound) == pytest.approx(0.05)


def pool(tasks=8, priors=3):
    """Rows of `choices` in which the chosen is better than the median by 0.1 and than a random one by 0.2, to 0.05."""
    rng = np.random.default_rng(0)
    return pd.DataFrame(
        [
            {"task": t, "prior": p, "seed": 0, "chosen": 1.0 + 0.05 * rng.standard_normal(), "median": 1.1,
             "random": 1.2, "best": 0.9, "rank": 2, "candidates": 5, "correlation": 0.5}
            for t in range(tasks) for p in range(priors)
        ]
    )  # fmt: skip


def test_what_a_choice_gains_is_told_over_tasks(monkeypatch):
    monkeypatch.setattr("infotraj.evaluation.pool_choice._DRAWS", 2000)
    table = pool()
    against = {row["against"]: row for row in overall(table, np.random.default_rng(0)).to_dict("records")}
    means = table.groupby("task")["chosen"].mean() - 1.1
    row = against["median"]
    assert row["difference"] == pytest.approx(means.mean())
    assert row["relative"] == pytest.approx(means.mean() / 1.1)
    half = stats.t.ppf(0.975, 7) * means.std() / np.sqrt(8)
    assert (row["low_t"], row["high_t"]) == pytest.approx((means.mean() - half, means.mean() + half))
    assert row["high"] - row["low"] == pytest.approx(2 * 1.96 * means.std(ddof=0) / np.sqrt(8), rel=0.1)
    assert row["low_both"] < row["low"]
    assert (row["tasks_better"], row["tasks"]) == (int((means < 0).sum()), 8)
    assert against["random"]["difference"] == pytest.approx(means.mean() - 0.1)
    told = by_task(table)
    assert told["below_median"].to_numpy() == pytest.approx(means.to_numpy())


def test_of_what_is_kept_the_candidate_of_least_cost_is_chosen():
    table = pd.DataFrame({"task": ["a"] * 3 + ["b"] * 2, "prior": "p", "seed": 0, "candidate": list("xyzuv"),
                          "cost": [1.0, 2.0, 3.0, 5.0, 4.0], "chosen": 0})  # fmt: skip
    found = choose_again(table, np.array([False, True, True, True, True]))
    assert found.loc[found["chosen"] == 1, "candidate"].tolist() == ["y", "v"]


def test_a_body_that_pushes_along_z_carries_its_acceleration_and_looks_where_it_is_told():
    rng = np.random.default_rng(0)
    acceleration, yaw = rng.normal(0.0, 3.0, (50, 3)), rng.uniform(-1.0, 1.0, 50)
    made = flat_attitude(acceleration, yaw)
    up = to_world(made, np.tile([0.0, 0.0, 1.0], (50, 1)))
    total = acceleration + np.array([0.0, 0.0, 9.81])
    np.testing.assert_allclose(np.cross(up, total), 0.0, atol=1e-9)
    assert (np.einsum("ni,ni->n", up, total) > 0).all()
    ahead = to_body(made, np.stack([-np.sin(yaw), np.cos(yaw), 0.0 * yaw], axis=1))
    np.testing.assert_allclose(ahead[:, 0], 0.0, atol=1e-9)


def test_set_points_make_a_reference_whose_derivatives_are_theirs():
    columns = {"t": T, "ref_px": np.sin(T), "ref_py": 0.0 * T, "ref_pz": 1.0 + 0.0 * T}
    yaw = 0.3 * T
    columns |= {"ref_qw": np.cos(yaw / 2), "ref_qx": 0.0 * T, "ref_qy": 0.0 * T, "ref_qz": np.sin(yaw / 2)}
    made = set_point_reference(Flight(pd.DataFrame(columns)))
    np.testing.assert_allclose(made.velocity[:, 0], np.cos(made.t), atol=0.01)
    np.testing.assert_allclose(made.acceleration[20:-20, 0], -np.sin(made.t[20:-20]), atol=0.01)
    assert np.median(made.rate[:, 2]) == pytest.approx(0.3, abs=0.03)
