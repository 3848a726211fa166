"""The controller: perfect tracking with the right model (eq. 2), the inversion, limits and anti-windup."""

from pathlib import Path

import numpy as np
import pytest

from infotraj import rotations
from infotraj.control.demand import demand
from infotraj.control.gains import Gains
from infotraj.control.inversion import invert
from infotraj.control.response import invert_response
from infotraj.control.thrust_vector import ThrustVectorController, ThrustVectorGains
from infotraj.control.tracking import TrackingController, no_residual, states
from infotraj.dynamics import rigid_body
from infotraj.dynamics.actuators import body_wrench
from infotraj.dynamics.allocation import Allocation
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.robots.robot import Estimate
from infotraj.trajectories.reference import Reference
from infotraj.trajectories.tasks import figure_eight
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle(Path(__file__).parents[2] / "config" / "vehicles" / "omav.yaml")


def a_process(seed=0, size=1.0):
    rng = np.random.default_rng(seed)
    X = rng.uniform(-1, 1, (40, 6)) * [5, 5, 1, 3, 3, 3] + [0, 0, 9, 0, 0, 0]
    return GaussianProcess(
        X, size * rng.standard_normal((40, 3)), np.full((3, 6), 8.0), np.ones(3), np.full(3, 0.05), np.full(3, 0.4)
    )


def test_inversion_solves_for_the_demand():
    process, rng = a_process(), np.random.default_rng(1)
    for _ in range(50):
        wanted = rng.uniform(-1, 1, 6) * [4, 4, 1, 2, 2, 2] + [0, 0, 9, 0, 0, 0]
        command, correction = np.empty(6), np.zeros(3)
        left = invert(wanted, process.mean_arrays, 10.0, correction, command)
        assert left < 1e-8
        np.testing.assert_allclose(command[3:] + process.mean(command[None])[0], wanted[3:], atol=1e-4)
        np.testing.assert_array_equal(command[:3], wanted[:3])


def test_inversion_stays_within_its_limit_where_no_command_delivers_the_demand():
    """A residual of -u cancels every command: the correction must end at its limit, not explode."""
    X = np.concatenate([np.zeros((41, 3)), np.linspace(-4, 4, 41)[:, None] * np.ones(3)], axis=1)
    process = GaussianProcess(X, -X[:, 3:], np.full((3, 6), 5.0), np.full(3, 50.0), np.full(3, 1e-4), np.zeros(3))
    command, correction = np.empty(6), np.zeros(3)
    wanted = np.array([0, 0, 0, 2.0, 2.0, 2.0])
    left = invert(wanted, process.mean_arrays, 3.0, correction, command)
    assert np.isfinite(command).all()
    assert np.abs(correction).max() <= 3.0 + 1e-12
    assert left > 0.1


def test_demand_on_the_reference_is_the_feedforward_of_the_rigid_body():
    """With no error the demanded wrench must produce exactly the reference's accelerations (eq. 2)."""
    reference = figure_eight(np.radians(43), 9, 1, 0.01)
    rows, inertia = states(reference), OMAV.inertia_matrix()
    for k in (150, 400, 800):
        out = np.empty(6)
        demand(Gains(), OMAV.gravity, inertia, 0.01, rows[k, :13], rows[k], np.zeros(6), out)
        a, angular = rigid_body.accelerations(
            OMAV, reference.attitude[k], reference.rate[k], out * rigid_body.scale(OMAV)
        )
        np.testing.assert_allclose(a, reference.acceleration[k], atol=1e-9)
        np.testing.assert_allclose(angular, reference.angular_acceleration[k], atol=1e-9)


def test_feedback_turns_towards_the_reference_in_body_axes():
    reference = figure_eight(np.radians(26), 9, 1, 0.01)
    row = states(reference)[0]
    state = row[:13].copy()
    state[3:7] = rotations.exp([0.1, 0.0, 0.0])
    out = np.empty(6)
    demand(Gains(), OMAV.gravity, OMAV.inertia_matrix(), 0.01, state, row, np.zeros(6), out)
    assert out[3] == pytest.approx(-9.0 * 0.1, rel=1e-6)
    np.testing.assert_allclose(out[4:], 0.0, atol=1e-6)


