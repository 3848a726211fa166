"""The plant's rigid bodies and actuators, held against physics."""

import numpy as np
import pytest
from mass_properties import mass_properties

from infotraj import rotations
from infotraj.dynamics.actuators import body_wrench
from infotraj.dynamics.allocation import Allocation
from infotraj.dynamics.rigid_body import accelerations
from infotraj.robots.plant.plant import Plant
from infotraj.robots.plant.static import StaticPlant
from infotraj.robots.plant.truth import Lag, SecondOrder, Truth, load_truth
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle("config/vehicles/omav.yaml")
QUADROTOR = load_vehicle("config/vehicles/quadrotor.yaml")
PLANTS = {name: load_truth(f"config/plants/{name}.yaml", OMAV) for name in ("omav_a", "omav_b", "omav_c")}
IDEAL = Truth.ideal(OMAV)
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
TILTED = rotations.from_euler(0.7, -0.5, 0.3)


def servos(truth, **changes):
    return truth.model_copy(update={"servos": truth.servos.model_copy(update=changes)})


def still(plant, attitude=UPRIGHT, rotor=0.0, tilt=0.0):
    n, m = len(plant.vehicle.rotors), len(plant.vehicle.tilts)
    plant.reset(np.zeros(3), attitude, np.broadcast_to(rotor, n) * 1.0, np.broadcast_to(tilt, m) * 1.0)


def hovering(plant, attitude):
    up = rotations.to_body(attitude, [0.0, 0.0, 1.0])
    command = Allocation(plant.vehicle).actuators(StaticPlant(plant.vehicle, plant.truth).hold(up))
    plant.reset(np.zeros(3), attitude, *command)


@pytest.mark.parametrize("truth", [*PLANTS.values(), IDEAL], ids=lambda t: t.name)
def test_totals_at_zero_tilts_are_the_truths(truth):
    plant = Plant(OMAV, truth)
    still(plant, tilt=-np.array(truth.servos.zero_error))
    mass, center, inertia = mass_properties(plant.bodies)
    assert mass == pytest.approx(truth.mass, rel=1e-12)
    np.testing.assert_allclose(center, truth.center_of_mass, atol=1e-12)
    np.testing.assert_allclose(inertia, truth.inertia.matrix(), atol=1e-12)


def test_free_fall():
    plant = Plant(OMAV, IDEAL)
    still(plant, TILTED)
    np.testing.assert_allclose(plant.bodies.specific_force, 0.0, atol=1e-9)
    plant.advance(500)
    assert plant.bodies.velocity[2] == pytest.approx(-9.81 * 0.5, rel=1e-9)
    # The integrator's own error is g dt t / 2.
    assert plant.bodies.position[2] == pytest.approx(-0.5 * 9.81 * 0.25, abs=9.81 * 1e-3 * 0.5 * 0.51)
    assert rotations.angle_between(plant.bodies.attitude, TILTED) < 1e-9


def passive_drift(timestep):
    """Relative change of energy over 1 s of tumbling with loose arms, no actuation, no damping."""
    plant = Plant(OMAV, servos(PLANTS["omav_b"], play=(0.0,) * 6), timestep=timestep)
    still(plant, TILTED)
    bodies = plant.bodies
    bodies.model.dof_damping[:] = 0.0
    bodies.model.actuator_gainprm[:] = 0.0
    bodies.model.actuator_biasprm[:] = 0.0
    bodies.model.opt.gravity[:] = 0.0
    bodies.qvel[:6] = [0.0, 0.0, 0.0, 1.5, -1.0, 2.0]
    bodies.qvel[6:] = [2.0, -1.0, 0.5, 1.0, -2.0, 0.3]
    before = bodies.energy()
    for _ in range(round(1.0 / timestep)):
        bodies.step()
    return bodies.energy() / before - 1.0


def test_energy_is_kept_without_actuation_and_the_integrator_is_of_first_order():
    coarse, fine = passive_drift(1e-3), passive_drift(5e-4)
    assert abs(coarse) < 2e-3
    assert coarse / fine == pytest.approx(2.0, rel=0.1)


