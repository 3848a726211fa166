"""A rigid body whose origin is not its centre of mass, loads, and channels between samples, by hand."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from infotraj.effects.along import Actuation
from infotraj.effects.base import Load
from infotraj.effects.laws import BodyLaw
from infotraj.flight import Flight
from infotraj.models import body
from infotraj.models.interpolation import interpolate
from infotraj.models.kinematics import _gauss, _push, _turn, _turn_of
from infotraj.models.origin_path import _across_thrust, _constant_error, _slope, origin_path
from infotraj.models.recorded import Samples, _battery, recorded
from infotraj.models.rotor_wrench import RotorWrench, forces_at_rotors
from infotraj.rotations import exp, matrix, multiply
from infotraj.vehicle import load_vehicle

VEHICLES = Path(__file__).parents[2] / "config/vehicles"
QUAD, OMAV = (load_vehicle(VEHICLES / f"{n}.yaml") for n in ("quadrotor", "omav"))
RNG = np.random.default_rng(0)
INERTIA = np.array([[0.02, 0.001, 0.0], [0.001, 0.03, -0.002], [0.0, -0.002, 0.04]])
PLACE = np.array([0.02, -0.03, 0.05])
LAW = BodyLaw(1.5, INERTIA, PLACE)


def test_a_body_moves_as_newton_and_euler_say_about_its_centre_of_mass():
    """Force at the origin and torque about it: the centre of mass accelerates by F / m, its momentum by the moment."""
    force, torque, rate = RNG.standard_normal((3, 5, 3))
    angular = body.angular_acceleration(LAW, force, torque, rate)
    specific = body.specific_force(LAW, force, rate, angular)
    for f, t, w, a, s in zip(force, torque, rate, angular, specific, strict=True):
        at_center = s + np.cross(a, PLACE) + np.cross(w, np.cross(w, PLACE))
        np.testing.assert_allclose(at_center, f / 1.5, atol=1e-12)
        np.testing.assert_allclose(INERTIA @ a + np.cross(w, INERTIA @ w), t - np.cross(PLACE, f), atol=1e-12)
        np.testing.assert_allclose(body.lever(PLACE, w[None], a[None])[0], at_center - s, atol=1e-12)


def test_a_force_of_one_newton_makes_what_the_body_makes_of_it():
    direction = RNG.standard_normal((4, 3))
    none = np.zeros((4, 3))
    specific, angular = body.response_to_force(LAW, direction)
    expected = body.angular_acceleration(LAW, direction, none, none)
    np.testing.assert_allclose(angular, expected, atol=1e-12)
    np.testing.assert_allclose(specific, body.specific_force(LAW, direction, none, expected), atol=1e-12)


@pytest.mark.parametrize("law", [LAW, BodyLaw(1.5, INERTIA, np.zeros(3))])
def test_loads_pull_so_that_each_moves_with_the_body(law):
    """The pull of each is its mass times its own swing less the force along its cable, of the body that all pull at."""
    direction = RNG.standard_normal((2, 6, 3))
    direction /= np.linalg.norm(direction, axis=2, keepdims=True)
    loads = [Load(d, RNG.standard_normal(6), mass) for d, mass in zip(direction, (0.3, 0.7), strict=True)]
    free = RNG.standard_normal((6, 3))
    pulls = body.pulls(law, loads, free)
    whole = free + sum(
        p[:, None] * body.response_to_force(law, load.direction)[0] for p, load in zip(pulls, loads, strict=True)
    )
    for p, load in zip(pulls, loads, strict=True):
        along = np.einsum("ni,ni->n", load.direction, whole)
        np.testing.assert_allclose(p, load.mass * (load.swing - along), atol=1e-12)


def test_a_channel_is_a_cubic_between_its_samples_and_a_line_across_a_gap():
    t = np.concatenate([0.1 * np.arange(20), 3.0 + 0.1 * np.arange(20)])
    cubic = np.stack([t**3 - 2 * t, 0.5 * t**2], axis=1)
    at = np.array([-1.0, 0.03, 0.05, 0.77, 1.4, 3.47, 4.85, 9.0])
    expected = np.stack([at**3 - 2 * at, 0.5 * at**2], axis=1)
    expected[[0, -1]] = cubic[[0, -1]]
    np.testing.assert_allclose(interpolate(t, cubic, at), expected, atol=1e-9)
    (inside,) = interpolate(t, cubic, [2.2])
    share = (2.2 - t[19]) / (3.0 - t[19])
    np.testing.assert_allclose(inside, (1 - share) * cubic[19] + share * cubic[20])
    # Steps of three usual ones are none, longer ones are a gap.
    uneven = np.array([0.0, 0.1, 0.2, 0.3, 0.6, 0.7, 0.8, 0.9])
    np.testing.assert_allclose(interpolate(uneven, (uneven**3)[:, None], [0.45])[0, 0], 0.45**3, atol=1e-9)


def turning(t):
    """An attitude that turns about an axis which moves itself, and its body rate, to the step of a difference."""
    first, second = np.outer(np.sin(1.3 * t), [0.9, 0.2, -0.3]), np.outer(t, [0.1, -0.8, 0.5])
    return multiply(exp(first), exp(second))


def test_a_step_turns_by_what_rates_at_gauss_points_say_to_fourth_order():
    """Halving the step makes the difference sixteen times smaller: rates that turn do not commute."""
    left = []
    for step in (0.1, 0.05):
        t = np.arange(0.0, 2.0, step)
        fine = 1e-5
        q, after = matrix(turning(t)), matrix(turning(t + fine))
        skew = np.einsum("nji,njk->nik", q, (after - matrix(turning(t - fine))) / (2 * fine))
        rate = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
        rates = Samples(t, rate)
        made = _turn_of(t, *(rates.at(x) for x in _gauss(t)))[5:-6]
        left.append(np.abs(made - _turn(t, Samples(t, turning(t)))[5:-6]).max())
    assert left[0] < 2e-4
    assert left[1] < left[0] / 10.0


def test_a_push_is_the_mean_acceleration_of_a_step():
    t = np.array([0.0, 0.1, 0.3, 0.4, 0.5])
    velocity = Samples(t, np.outer(t**2, [1.0, 0.0, -2.0]))
    np.testing.assert_allclose(_push(t, velocity)[:-1], np.outer(t[1:] + t[:-1], [1.0, 0.0, -2.0]), atol=1e-9)
    assert np.isnan(_push(t, velocity)[-1]).all()


def flown(noise=0.0):
    """A body that sways ahead and turns about z: its path, attitude, velocity and specific force."""
    t = 10.0 + np.arange(0.0, 6.0, 0.01)
    turn = exp(np.outer(t - 10.0, [0.0, 0.0, 0.4]))
    velocity = np.stack([np.sin(t), 0.5 * np.cos(0.7 * t), 0.2 * np.sin(1.4 * t)], axis=1)
    acceleration = np.stack([np.cos(t), -0.35 * np.sin(0.7 * t), 0.28 * np.cos(1.4 * t)], axis=1)
    world = acceleration + np.array([0.0, 0.0, 9.81])
    force = np.einsum("nji,nj->ni", matrix(turn), world)
    return t, turn, velocity, world, force + noise * RNG.standard_normal(force.shape)


def test_a_constant_error_of_a_measured_force_is_found_by_the_velocity():
    t, turn, velocity, _, force = flown()
    off = np.array([0.3, -0.2, 0.1])
    found = _constant_error(t, matrix(turn), force + off, Samples(t, velocity), 9.81)
    np.testing.assert_allclose(found, off, atol=1e-3)
    few = Samples(t[:2], velocity[:2])
    assert _constant_error(t, matrix(turn), force, few, 9.81).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("measured", [True, False])
def test_the_path_of_the_origin_is_its_specific_force_in_the_world_since_the_start(measured):
    t, turn, velocity, world, force = flown()
    attitude, moved = Samples(t, turn), Samples(t, velocity)
    felt = Samples(t, force + np.array([0.3, 0.0, -0.2])) if measured else None
    made = origin_path(QUAD, SimpleNamespace(attitude=attitude, velocity=moved), felt, 10.0)
    assert made.start == pytest.approx(0.0)
    assert made.stop == pytest.approx(5.99)
    assert made.first_speed == pytest.approx(np.linalg.norm(velocity[:5].mean(axis=0)))
    at = np.array([1.0, 2.5, 4.2])
    expected = np.stack([np.interp(10.0 + at, t, x) for x in world.T], axis=1)
    np.testing.assert_allclose(made.at(at), expected, atol=5e-3)
    assert (made.across is not None) == measured
    if measured:
        # Rotors push up: across are two directions that turn with the body, and what acts along them.
        directions, pushed, speed = made.across(at)
        for d, f, v, q, k in zip(directions, pushed, speed, turn[[100, 250, 420]], range(3), strict=True):
            body_axes = d @ matrix(q)
            np.testing.assert_allclose(body_axes @ body_axes.T, np.eye(2), atol=1e-9)
            np.testing.assert_allclose(body_axes[:, 2], 0.0, atol=1e-9)
            np.testing.assert_allclose(f, d @ expected[k], atol=5e-3)
            np.testing.assert_allclose(v, d @ velocity[[100, 250, 420]][k], atol=1e-6)


def test_nothing_is_across_rotors_that_push_in_more_than_one_direction():
    assert _across_thrust(OMAV) is None
    first = QUAD.rotors[0].model_copy(update={"axis": (0.0, 0.1, 0.995)})
    assert _across_thrust(QUAD.model_copy(update={"rotors": (first, *QUAD.rotors[1:])})) is None


def test_a_derived_velocity_is_smoothed_over_a_quarter_of_a_second():
    """Its slope keeps what moves at half a hertz, and most of its noise goes."""
    t = 0.01 * np.arange(600)
    clean = np.outer(np.sin(np.pi * t), np.ones(3))
    noisy = clean + 0.01 * RNG.standard_normal(clean.shape)
    inside = slice(30, -30)
    expected = np.outer(np.pi * np.cos(np.pi * t), np.ones(3))
    smooth, rough = (_slope(Samples(t, noisy, derived=d)) for d in (True, False))
    np.testing.assert_allclose(_slope(Samples(t, clean, derived=True))[inside], expected[inside], atol=0.03)
    assert np.std((smooth - expected)[inside]) < 0.3 * np.std((rough - expected)[inside])


def test_a_voltage_that_no_battery_has_is_no_sample():
    t = 0.01 * np.arange(400)
    volts = 16.0 - 0.2 * t
    volts[[100, 101]], volts[200], volts[300] = 8.0, 20.0, np.nan
    (made,) = [_battery(Flight(pd.DataFrame({"t": t, "battery": volts})))]
    assert len(made.times) == 396
    np.testing.assert_allclose(made.values[:, 0], 16.0 - 0.2 * made.times)


def test_what_is_recorded_comes_before_what_is_derived():
    t = 0.01 * np.arange(300)
    turned = exp(np.outer(t, [0.3, 0.0, 0.0]))
    columns = {"t": t, **{f"q{a}": turned[:, i] for i, a in enumerate("wxyz")}}
    columns |= {"px": 0.5 * t**2, "py": 0.0 * t, "pz": 1.0 + 0.0 * t, "vx": 9.0 + 0.0 * t, "vy": 0.0 * t, "vz": 0.0 * t}
    columns |= {f"cmd_rotor_{i}": 500.0 + 0.0 * t for i in range(4)}
    own = recorded(QUAD, Flight(pd.DataFrame(columns)))
    np.testing.assert_allclose(own.velocity.values[:, 0], 9.0)
    assert not own.velocity.derived
    # The rates are those of the attitude.
    np.testing.assert_allclose(
        own.rate.values[5:-5], np.tile([0.3, 0.0, 0.0], (len(own.rate.times) - 10, 1)), atol=1e-6
    )
    marked = recorded(QUAD, Flight(pd.DataFrame(columns), {"derived": ["vx", "vy", "vz"]}))
    np.testing.assert_allclose(marked.velocity.values[5:-5, 0], marked.velocity.times[5:-5], atol=1e-6)
    assert marked.velocity.derived


def test_a_command_is_held_until_its_next_number():
    t = 0.01 * np.arange(8)
    columns = {f"cmd_rotor_{i}": 500.0 + 0.0 * t for i in range(4)}
    columns["cmd_rotor_1"] = np.array([np.nan, 400.0, np.nan, np.nan, 450.0, np.nan, np.nan, 470.0])
    made = recorded(QUAD, Flight(pd.DataFrame({"t": t, **columns}))).rotor
    assert made.values[:, 1].tolist() == [400.0, 400.0, 400.0, 400.0, 450.0, 450.0, 450.0, 470.0]


def test_rotors_on_arms_that_tilt_push_and_react_along_their_turned_axes():
    tilt = 0.3 * RNG.standard_normal((3, len(OMAV.tilts)))
    thrust = RNG.uniform(1.0, 3.0, (3, len(OMAV.rotors)))
    made = RotorWrench(OMAV)
    wrench = made(thrust, made.ratio, Actuation(thrust, np.zeros_like(thrust), tilt, np.zeros_like(tilt)))
    for n in range(3):
        force, torque = np.zeros(3), np.zeros(3)
        for r, push in zip(OMAV.rotors, thrust[n], strict=True):
            turn = matrix(exp(tilt[n, r.tilt] * np.array(OMAV.tilts[r.tilt].axis)))
            axis, place = turn @ r.axis, turn @ r.position
            force += push * axis
            torque += np.cross(place, push * axis) - r.spin * r.moment_constant * push * axis
        np.testing.assert_allclose(wrench[n], [*force, *torque], atol=1e-9)


def test_forces_at_rotors_turn_the_body_about_its_origin():
    place, force = RNG.standard_normal((2, 4, 3, 3))
    expected = np.concatenate([force.sum(axis=1), np.cross(place, force).sum(axis=1)], axis=1)
    np.testing.assert_allclose(forces_at_rotors(place, force), expected)
