"""Tasks and deviations: consistent derivatives, the paper's sizes, the vehicle's limits."""

from pathlib import Path

import numpy as np
import pytest

from infotraj import rotations
from infotraj.dynamics.allocation import Allocation
from infotraj.trajectories.deviations import Deviation, DeviationSpace, demand, deviate, within_limits
from infotraj.trajectories.flatness import thrust_attitude
from infotraj.trajectories.standard import Extent, standard
from infotraj.trajectories.tasks import figure_eight, phase, pitch_task
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle(Path(__file__).parents[2] / "config" / "vehicles" / "omav.yaml")
SPACE = DeviationSpace(5.0, 0.1, 2.0, np.radians(30))


def integrated_attitude(reference):
    """The attitude that the rates lead to, midpoint by midpoint."""
    middle = 0.5 * (reference.rate[1:] + reference.rate[:-1])
    q = [reference.attitude[0]]
    for rate in middle:
        q.append(rotations.multiply(q[-1], rotations.exp(reference.dt * rate)))
    return np.array(q)


@pytest.mark.parametrize("reference", [figure_eight(0.45, 9, 1, 0.01), pitch_task(1.0, 1.0, 1, 0.01)])
def test_derivatives_belong_to_the_attitude(reference):
    error = rotations.angle_between(integrated_attitude(reference), reference.attitude)
    assert error.max() < 1e-4
    slope = np.gradient(reference.rate, reference.dt, axis=0)
    np.testing.assert_allclose(slope[2:-2], reference.angular_acceleration[2:-2], atol=2e-3)


def test_tasks_have_the_papers_amplitudes_and_rest_at_both_ends():
    eight = figure_eight(np.radians(26), 9, 2, 0.01)
    roll, pitch, _ = np.degrees(rotations.to_euler(eight.attitude)).T
    assert np.abs(roll).max() == pytest.approx(26, abs=0.01)
    assert np.abs(pitch).max() == pytest.approx(26, abs=0.01)
    pitching = pitch_task(np.radians(60), 1.0, 3, 0.01)
    assert np.degrees(np.abs(rotations.to_euler(pitching.attitude)[:, 1])).max() == pytest.approx(60, abs=0.01)
    assert np.abs(pitching.angular_acceleration[:, 1]).max() == pytest.approx(1.0, rel=0.1)
    for reference in (eight, pitching):
        for end in (0, -1):
            np.testing.assert_allclose(reference.rate[end], 0.0, atol=1e-5)
            np.testing.assert_allclose(reference.attitude[end], [1, 0, 0, 0], atol=1e-9)


def test_phase_is_whole_cycles_and_never_turns_back():
    t = np.linspace(0, 20, 2001)
    angle = phase(t, 3, 2.0)
    assert angle[0] == 0.0
    assert angle[-1] == pytest.approx(6 * np.pi)
    assert (np.diff(angle) >= 0).all()


def test_deviation_has_the_sampled_amplitude_on_the_angular_acceleration():
    deviation = Deviation(np.array([[2.0, 0], [0, 0], [0, 0]]), np.full((3, 2), 0.5))
    t = np.arange(0, 20, 0.01)
    acceleration = np.gradient(np.gradient(deviation.angle(t)[:, 0], 0.01), 0.01)
    assert np.abs(acceleration[500:1500]).max() == pytest.approx(2.0, rel=1e-2)
    np.testing.assert_allclose(acceleration[500:1500], 2.0 * np.sin(np.pi * t)[500:1500], atol=0.02)


def test_candidates_stay_within_the_limits_and_the_space():
    task, allocation, rng = figure_eight(np.radians(26), 9, 1, 0.01), Allocation(OMAV), np.random.default_rng(3)
    strong = DeviationSpace(60.0, 0.1, 2.0, np.radians(60))
    for _ in range(5):
        raw = strong.sample(rng)
        deviation = within_limits(task, raw, allocation)
        speed, rate = demand(deviate(task, deviation), allocation)
        assert speed <= 0.9
        assert rate <= 0.6
        assert (raw.frequency <= 2.0).all()
        assert np.abs(raw.angle(task.t)).max() <= np.radians(60) + 1e-9
    assert deviation.amplitude[0, 0] / raw.amplitude[0, 0] < 1.0  # such deviations had to shrink


def test_no_deviation_that_is_sampled_jerks_by_more_than_is_allowed():
    """A sine of amplitude c on the acceleration has a jerk of c w; the largest comes near what is allowed."""
    space, rng = DeviationSpace(5.0, 0.1, 2.0, np.radians(60), max_jerk=3.0), np.random.default_rng(0)
    drawn = [space.sample(rng) for _ in range(200)]
    jerk = np.array([np.sum(np.abs(d.amplitude) * 2 * np.pi * d.frequency, axis=1) for d in drawn])
    assert 2.5 < jerk.max() <= 3.0


def test_a_deviation_of_nothing_is_the_task():
    task = figure_eight(np.radians(26), 9, 1, 0.01)
    same = deviate(task, Deviation(np.zeros((3, 2)), np.ones((3, 2))))
    np.testing.assert_allclose(same.angular_acceleration, task.angular_acceleration, atol=1e-6)


@pytest.mark.parametrize("kind", ["fast_circle", "fast_lemniscate"])
def test_a_fast_path_is_as_fast_as_is_said_and_no_faster(kind):
    """At 0.9 to 1 of `speed`, but for the plane that leans by at most 0.15 rad; it begins and ends at rest."""
    for seed in range(5):
        made = standard(kind, 40.0, Extent(size=6.0, speed=8.0, tilt=0.0), np.random.default_rng(seed))
        speed = np.linalg.norm(np.gradient(made.position, made.t, axis=0), axis=1)
        assert 0.9 * 8.0 <= 1.002 * speed.max() <= 1.02 * 8.0
        assert speed[[0, -1]] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("yaw", [-3.0, -1.6, 0.0, 0.4, 2.2, 3.1])
def test_a_body_leans_to_its_force_and_looks_where_it_is_told_to_all_around(yaw):
    """Body z lies along the force, body y is level in the heading's frame, body x looks ahead: backwards, too."""
    force = np.array([2.0, -3.0, 9.0])
    turned = rotations.matrix(thrust_attitude(force, yaw))
    ahead = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    np.testing.assert_allclose(turned[:, 2], force / np.linalg.norm(force), atol=1e-12)
    assert turned[:, 1] @ ahead == pytest.approx(0.0, abs=1e-12)
    assert turned[:, 0] @ ahead > 0.5