def test_tilting_arms_turn_the_body_and_keep_the_momentum():
    plant = Plant(OMAV, PLANTS["omav_a"])
    still(plant, TILTED)
    bodies = plant.bodies
    bodies.model.opt.gravity[:] = 0.0
    linear, angular = bodies.momentum()
    plant.command(np.zeros(12), np.array([1.0, -1.0, 0.8, -0.8, 0.5, -0.7]))
    fastest = 0.0
    for _ in range(200):
        bodies.step()
        fastest = max(fastest, float(np.linalg.norm(bodies.rate)))
    assert fastest > 0.01
    after = bodies.momentum()
    np.testing.assert_allclose(after[0], linear, atol=1e-6)
    # The arms carry up to 6e-4 kg m^2 x 8 rad/s each; the integrator's own error is 1 % of that.
    np.testing.assert_allclose(after[1], angular, atol=5e-5)


@pytest.mark.parametrize("truth", [*PLANTS.values(), IDEAL], ids=lambda t: t.name)
def test_hover_is_an_equilibrium_and_the_imu_feels_gravity_upwards(truth):
    plant = Plant(OMAV, truth)
    hovering(plant, TILTED)
    bodies = plant.bodies
    np.testing.assert_allclose(bodies.qacc[:6], 0.0, atol=1e-5)
    np.testing.assert_allclose(bodies.specific_force, rotations.to_body(TILTED, [0.0, 0.0, 9.81]), atol=1e-5)
    plant.advance(200)
    assert np.linalg.norm(bodies.position) < 1e-4
    assert rotations.angle_between(bodies.attitude, TILTED) < 1e-3


def test_without_hidden_effects_it_is_the_first_principles_model():
    plant, rng = Plant(OMAV, IDEAL), np.random.default_rng(3)
    for _ in range(20):
        attitude = rotations.normalize(rng.standard_normal(4))
        rotor, tilt = rng.uniform(0, 1200, 12), rng.uniform(-1.5, 1.5, 6)
        still(plant, attitude, rotor, tilt)
        plant.bodies.velocity[:] = rng.uniform(-3, 3, 3)
        plant.bodies.rate[:] = rng.uniform(-3, 3, 3)
        plant.observe()
        wrench = body_wrench(OMAV, rotor, tilt)
        linear, angular = accelerations(OMAV, attitude, plant.bodies.rate, wrench)
        np.testing.assert_allclose(plant.achieved, wrench, atol=1e-9)
        np.testing.assert_allclose(plant.bodies.qacc[:3], linear, atol=2e-3)
        np.testing.assert_allclose(plant.bodies.angular_acceleration, angular, atol=2e-3 * (1 + np.abs(angular).max()))


@pytest.mark.parametrize("truth", PLANTS.values(), ids=lambda t: t.name)
def test_mujocos_acceleration_is_that_of_the_reported_wrench_on_the_true_body(truth):
    plant, rng = Plant(OMAV, servos(truth, zero_error=(0.0,) * 6)), np.random.default_rng(4)
    true_vehicle = OMAV.model_copy(
        update={"mass": truth.mass, "inertia": truth.inertia, "center_of_mass": truth.center_of_mass}
    )
    for _ in range(10):
        attitude = rotations.normalize(rng.standard_normal(4))
        still(plant, attitude, rng.uniform(300, 900, 12), 0.0)
        plant.bodies.velocity[:] = rng.uniform(-3, 3, 3)
        plant.observe()
        linear, angular = accelerations(true_vehicle, attitude, np.zeros(3), plant.achieved)
        # The arms turn with the body only as far as their servos hold them: 6 x 6e-4 of 0.09 kg m^2.
        np.testing.assert_allclose(plant.bodies.angular_acceleration, angular, rtol=0.03, atol=0.03)
        np.testing.assert_allclose(plant.bodies.qacc[:3], linear, atol=0.02)


def test_a_rotors_reaction_torque_is_against_its_spin():
    plant = Plant(QUADROTOR, Truth.ideal(QUADROTOR))
    for i, rotor in enumerate(QUADROTOR.rotors):
        still(plant, rotor=np.eye(4)[i] * 1000.0)
        thrust = 1.5e-6 * 1000.0**2
        assert plant.bodies.thrust[i] == pytest.approx(thrust)
        assert plant.bodies.angular_acceleration[2] == pytest.approx(-rotor.spin * 0.012 * thrust / 0.0105)


