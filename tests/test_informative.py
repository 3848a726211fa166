"""Simulation, region and cost: physics of the rollouts, the uniform law of the region, variance that shrinks."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import kstest

from infotraj import rotations
from infotraj.control.gains import Gains
from infotraj.informative import region
from infotraj.informative.cost import Scorer
from infotraj.informative.simulation import EstimateNoise, Simulator, _advance
from infotraj.residual.draws import MarginalDraws, PosteriorDraws
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.subset import k_medoids
from infotraj.trajectories.tasks import figure_eight
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle(Path(__file__).parents[1] / "config" / "vehicles" / "omav.yaml")
TASK = figure_eight(np.radians(26), 6, 1, 0.01)


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
        exact.prior_mean,
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
    box = region.box_region(pair, 1.0, 60_000, rng)
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
    few = Scorer((process,), where, 5).costs(flights, np.random.default_rng(0))
    many = Scorer((process,), where, 60, threads=2).costs(flights, np.random.default_rng(0))
    assert few.shape == (3, 2)
    assert (many < few).all()
    assert (few < process.variance(where).sum() / 200).all()
    own = np.random.default_rng(0).spawn(6)[0]
    added = flights[0, 0][k_medoids(flights[0, 0], 5, own)]
    direct = process.condition(added, np.zeros((5, 3))).variance(where).sum() / 200
    assert few[0, 0] == pytest.approx(direct, rel=1e-8)


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


def test_a_shaken_flight_counts_less_and_nothing_changes_without_a_response_time():
    """The same inputs in another order: only their rate differs, so only the rate's noise can tell them apart."""
    process, rng = a_process(), np.random.default_rng(6)
    calm = np.sort(rng.uniform(-4, 4, (1, 1, 400, 6)), axis=2) + np.array([0, 0, 9, 0, 0, 0])
    flights = np.concatenate([calm, calm[:, :, rng.permutation(400)]])
    where = calm[0, 0, ::4]
    plain = Scorer((process,), where, 400).costs(flights, np.random.default_rng(0))[:, 0]
    aware = Scorer((process,), where, 400, response_time=0.02, period=0.05).costs(flights, np.random.default_rng(0))[
        :, 0
    ]
    assert plain[1] == pytest.approx(plain[0], rel=1e-6)
    assert aware[0] > plain[0]
    assert aware[1] > 1.5 * aware[0]
    rate = np.gradient(flights[:, 0, :, 3:], 0.05, axis=1)
    noise = 0.02**2 * (rate**2).sum(axis=-1).mean(axis=-1)
    heavy = GaussianProcess(
        process.X, process.Y, process.lengthscales, process.signal_variance, process.noise_variance, process.prior_mean
    )
    K = [heavy.covariance(np.concatenate([flights[1, 0], where]))[o] for o in range(3)]
    left = 0.0
    for o in range(3):
        S = K[o][:400, :400] + (process.noise_variance[o] + noise[1]) * np.eye(400)
        left += np.trace(K[o][400:, 400:] - K[o][400:, :400] @ np.linalg.solve(S, K[o][:400, 400:]))
    assert aware[1] == pytest.approx(left / len(where), rel=1e-6)