def test_integrals_stop_while_the_feedback_is_limited():
    row = states(figure_eight(np.radians(26), 9, 1, 0.01))[0]
    far, near = row[:13].copy(), row[:13].copy()
    far[0] += 100.0
    near[0] += 0.01
    integral, out = np.zeros(6), np.empty(6)
    demand(Gains(), OMAV.gravity, OMAV.inertia_matrix(), 0.01, far, row, integral, out)
    np.testing.assert_array_equal(integral[:3], 0.0)
    assert np.linalg.norm(out[:3]) <= Gains().max_specific_force + 1e-9
    demand(Gains(), OMAV.gravity, OMAV.inertia_matrix(), 0.01, near, row, integral, out)
    assert integral[0] == pytest.approx(-1e-4)


def test_controller_commands_hover_and_forgets_on_reset():
    reference = figure_eight(np.radians(26), 9, 1, 0.01)
    controller = TrackingController(OMAV, reference, no_residual())
    still = Estimate(np.array([0.1, 0, 1.5]), np.array([1.0, 0, 0, 0]), np.zeros(3), np.zeros(3))
    first = controller.command(0, still)
    np.testing.assert_allclose(first[0][2], OMAV.mass * OMAV.gravity, rtol=1e-3)
    second = controller.command(0, still)
    assert not np.allclose(first[0], second[0], atol=1e-12)
    controller.reset()
    np.testing.assert_array_equal(controller.command(0, still)[0], first[0])


def test_without_gains_the_torque_of_a_turning_quadrotor_is_what_keeps_it_turning():
    """Euler: I dw/dt + w x I w = tau, and dw/dt is the reference's, none."""
    vehicle = load_vehicle(Path(__file__).parents[2] / "config" / "vehicles" / "quadrotor.yaml")
    free = ThrustVectorGains(
        **dict.fromkeys(["attitude_p", "attitude_d", "attitude_i", "yaw_p", "yaw_d", "yaw_i"], 0.0)
    )
    none = np.zeros((10, 3))
    level = np.tile([1.0, 0.0, 0.0, 0.0], (10, 1))
    still = Reference(0.01 * np.arange(10), none, level, none, none, none, none)
    rate = np.array([1.0, -2.0, 3.0])
    estimate = Estimate(still.position[0], still.attitude[0], np.zeros(3), rate)
    wrench, _, _ = ThrustVectorController(vehicle, still, free).command(0, estimate)
    np.testing.assert_allclose(wrench[3:], np.cross(rate, vehicle.inertia_matrix() @ rate), atol=1e-12)
    assert np.abs(wrench[3:]).max() > 1e-3


def test_a_rate_of_the_reference_that_stands_still_in_the_world_turns_in_a_body_that_turns():
    """Seen from a body that turns at w, a vector that stays changes by -w x itself."""
    inertia, w, rate = OMAV.inertia_matrix(), np.array([0.7, -0.4, 0.9]), np.array([0.5, 0.8, -0.3])
    row = np.zeros(19)
    row[3:7] = rotations.exp(np.array([0.3, -0.2, 0.6]))
    row[10:13] = rotations.to_body(row[3:7], rate)
    state = row[:13].copy()
    state[3:7], state[10:13] = rotations.exp(np.array([0.2, -0.1, 0.4])), w
    out, calm = np.empty(6), np.empty(6)
    no_feedback = Gains(attitude_p=0, attitude_d=0, attitude_i=0, yaw_p=0, yaw_d=0, yaw_i=0)
    demand(no_feedback, OMAV.gravity, inertia, 0.01, state, row, np.zeros(6), out)
    row[10:13] = 0.0
    demand(no_feedback, OMAV.gravity, inertia, 0.01, state, row, np.zeros(6), calm)
    seen = rotations.to_body(state[3:7], rate)
    np.testing.assert_allclose((out - calm)[3:], -np.cross(w, seen), atol=1e-12)


