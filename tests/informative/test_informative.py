"""Simulation, region and cost: physics of the rollouts, the uniform law of the region, variance that shrinks."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import kstest

from infotraj import rotations
from infotraj.control.gains import Gains
from infotraj.experiment.common.config import load
from infotraj.experiment.paper import choosing
from infotraj.informative import region
from infotraj.informative.cost import Scorer, of_one_lengthscale
from infotraj.informative.simulation import EstimateNoise, Simulator, _advance, _observe
from infotraj.residual.draws import MarginalDraws, PosteriorDraws
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.subset import k_medoids
from infotraj.trajectories.reference import read_reference
from infotraj.trajectories.tasks import figure_eight
from infotraj.vehicle import load_vehicle

CONFIG = Path(__file__).parents[2] / "config"
OMAV = load_vehicle(CONFIG / "vehicles" / "omav.yaml")
TASK = figure_eight(np.radians(26), 6, 1, 0.01)


def first_rows(X, count, rng):
    return np.arange(count)


def a_process(noise=0.01, bias=(0.0, 0.0, 0.0)):
    rng = np.random.default_rng(0)
    X = rng.uniform(-1, 1, (20, 6)) * [4, 4, 1, 1, 1, 1] + [0, 0, 9, 0, 0, 0]
    Y = np.stack([0.3 * X[:, 0], 0.2 * X[:, 1], 0.05 * X[:, 0] * X[:, 1]], axis=1) + bias
    return GaussianProcess(X, Y, np.full((3, 6), 10.0), np.full(3, 4.0), np.full(3, noise), Y.mean(axis=0))


def test_one_rigid_body_step_is_of_second_order():
    inertia = OMAV.inertia_matrix()
    scale = np.concatenate([np.full(3, OMAV.mass), np.diag(inertia)])
    start = np.concatenate([[0, 0, 1], rotations.exp([0.2, -0.4, 0.1]), [0.3, 0, -0.2], [1.5, -0.7, 0.9]])
    command, residual = np.array([1.0, -2.0, 9.0, 2.0, -1.0, 0.5]), np.array([0.3, 0.1, -0.2])

    def end(steps):
        state = start.copy()
        for _ in range(steps):
            _advance(state, command, residual, 9.81, inertia, np.linalg.inv(inertia), scale, 0.4 / steps)
        return state

    best = end(12_800)
    errors = [np.abs(end(n) - best).max() for n in (20, 40, 80)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 1.8).all()
    assert errors[1] < 1e-3  # 10 ms steps over 0.4 s


def test_with_the_right_model_the_simulated_task_needs_no_feedback():
    """If g' is mu itself (no variance left), commands are the task's feedforward minus mu."""
    process = a_process(noise=1e-6)
    exact = PosteriorDraws.sample(process, np.random.default_rng(1), 1)
    mean_only = PosteriorDraws(
        exact.frequencies,
        exact.phases,
        np.zeros_like(exact.amplitudes),
        process.alpha[None],
        exact.points,
        exact.inverse_lengthscales_squared,
        exact.signal_variance,
        exact.constant,
        exact.slopes,
    )
    commands = Simulator(OMAV, process).commands([TASK], mean_only, np.random.default_rng(0))[0, 0]
    inertia = OMAV.inertia_matrix()
    wanted = (TASK.angular_acceleration @ inertia + np.cross(TASK.rate, TASK.rate @ inertia)) / np.diag(inertia)
    np.testing.assert_allclose(commands[:, 3:] + process.mean(commands), wanted, atol=0.05)


def test_a_draw_is_met_by_feedback_and_threads_do_not_change_the_numbers():
    process, rng = a_process(noise=0.5), np.random.default_rng(1)
    draws = PosteriorDraws.sample(process, rng, 3)
    noise = EstimateNoise(0.001, 0.002, 0.01, 0.01)
    one = Simulator(OMAV, process, Gains(), noise, 1).commands([TASK, TASK], draws, np.random.default_rng(5))
    two = Simulator(OMAV, process, Gains(), noise, 2).commands([TASK, TASK], draws, np.random.default_rng(5))
    np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(one[0], one[1])  # common random numbers
    assert np.abs(one[0, 0] - one[0, 1]).max() > 0.01  # draws differ
    assert np.isfinite(one).all()


def box_region(visited, radius, proposals, rng):
    """Eq. 15 word for word: those of uniform samples of the box around the visited points within a radius of them."""
    points = rng.uniform(visited.min(axis=0) - radius, visited.max(axis=0) + radius, (proposals, visited.shape[1]))
    return points[np.linalg.norm(points[:, None] - visited, axis=2).min(axis=1) <= radius]


def test_region_is_uniform_in_the_union_of_balls():
    """Two overlapping balls: the share of points on one side of the middle plane is one half, and the radial law of
    a single ball is r^d."""
    rng = np.random.default_rng(2)
    centre = np.zeros((1, 4))
    points = region.uniform_region(centre, 2.0, 4000, rng)
    radius = np.linalg.norm(points, axis=1) / 2.0
    assert kstest(radius**4, "uniform").pvalue > 1e-3
    pair = np.array([[0.0, 0, 0, 0], [1.0, 0, 0, 0]])
    points = region.uniform_region(pair, 1.0, 4000, rng)
    box = box_region(pair, 1.0, 60_000, rng)
    assert kstest(points[:, 0], box[:, 0]).pvalue > 1e-3
    nearest = np.linalg.norm(points[:, None] - pair, axis=2).min(axis=1)
    assert nearest.max() <= 1.0 + 1e-12


def test_epsilon_is_the_shift_of_the_command_that_the_draw_asks_for():
    process = a_process(noise=0.2)
    draws = PosteriorDraws.sample(process, np.random.default_rng(3), 4)
    commands = np.repeat(process.X[None], 4, axis=0)
    radius = region.epsilon(process, draws, commands)
    first_order = np.linalg.norm(draws(commands) - process.mean(process.X), axis=-1).mean()
    assert radius == pytest.approx(first_order, rel=0.3)


def test_cost_falls_with_points_and_is_the_conditioned_variance():
    process, rng = a_process(), np.random.default_rng(4)
    flights = rng.uniform(-1, 1, (3, 2, 400, 6)) * [4, 4, 1, 1, 1, 1] + [0, 0, 9, 0, 0, 0]
    where = rng.uniform(-1, 1, (200, 6)) * [4, 4, 1, 1, 1, 1] + [0, 0, 9, 0, 0, 0]
    few = Scorer(process, where, 5, k_medoids).costs(flights, np.random.default_rng(0))
    many = Scorer(process, where, 60, k_medoids, threads=2).costs(flights, np.random.default_rng(0))
    assert few.shape == (3, 2)
    assert (many < few).all()
    assert (few < process.variance(where).sum() / 200).all()
    own = np.random.default_rng(0).spawn(6)[0]
    added = flights[0, 0][k_medoids(flights[0, 0], 5, own)]
    direct = process.condition(added, np.zeros((5, 3))).variance(where).sum() / 200
    assert few[0, 0] == pytest.approx(direct, rel=1e-8)


def test_of_a_long_flight_every_second_row_is_offered_to_the_subset():
    process, rng = a_process(), np.random.default_rng(6)
    flights = rng.uniform(-1, 1, (1, 1, 800, 6)) * [4, 4, 1, 1, 1, 1] + [0, 0, 9, 0, 0, 0]
    scorer = Scorer(process, flights[0, 0, :50], 5, k_medoids)
    costs = [scorer.costs(f, np.random.default_rng(0)).item() for f in (flights, flights[:, :, ::2])]
    assert costs[0] == costs[1]


def test_a_rollout_keeps_the_states_that_its_commands_belong_to():
    process = a_process()
    draws = PosteriorDraws.sample(process, np.random.default_rng(1), 2)
    simulator = Simulator(OMAV, process)
    commands, moved = simulator.rollout(TASK, draws, np.random.default_rng(0))
    np.testing.assert_array_equal(commands, simulator.commands([TASK], draws, np.random.default_rng(0))[0])
    np.testing.assert_array_equal(moved[:, 0], np.repeat([moved[0, 0]], 2, axis=0))  # both start on the task
    np.testing.assert_allclose(moved[0, 0, :3], TASK.position[0])
    assert rotations.angle_between(moved[:, :, 3:7], TASK.attitude).max() < 0.5
    slope = np.gradient(moved[0, :, 10], TASK.dt)[5:-5]
    achieved = (commands[0] + np.concatenate([np.zeros((len(TASK.t), 3)), draws(commands)[0]], axis=1))[5:-5, 3]
    assert np.abs(slope - achieved).mean() < 0.1 * np.abs(achieved).mean() + 0.05


def test_fresh_marginal_draws_shake_the_commands_more_than_one_consistent_function():
    """White residuals average out over a flight, so the mean command keeps closer to that of mu alone, while neighbours
    in time differ more: the two readings of eq. 12."""
    process = a_process(noise=0.5)
    simulator = Simulator(OMAV, process)
    one = simulator.commands(
        [TASK], PosteriorDraws.sample(process, np.random.default_rng(1), 20), np.random.default_rng(0)
    )
    fresh = simulator.commands([TASK], MarginalDraws(process, np.random.default_rng(1), 20), np.random.default_rng(0))

    def roughness(commands):
        return np.abs(np.diff(commands[0, :, 50:, 3:], axis=1)).mean()

    assert roughness(fresh) > 1.1 * roughness(one)
    assert fresh[0].mean(axis=1).std(axis=0)[3:].sum() < one[0].mean(axis=1).std(axis=0)[3:].sum()


def test_the_fixed_kernel_sees_every_input_alike_and_the_fitted_one_does_not():
    """A flight that moved one input only: the fit may call the others irrelevant, one lengthscale may not."""
    rng = np.random.default_rng(7)
    X = np.zeros((20, 6))
    X[:, 0] = rng.uniform(-3, 3, 20)
    long = np.array([[1.0, 100, 100, 100, 100, 100]])
    fitted = GaussianProcess(X, np.zeros((20, 1)), long, np.ones(1), np.full(1, 0.01), np.zeros(1))
    fixed = of_one_lengthscale(fitted, 1.0, 0.1)
    assert fixed.m == 1
    assert fixed.noise_variance == pytest.approx(0.01)
    where = np.zeros((50, 6))
    where[:, 3] = np.linspace(-3, 3, 50)
    np.testing.assert_allclose(fixed.variance(where).ravel(), 1 - np.exp(-(where[:, 3] ** 2)), atol=0.02)
    assert fitted.variance(where).max() < 0.01
    along, across = np.zeros((1, 1, 40, 6)), np.zeros((1, 1, 40, 6))
    along[..., 0], across[..., 3] = np.linspace(-4, 4, 40), np.linspace(-3, 3, 40)
    scorer = Scorer(fixed, where, 40, first_rows)
    costs = [scorer.costs(flight, np.random.default_rng(0)).item() for flight in (along, across)]
    assert costs[1] < 0.1 * costs[0], "it is the other input that the region needs"


def test_chance_chooses_among_the_same_candidates_and_both_costs_score_the_same_flights(tmp_path):
    selection = {"candidates": 3, "draws": 2, "task_draws": 3, "region_points": 60}
    config = load({"vehicle": str(CONFIG / "vehicles" / "omav.yaml"), "selection": selection})
    TASK.write(tmp_path / "task.csv")
    a_process(noise=0.2).save(tmp_path / "prior.npz")
    inputs = {"task": tmp_path / "task.csv", "model": tmp_path / "prior.npz"}
    candidates = choosing.candidates_of(config, "omav_a", 0, 1, TASK)
    tables, regions = {}, {}
    for source in ("informative", "paper"):
        files = {k: tmp_path / f"{k}_{source}" for k in ("reference", "costs")}
        files["region"] = tmp_path / f"region_{source}.npz"
        choosing.choose(config, "omav_a", 0, 1, source, **inputs, **files)
        tables[source], regions[source] = pd.read_csv(files["costs"]), np.load(files["region"])
        chosen = tables[source]["chosen"].to_numpy().argmax()
        assert chosen == tables[source]["cost"][:3].argmin()
        np.testing.assert_allclose(read_reference(files["reference"]).rate, candidates[chosen].rate, atol=1e-8)
    assert np.isnan(regions["informative"]["epsilon"])
    assert regions["paper"]["epsilon"] > 0
    assert len(regions["paper"]["region"]) == 60
    chosen_by_chance = set()
    for seed in range(8):
        out = tmp_path / f"random_{seed}.csv"
        choosing.choose_random(config, "omav_a", seed, 1, task=inputs["task"], reference=out)
        own = choosing.candidates_of(config, "omav_a", seed, 1, TASK)
        distance = [np.abs(read_reference(out).rate - candidate.rate).max() for candidate in own]
        assert min(distance) < 1e-8
        chosen_by_chance.add(int(np.argmin(distance)))
    assert len(chosen_by_chance) > 1


def test_each_part_of_the_estimate_has_its_own_noise():
    state, estimate = np.zeros(13), np.empty(13)
    state[3] = 1.0
    noise = np.arange(1.0, 13.0, dtype=np.float32)
    noise[3:6] = 0.0
    _observe(state, noise, estimate)
    np.testing.assert_array_equal(estimate, [1, 2, 3, 1, 0, 0, 0, 7, 8, 9, 10, 11, 12])