def test_a_quadrotor_builds_and_hovers():
    plant = Plant(QUADROTOR, Truth.ideal(QUADROTOR))
    hovering(plant, UPRIGHT)
    assert plant.speed == pytest.approx(np.full(4, np.sqrt(0.8 * 9.81 / 4 / 1.5e-6)))
    plant.advance(500)
    assert np.abs(plant.bodies.qpos - [0, 0, 0, 1, 0, 0, 0]).max() < 1e-9


def test_rotors_speed_up_in_12_ms_and_slow_down_in_25_ms():
    plant = Plant(OMAV, PLANTS["omav_a"])
    for start, goal, constant in ((600.0, 700.0, 0.0125), (700.0, 600.0, 0.025)):
        still(plant, rotor=start)
        plant.command(np.full(12, goal), np.zeros(6))
        plant.advance(10)
        np.testing.assert_allclose(plant.speed, goal + (start - goal) * np.exp(-0.010 / constant), rtol=1e-12)
    plant.command(np.full(12, 5000.0), np.zeros(6))
    plant.advance(500)
    np.testing.assert_allclose(plant.speed, 1700.0)


def tilt_response(truth, command, duration):
    """True tilt 0 (rad) each millisecond after a step of all tilt commands, floating free of gravity."""
    plant = Plant(OMAV, truth)
    still(plant)
    plant.bodies.model.opt.gravity[:] = 0.0
    plant.command(np.zeros(12), np.full(6, command))
    angles = []
    for _ in range(round(duration * 1000)):
        plant.advance(1)
        angles.append(plant.bodies.tilts()[0])
    return np.array(angles)


def test_a_servo_with_dead_time_waits_and_follows_its_lag():
    truth = servos(
        PLANTS["omav_c"], zero_error=(0.0,) * 6, play=(0.0,) * 6, dynamics=Lag(time_constant=0.02, dead_time=0.013)
    )
    angle = tilt_response(truth, 0.1, 0.2)
    assert np.abs(angle[:13]).max() < 1e-6
    assert angle[-1] == pytest.approx(0.1, rel=1e-3)
    # Dead time and lag together are the area between command and response over the step.
    assert np.sum(0.1 - angle) * 1e-3 / 0.1 == pytest.approx(0.033, abs=1.5e-3)
    reached = 13 + 20
    assert angle[reached] / 0.1 == pytest.approx(1 - np.exp(-1), abs=0.03)


def test_a_servo_of_second_order_overshoots_as_its_damping_says():
    truth = servos(PLANTS["omav_a"], play=(0.0,) * 6, zero_error=(0.0,) * 6)
    assert isinstance(truth.servos.dynamics, SecondOrder)
    angle = tilt_response(truth, 0.1, 1.0)
    overshoot = np.exp(-np.pi * 0.46 / np.sqrt(1 - 0.46**2))
    assert angle.max() / 0.1 - 1 == pytest.approx(overshoot, rel=0.05)
    assert np.argmax(angle) * 1e-3 == pytest.approx(np.pi / (17 * np.sqrt(1 - 0.46**2)), rel=0.03)


@pytest.mark.parametrize("name", ["omav_a", "omav_b"])
def test_a_servos_rate_is_limited(name):
    truth = servos(PLANTS[name], play=(0.0,) * 6)
    rate = np.diff(tilt_response(truth, 2.5, 0.5)) / 1e-3
    assert rate.max() < 8.0 * 1.02
    if name == "omav_b":
        assert rate.max() == pytest.approx(8.0, rel=0.02)


def test_an_arm_follows_its_servo_through_its_play_and_keeps_its_zero_error():
    half = 0.01
    truth = servos(PLANTS["omav_b"], play=(half,) * 6, zero_error=(0.02,) * 6)
    plant = Plant(OMAV, truth)
    still(plant)
    plant.bodies.model.opt.gravity[:] = 0.0
    ends = []
    for end in (0.1, -0.1):
        start = plant.bodies.servo[0]
        for k in range(1500):
            plant.command(np.zeros(12), np.full(6, start + (end - start) * min(k / 1000, 1.0)))
            plant.advance(1)
        ends.append(plant.bodies.tilts()[0] - 0.02)
    # Pushed from behind, the arm stays half the play short of its servo (it coasts a little: soft stop, slow bearing).
    assert ends[0] == pytest.approx(0.1 - half, abs=0.003)
    assert ends[1] == pytest.approx(-0.1 + half, abs=0.003)