def test_the_integral_of_a_thrust_vector_grows_with_the_miss_unless_the_feedback_is_limited():
    """A vehicle that stays 1 cm low is pushed by i times the miss times the period more at the next command."""
    vehicle = load_vehicle(Path(__file__).parents[2] / "config" / "vehicles" / "quadrotor.yaml")
    none, level = np.zeros((10, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (10, 1))
    still = Reference(0.01 * np.arange(10), none, level, none, none, none, none)
    gained = {}
    for miss in (0.01, 100.0):
        controller = ThrustVectorController(vehicle, still)
        low = Estimate(np.array([0.0, 0.0, -miss]), level[0], np.zeros(3), np.zeros(3))
        first, second = (controller.command(k, low)[0] for k in (0, 1))
        gained[miss] = second[2] - first[2]
    assert gained[0.01] == pytest.approx(vehicle.mass * ThrustVectorGains().position_i * 0.01 * 0.01, rel=1e-9)
    assert gained[100.0] == 0.0


class OfARigidBody:
    """What Newton and Euler say that a vehicle does."""

    def __init__(self, vehicle):
        self.vehicle = vehicle

    def accelerations(self, time, state, rotor, tilt):
        wrench = body_wrench(self.vehicle, rotor, tilt)
        world, angular = rigid_body.accelerations(self.vehicle, state[3:7], state[10:], wrench)
        return np.concatenate(
            [rotations.to_body(state[3:7], world + np.array([0.0, 0.0, self.vehicle.gravity])), angular]
        )


def test_a_known_response_is_inverted_with_its_own_gyroscopic_torque():
    """On the reference, of a body with unlike moments of inertia, the actuators make the reference's accelerations."""
    moments = {"xx": 0.06, "yy": 0.12, "zz": 0.15, "xy": 0.0, "xz": 0.0, "yz": 0.0}
    unlike = OMAV.model_copy(update={"inertia": OMAV.inertia.model_copy(update=moments)})
    reference, response = figure_eight(np.radians(43), 6, 1, 0.01), OfARigidBody(unlike)
    controller, rows = TrackingController(unlike, reference, response=response), states(reference)
    turning = []
    for k in (250, 380, 500):
        controller.reset()
        row = rows[k]
        _, rotor, tilt = controller.command(k, Estimate(row[:3], row[3:7], row[7:10], row[10:13]))
        made = response.accelerations(0.0, row[:13], rotor, tilt)
        np.testing.assert_allclose(made[3:], reference.angular_acceleration[k], atol=2e-3)
        turning.append(
            np.abs(np.cross(row[10:13], unlike.inertia_matrix() @ row[10:13]) / np.diag(unlike.inertia_matrix())).max()
        )
    assert max(turning) > 0.05


def test_what_the_residual_adds_is_no_error_of_a_known_response():
    """The response of a rigid body and a residual on top make together what is demanded."""
    process, response = a_process(size=0.3), OfARigidBody(OMAV)
    scale, allocation = rigid_body.scale(OMAV), Allocation(OMAV)
    state = np.concatenate([np.zeros(3), [1.0], np.zeros(9)])
    wanted = np.array([0.5, -0.3, 9.81, 0.4, -0.2, 0.3])
    offset, correction, command = np.zeros(6), np.zeros(3), np.empty(6)
    missing = invert_response(
        wanted, wanted, 0.0, state, response, allocation, scale, process.mean_arrays, 10.0, offset, correction, command
    )
    made = response.accelerations(0.0, state, *allocation.actuators(command * scale))
    np.testing.assert_allclose(made[3:] + process.mean(command[None])[0], wanted[3:], atol=2e-3)
    np.testing.assert_allclose(offset, 0.0, atol=2e-3)
    assert np.abs(correction).max() > 0.1
    assert missing < 1e-3
