"""The state estimator alone, on motions whose answer is known."""

import numpy as np
import pytest

from infotraj import rotations
from infotraj.robots.plant.estimator import Estimator, steady_gains
from infotraj.robots.plant.sensors import Noise, turned

G = 9.81
T = 0.005


def motion(t):
    """A smooth motion: position, attitude, velocity, rate (body), specific force (body) at times t (n,)."""
    angle = np.stack([0.4 * np.sin(2 * t), 0.3 * np.sin(3 * t), 0 * t], axis=-1)
    q = rotations.exp(angle)
    small = 1e-5
    after = rotations.exp(np.stack([0.4 * np.sin(2 * (t + small)), 0.3 * np.sin(3 * (t + small)), 0 * t], axis=-1))
    rate = rotations.log(rotations.multiply(rotations.conjugate(q), after)) / small
    position = np.stack([np.sin(t), 0.5 * np.cos(2 * t), 0.2 * np.sin(t)], axis=-1)
    velocity = np.stack([np.cos(t), -np.sin(2 * t), 0.2 * np.cos(t)], axis=-1)
    acceleration = np.stack([-np.sin(t), -2 * np.cos(2 * t), -0.2 * np.sin(t)], axis=-1)
    return position, q, velocity, rate, rotations.to_body(q, acceleration + np.array([0, 0, G]))


def run(noise, rng, duration=6.0, delay=0.010, start_error=0.0):
    """Estimates (n, 13) beside the true motion; poses arrive after the delay."""
    n = round(duration / T)
    t = np.arange(n) * T
    position, attitude, velocity, rate, force = motion(t)
    gyro_noise, force_noise = noise.imu(rng, n)
    place_noise, turn_noise = noise.mocap(rng, n)
    places, turns = position + place_noise, rotations.multiply(attitude, rotations.exp(turn_noise))
    estimator = Estimator(noise if noise.rate else Noise(), G, delay)
    estimator.start(places[0] + start_error, turns[0])
    found = np.empty((n, 13))
    for k in range(n):
        estimator.integrate(rate[k] + gyro_noise[k], force[k] + force_noise[k])
        taken = k - estimator.delay_rows
        if taken >= 0 and taken % 2 == 0:
            estimator.correct(places[taken], turns[taken])
        e = estimator.estimate()
        found[k] = np.concatenate([e.position, e.attitude, e.velocity, e.rate])
    return t, found, (position, attitude, velocity, rate)


@pytest.mark.parametrize("delay", [0.0, 0.010, 0.030])
def test_perfect_sensors_are_followed_whatever_the_delay(delay):
    quiet = Noise(0.0, 0.0, 0.0, 0.0)
    t, found, (position, attitude, velocity, _) = run(quiet, np.random.default_rng(0), delay=delay)
    late = t > 4.0  # the estimator starts at rest and must find the velocity first
    assert np.abs(found[late, :3] - position[late]).max() < 3e-4
    assert rotations.angle_between(found[late, 3:7], attitude[late]).max() < 3e-4
    assert np.abs(found[late, 7:10] - velocity[late]).max() < 3e-3


def test_it_is_better_than_its_sensors():
    noise = Noise()
    t, found, (position, attitude, velocity, rate) = run(noise, np.random.default_rng(1))
    late = t > 3.0
    assert (found[late, :3] - position[late]).std() < 0.6 * noise.position
    turn = rotations.log(rotations.multiply(rotations.conjugate(attitude[late]), found[late, 3:7]))
    assert turn.std() < 0.6 * noise.attitude
    assert (found[late, 7:10] - velocity[late]).std() < 0.01
    before = np.vstack([rate[:1], rate[:-1]])
    assert (found[late, 10:] - 0.5 * (rate + before)[late]).std() == pytest.approx(noise.rate / np.sqrt(2), rel=0.1)


def test_a_wrong_start_is_forgotten():
    t, found, (position, *_) = run(Noise(), np.random.default_rng(2), start_error=0.3)
    away = np.linalg.norm(found[:, :3] - position, axis=1)
    assert away[0] > 0.4
    assert away[t > 4.0].max() < 5e-3


def test_gains_trust_the_poses_less_when_they_are_noisier():
    good, bad = steady_gains(Noise(position=1e-4, attitude=1e-4), 1.0), steady_gains(Noise(), 1.0)
    assert (good > bad).all()
    assert ((bad > 0) & (bad[[0]] < 1)).all()


def test_turned_is_the_library_product():
    rng = np.random.default_rng(3)
    for size in (0.0, 1e-12, 1e-3, 1.0, 3.0):
        q, v, out = rotations.normalize(rng.standard_normal(4)), size * rng.standard_normal(3), np.empty(4)
        turned(q, v, out)
        np.testing.assert_allclose(out, rotations.multiply(q, rotations.exp(v)), atol=1e-12)


def test_the_description_states_filter_and_delay():
    text = Estimator(Noise(), G, 0.020).description
    assert "error-state observer" in text
    assert "20 ms" in text
    assert "\n" not in text
