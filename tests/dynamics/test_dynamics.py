"""The first-principles model against mechanics: hover, momentum, energy, exact lags."""

from pathlib import Path

import numpy as np
import pytest

from infotraj import rotations
from infotraj.dynamics import response, rigid_body
from infotraj.dynamics.actuators import body_wrench, rotor_frames, thrusts
from infotraj.dynamics.allocation import Allocation
from infotraj.errors import InputError
from infotraj.vehicle import load_vehicle, parse_vehicle

OMAV = Path(__file__).parents[2] / "config" / "vehicles" / "omav.yaml"


@pytest.fixture(scope="module")
def omav():
    return load_vehicle(OMAV)


def test_hover_needs_the_speed_that_was_measured_on_the_real_omav(omav):
    speed, tilt = Allocation(omav).actuators([0, 0, omav.mass * omav.gravity, 0, 0, 0])
    np.testing.assert_allclose(tilt, 0.0, atol=1e-12)
    np.testing.assert_allclose(speed, 677.0, atol=2.0)  # rad/s, spec of the experiment


def test_without_a_mass_there_are_no_accelerations_and_no_scale(omav):
    weightless = omav.model_copy(update={"mass": None})
    with pytest.raises(InputError, match="has no mass"):
        rigid_body.accelerations(weightless, [1.0, 0, 0, 0], np.zeros(3), np.zeros(6))
    with pytest.raises(InputError, match="has no mass"):
        rigid_body.scale(weightless)


def test_a_throttle_makes_the_thrust_of_its_polynomial_with_all_three_terms(omav):
    rotor = omav.rotors[0].model_copy(update={"input": "throttle", "thrust_polynomial": (0.1, 0.5, 2.0)})
    throttles = np.array([[0.0], [0.3], [1.0]])
    made = thrusts(omav.model_copy(update={"rotors": (rotor,)}), throttles)
    np.testing.assert_allclose(made[:, 0], [0.1, 0.1 + 0.15 + 0.18, 2.6])


def test_allocation_inverts_the_actuators_for_any_direction_of_the_force(omav):
    rng = np.random.default_rng(0)
    force = rng.standard_normal((200, 3))
    force *= 40.0 / np.linalg.norm(force, axis=1, keepdims=True)
    wrench = np.concatenate([force, np.zeros((200, 3))], axis=1)
    speed, tilt = Allocation(omav).actuators(wrench)
    achieved = body_wrench(omav, speed, tilt)
    np.testing.assert_allclose(achieved[:, :3], force, atol=0.3)
    np.testing.assert_allclose(achieved[:, 3:], 0.0, atol=0.05)


def test_allocation_of_a_small_torque_is_exact_up_to_the_pairs_common_tilt(omav):
    wrench = np.array([0.0, 0.0, 39.6, 0.2, -0.1, 0.05])
    achieved = body_wrench(omav, *Allocation(omav).actuators(wrench))
    np.testing.assert_allclose(achieved, wrench, atol=2e-3)


def test_allocation_of_a_vehicle_without_tilts_is_exact_in_yaw_too():
    quadrotor = load_vehicle(OMAV.with_name("quadrotor.yaml"))
    wrench = np.array([0.0, 0.0, 8.0, 0.05, -0.03, 0.02])
    np.testing.assert_allclose(body_wrench(quadrotor, *Allocation(quadrotor).actuators(wrench)), wrench, atol=1e-9)


def test_allocation_refuses_a_rotor_beside_the_axis_of_its_tilt(omav):
    content = omav.model_dump()
    content["rotors"][0]["position"] = (0.05, -0.3, 0.06)
    with pytest.raises(InputError, match="beside the axis"):
        _ = Allocation(parse_vehicle(content)).matrix


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_allocation_refuses_a_rotor_that_leans_along_the_axis_of_its_tilt_to_either_side(omav, side):
    content = omav.model_dump()
    rotor = content["rotors"][0]
    along = np.array(content["tilts"][rotor["tilt"]]["axis"])
    rotor["position"] = tuple(0.3 * along)  # on the axis of the tilt, whichever way the thrust points
    rotor["axis"] = tuple(np.cos(0.2) * np.array(rotor["axis"]) + side * np.sin(0.2) * along)
    with pytest.raises(InputError, match="beside the axis"):
        _ = Allocation(parse_vehicle(content)).matrix


