"""Costs beside the run's: the prior that knows physics, the effects' columns, and what a choice was worth."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from infotraj.errors import InputError
from infotraj.experiment.common.config import Cost, ExperimentConfig, read
from infotraj.experiment.paper import references
from infotraj.experiment.paper.costs import LITERAL, OURS
from infotraj.experiment.paper.costs_summary import choices, of_costs, of_sizes, summarise
from infotraj.experiment.paper.effect_columns import effect_columns
from infotraj.experiment.paper.rollouts import as_flight
from infotraj.informative.linear_prior import LinearPrior, Rows, in_the_wrench
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle("config/vehicles/omav.yaml")


def some_rows(rng, n, m=3, k=5):
    return Rows(rng.standard_normal((n, m, k)), rng.standard_normal((n, 6)))


def test_without_a_small_process_it_is_bayesian_linear_regression():
    rng = np.random.default_rng(0)
    data, region = some_rows(rng, 8), some_rows(rng, 4)
    prior = LinearPrior(rest=1e-9, noise=0.2)
    flat = data.columns.reshape(-1, 5)
    covariance = np.linalg.inv(np.eye(5) + flat.T @ flat / 0.2**2)
    np.testing.assert_allclose(prior.weights(data), covariance, atol=1e-9)
    expected = np.einsum("rmk,kl,rml->rm", region.columns, covariance, region.columns)
    np.testing.assert_allclose(prior.variance(data, region), expected, atol=1e-9)


def test_without_columns_it_is_the_gaussian_process_of_one_lengthscale():
    rng = np.random.default_rng(1)
    data, region = some_rows(rng, 9, k=0), some_rows(rng, 4, k=0)
    found = LinearPrior(rest=0.7, lengthscale=1.3, noise=0.1).variance(data, region)

    def kernel(A, B):
        return 0.49 * np.exp(-0.5 * ((A[:, None] - B) ** 2).sum(-1) / 1.3**2)

    K = kernel(data.inputs, data.inputs) + 0.01 * np.eye(9)
    cross = kernel(data.inputs, region.inputs)
    expected = 0.49 - np.einsum("ab,ab->b", cross, np.linalg.solve(K, cross))
    np.testing.assert_allclose(found, np.repeat(expected[:, None], 3, axis=1), atol=1e-10)


def test_a_weak_actuator_and_a_steady_torque_are_told_apart_only_where_the_torque_moves():
    still = np.tile([0.0, 0, 0, -1.0, 0, 0], (40, 1))
    moving = still.copy()
    moving[:, 3] += np.linspace(-1.0, 1.0, 40)
    prior = LinearPrior(rest=0.01)
    slope = [prior.weights(in_the_wrench(u, 3.0, 0.3))[4, 4] for u in (still, moving)]
    assert slope[0] > 0.9
    assert slope[1] < 0.1


def test_columns_of_effects_are_those_of_a_hover_by_hand():
    """A hover: a steady torque turns about its own axis, a shifted centre of mass by the weight's moment."""
    task = references.named(ExperimentConfig(), "task")
    n = 200
    states = np.zeros((n, 13))
    states[:, 2], states[:, 3] = 1.0, 1.0
    commands = np.tile([0.0, 0, OMAV.gravity, 0, 0, 0], (n, 1))
    cut = type(task)(**{name: getattr(task, name)[:n] for name in task.__dataclass_fields__})
    names, columns = effect_columns(OMAV, as_flight(OMAV, cut, commands, states))
    late = columns[n // 2 :].mean(axis=0)
    size = np.abs(late[0, names.index("steady_torque 0")])
    np.testing.assert_allclose(late[1:, names.index("steady_torque 0")], 0.0, atol=1e-9)
    assert size * OMAV.inertia_matrix()[0, 0] == pytest.approx(0.1, rel=10.0)
    com = late[:, names.index("com_offset 1")]
    usual = 0.01
    assert abs(com[0]) == pytest.approx(usual * OMAV.mass * OMAV.gravity / OMAV.inertia_matrix()[0, 0], rel=0.5)
    assert abs(com[1]) < 1e-6
    assert not any(name.startswith(("gyro_bias", "rotor_lag")) for name in names)


def a_table(shift=0.0):
    """Two plants, three runs each, six candidates of known errors; the run's cost is right, the paper's the reverse."""
    flown, costs = [], []
    for plant in ("a", "b"):
        for seed in range(3):
            for k in (-1, *range(6)):
                for points in (40, 100):
                    error = 1.0 + shift if k < 0 else 1.0 + 0.1 * k
                    flown.append({"plant": plant, "seed": seed, "candidate": k, "points": points, "error": error})
            for k in range(6):
                costs += [
                    {"plant": plant, "seed": seed, "group": "g", "cost": name, "candidate": k, "value": value}
                    for name, value in ((OURS, 3.0 + k), (LITERAL, -float(k)))
                ]
    return pd.DataFrame(flown), pd.DataFrame(costs)


def test_what_a_choice_was_worth(tmp_path):
    found = choices(*a_table(shift=0.5))
    assert set(found["points"]) == {0, 40, 100}
    right = found[found["cost"] == OURS]
    assert right["chosen"].eq(right["best"]).all()
    assert right["rank"].to_numpy() == pytest.approx(1.0)
    wrong = found[found["cost"] == LITERAL]
    assert wrong["chosen"].to_numpy() == pytest.approx(1.5)
    assert wrong["rank"].to_numpy() == pytest.approx(-1.0)
    assert found["mean"].to_numpy() == pytest.approx(1.25)
    lines = of_costs(found).splitlines()
    assert lines[2].startswith(f"| {OURS} | +1.00")
    assert "| -20.0 +- 0.0 % |" in lines[2]
    assert "| +20.0 +- 0.0 % |" in lines[3]
    assert lines[-1].startswith("| the task's own flight |  | +20.0")
    assert lines[2].endswith("|  |")
    flown, costs = a_table()
    own = costs[costs["candidate"] == 0].assign(candidate=-1, value=lambda rows: rows["value"] - 1.0)
    again = choices(flown, pd.concat([costs, own])).set_index("cost")["task_first"]
    assert again[OURS].eq(1.0).all()
    assert again[LITERAL].eq(0.0).all()
    first = of_sizes(found).splitlines()[2]
    assert "| -0.2500 [-0.2500, -0.2500] |" in first
    assert "| 100 % |" in first
    assert "| 33.3 [33.3, 33.3] | 16.7 [16.7, 16.7] | 33.3 [33.3, 33.3] |" in first
    flown, costs = a_table()
    flown.to_csv(tmp_path / "h.csv", index=False)
    costs.to_csv(tmp_path / "c.csv", index=False)
    outputs = {"table": tmp_path / "t.csv", "markdown": tmp_path / "t.md"}
    summarise(hindsight=[tmp_path / "h.csv"], costs=[tmp_path / "c.csv"], **outputs)
    assert "6 candidates a run" in outputs["markdown"].read_text()


@pytest.mark.parametrize("name", ["development", "unseen"])
def test_the_committed_studies_are_configurations_of_plants_that_are_there(name):
    config = read(f"config/studies/hindsight_{name}.yaml")
    assert config.selection.cost == Cost(), "what is reported is what the run uses"
    assert all(Path(f"config/plants/{plant}.yaml").exists() for plant in config.plants)


def test_a_run_without_costs_is_one_clear_line():
    flown, costs = a_table()
    with pytest.raises(InputError, match="b, seed 2: no costs"):
        choices(flown, costs[(costs["plant"] != "b") | (costs["seed"] != 2)])