def test_tilt_turns_the_thrust_right_handed_about_the_outward_axis(omav):
    tilt = np.zeros(6)
    tilt[1] = 0.3  # arm 1 points along +y: its thrust leans to +x
    _, axes = rotor_frames(omav, tilt)
    np.testing.assert_allclose(axes[1], [np.sin(0.3), 0.0, np.cos(0.3)], atol=1e-12)


def test_reaction_torque_opposes_the_spin(omav):
    speed = np.zeros(12)
    speed[0] = 700.0  # spin +1: counter-clockwise from above, so the body is turned clockwise
    assert body_wrench(omav, speed, np.zeros(6))[5] == pytest.approx(-0.015 * 7.2e-6 * 700.0**2)


def test_gyroscopic_torque_does_no_work(omav):
    rng = np.random.default_rng(1)
    rate = rng.standard_normal((50, 3))
    _, angular = rigid_body.accelerations(omav, [1.0, 0, 0, 0], rate, np.zeros((50, 6)))
    power = np.einsum("ni,ij,nj->n", rate, omav.inertia_matrix(), angular)
    np.testing.assert_allclose(power, 0.0, atol=1e-13)


def test_offset_centre_of_mass_keeps_the_momentum_balance(omav):
    """Newton at the centre of mass and Euler about it, written without the closed form of the library."""
    vehicle = parse_vehicle({**omav.model_dump(), "center_of_mass": (0.01, -0.02, 0.03)})
    rng = np.random.default_rng(2)
    q = rotations.normalize(rng.standard_normal(4))
    w, wrench = rng.standard_normal(3), rng.standard_normal(6)
    a, angular = rigid_body.accelerations(vehicle, q, w, wrench)
    r = np.asarray(vehicle.center_of_mass)
    at_mass = a + rotations.to_world(q, np.cross(angular, r) + np.cross(w, np.cross(w, r)))
    weight = np.array([0, 0, -vehicle.mass * vehicle.gravity])
    np.testing.assert_allclose(vehicle.mass * at_mass, rotations.to_world(q, wrench[:3]) + weight, atol=1e-12)
    inertia = vehicle.inertia_matrix()
    change = inertia @ angular + np.cross(w, inertia @ w)
    np.testing.assert_allclose(change, wrench[3:] - np.cross(r, wrench[:3]), atol=1e-12)


def test_lag_is_the_exact_solution_whatever_the_rows(omav):
    fine, coarse = np.linspace(0, 0.2, 2001), np.linspace(0, 0.2, 21)
    command = np.array([[0.0]] + [[1.0]] * 20)
    held = command[np.minimum(np.searchsorted(coarse, fine + 1e-12, side="right") - 1, 20)]
    x = response.respond(coarse, command, [0.03], [8.0])
    np.testing.assert_allclose(x[:, 0], response.respond(fine, held, [0.03], [8.0])[::100, 0], atol=1e-12)
    np.testing.assert_allclose(x[1:, 0][0], 0.0)  # the step is commanded in row 1 and acts from there
    assert np.max(np.diff(x[:, 0])) <= 8.0 * 0.01 + 1e-12


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_tilt_runs_at_its_greatest_rate_and_then_settles_to_either_side(way):
    """0.8 of the way at 2 per s takes 0.4 s; of the last 0.2 one time constant of 0.1 s leaves the e-th part."""
    command = way * np.array([[0.0], [1.0], [1.0]])
    x = response.respond([0.0, 0.1, 0.6], command, [0.1], [2.0])
    np.testing.assert_allclose(x[:, 0], way * np.array([0.0, 0.0, 1.0 - 0.2 / np.e]), atol=1e-12)


def test_no_lag_follows_the_command_of_the_row_before():
    command = np.arange(5.0)[:, None]
    np.testing.assert_allclose(response.respond(np.arange(5.0), command, [0.0], np.inf)[:, 0], [0, 0, 1, 2, 3])


def test_no_rotor_is_asked_for_more_than_its_top_speed(omav):
    limited = omav.model_copy(update={"rotors": tuple(r.model_copy(update={"max_speed": 300.0}) for r in omav.rotors)})
    wrench = [0, 0, 5.0 * omav.mass * omav.gravity, 0, 0, 0]
    speed, _ = Allocation(limited).actuators(wrench)
    assert speed == pytest.approx(np.full(len(omav.rotors), 300.0))
    assert Allocation(omav).actuators(wrench)[0].max() > 300.0
