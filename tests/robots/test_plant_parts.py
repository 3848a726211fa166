"""Parts of a plant that no flight is needed for: battery, filter, lateness, gusts, wall, and what hiding sets."""

from pathlib import Path

import numpy as np
import pytest

from infotraj.robots.plant.disturbances import Disturbances, gusts
from infotraj.robots.plant.hidden import Disturbance, Pack, Sag, Turbulence, Wall
from infotraj.robots.plant.hiding import clutter, exact, gusty, hide, pack
from infotraj.robots.plant.lateness import Filter, LateCommands, LateSamples
from infotraj.robots.plant.model import SERVO_INERTIA, Bodies, servo_gains
from infotraj.robots.plant.sensors import Noise, turned
from infotraj.robots.plant.static import StaticPlant
from infotraj.robots.plant.supply import Drain
from infotraj.robots.plant.truth import SecondOrder, Truth
from infotraj.rotations import exp
from infotraj.vehicle import load_vehicle

VEHICLES = Path(__file__).parents[2] / "config/vehicles"
QUAD, OMAV = (load_vehicle(VEHICLES / f"{n}.yaml") for n in ("quadrotor", "omav"))
NONE = np.random.default_rng(0)


def drained(supply, rows, speed=1.0, period=0.01, before=0):
    """Factors of the thrust and logged volts, row by row."""
    drain = Drain(supply, period, np.random.default_rng(0))
    made = [(drain.advance(np.full(4, speed), k >= before), drain.log()) for k in range(rows)]
    return np.array(made)


def test_a_sag_takes_its_share_a_second_from_the_first_row_on():
    factor = drained(Sag(rate=0.1), 40, before=10)[:, 0]
    np.testing.assert_allclose(factor, 1.0 - 0.1 * 0.01 * np.maximum(np.arange(40) - 10, 0))


def battery(**changed):
    return Pack(**{"nominal": 16.0, "full": 16.5, "slope": 0.05, "resistance": 0.05, "power_coefficient": 2.0,
                   "exponent": 2.0, **changed})  # fmt: skip


def test_a_battery_gives_the_power_of_its_rotors_through_its_resistance_and_falls_by_the_charge():
    """Four rotors at 3 rad/s of 2 W s^3/rad^3 take 216 W: V I = 216, and V = E - R I."""
    drain = Drain(battery(), 0.01, NONE)
    full, charge = 16.5, 0.0
    for _ in range(300):
        factor = drain.advance(np.full(4, 3.0), True)
        current = 216.0 / drain.volts
        assert drain.volts == pytest.approx(full - 0.05 * charge - 0.05 * current)
        assert drain.volts > 0.5 * full
        assert factor == pytest.approx((drain.volts / 16.0) ** 2)
        charge += 0.01 * current
    # Beyond the greatest power half of the open circuit is left.
    drain.advance(np.full(4, 100.0), True)
    assert drain.volts == pytest.approx(0.5 * (full - 0.05 * charge))


def test_a_part_of_the_voltage_makes_no_thrust():
    drain = Drain(battery(blind=0.2), 0.01, NONE)
    factor = drain.advance(np.full(4, 3.0), True)
    assert factor == pytest.approx(((drain.volts - 3.2) / 12.8) ** 2)


def test_a_logged_voltage_is_late_stepped_and_held():
    supply = battery(log_lag=0.1, log_step=0.05, log_period=0.05, slope=0.0)
    volts = drained(supply, 200, speed=3.0)[:, 1]
    drain = Drain(supply, 0.01, NONE)
    drain.advance(np.full(4, 3.0), True)
    late = drain.volts + (16.5 - drain.volts) * np.exp(-0.01 * (1.0 + np.arange(200)) / 0.1)
    np.testing.assert_allclose(volts[::5], np.round(late[::5] / 0.05) * 0.05)
    np.testing.assert_allclose(volts, np.repeat(volts[::5], 5))


def test_hovering_draws_what_the_pack_was_sized_to():
    """2 % of the voltage through its resistance, and 6 % more in sixteen seconds."""
    vehicle = QUAD.model_copy(update={"nominal_voltage": 16.0})
    made = pack(vehicle, exponent=1.0, log_noise=0.0)
    hover = np.sqrt(QUAD.mass * QUAD.gravity / 4 / QUAD.rotors[0].thrust_coefficient)
    drain = Drain(made, 0.01, NONE)
    drain.advance(np.full(4, hover), True)
    assert drain.volts == pytest.approx(16.0, rel=2e-3)
    for _ in range(1600):
        drain.advance(np.full(4, hover), True)
    assert drain.volts == pytest.approx(16.0 * 0.94, rel=5e-3)


def test_a_filter_is_exact_for_a_ramp():
    made = Filter(0.02, 0.001)
    made.settle(np.zeros(6))
    for k in range(1, 300):
        made.move(np.full(6, 0.001 * k))
    t = 0.299
    np.testing.assert_allclose(made.value, t - 0.02 * (1.0 - np.exp(-t / 0.02)), atol=1e-12)
    made.settle(np.full(6, 3.0))
    assert made.value.tolist() == [3.0] * 6


def test_commands_act_when_they_are_due_the_newest_first():
    late = LateCommands(3)
    for step in (0, 2, 3):
        late.give(step, np.full(4, float(step)), np.zeros(0))
    assert late.due(2) is None
    assert late.due(3)[0].tolist() == [0.0] * 4
    assert late.due(6)[0].tolist() == [3.0] * 4
    assert late.due(7) is None


def test_a_late_sample_is_that_of_so_many_steps_before_its_row():
    late = LateSamples(3, 5)
    for step in range(30):
        if step % 5 == 0:
            expected = step - 3 if step >= 5 else step
            assert late.read(step, np.full(6, float(step)))[0] == expected
        if late.wanted(step):
            late.take(step, np.full(6, float(step)))
    assert not LateSamples(0, 5).wanted(5)


def test_gusts_are_as_large_in_force_and_torque_and_as_long_as_they_say():
    made = gusts(Turbulence(force=2.0, torque=0.3, correlation_time=0.5), 40000, 0.01, np.random.default_rng(0))
    np.testing.assert_allclose(made.std(axis=0), [2.0] * 3 + [0.3] * 3, rtol=0.12)
    later = np.mean(made[50:] * made[:-50], axis=0) / made.var(axis=0)
    np.testing.assert_allclose(later, np.exp(-1.0), atol=0.08)


def added(hidden, position=(0.0, 0.0, 1.0), turn=(0.0, 0.0, 0.0)):
    applied = np.zeros(6)
    Disturbances(hidden, 10, 0.01, np.random.default_rng(0)).add(np.array(position), exp(np.array(turn)), applied)
    return applied


def test_a_wall_pulls_and_sinks_the_nearer_the_more_and_turns_the_body_in_the_world():
    wall = Disturbance(wall=Wall(place=2.0, range=0.5, pull=3.0, sink=1.0, torque=(0.0, 0.2, 0.0)))
    share = np.exp(-1.0 / 0.5)
    assert added(wall, (1.0, 0.0, 0.0)) == pytest.approx(share * np.array([3.0, 0.0, -1.0, 0.0, 0.2, 0.0]))
    assert added(wall, (5.0, 0.0, 0.0))[:3] == pytest.approx([3.0, 0.0, -1.0])
    # Turned to the left, what turns about y of the world turns about x of the body.
    left = added(wall, (2.0, 0.0, 0.0), (0.0, 0.0, np.pi / 2))
    assert left[3:] == pytest.approx([0.2, 0.0, 0.0])


def test_a_magnet_turns_the_body_back_to_its_field():
    magnet = Disturbance(magnetic=(0.0, 0.0, 0.3), force=(1.0, 2.0, 3.0), torque=(0.1, 0.0, 0.0))
    assert added(magnet) == pytest.approx([1.0, 2.0, 3.0, 0.1, 0.3, 0.0])
    turned_left = added(magnet, turn=(0.0, 0.0, np.pi / 2))
    assert turned_left == pytest.approx([1.0, 2.0, 3.0, 0.1 + 0.3, 0.0, 0.0])


def test_gusts_push_in_body_axes():
    made = Disturbance(turbulence=Turbulence(force=1.0, torque=1.0, correlation_time=0.1))
    level, turned_left = added(made), added(made, turn=(0.0, 0.0, np.pi / 2))
    assert turned_left[:2] == pytest.approx([-level[1], level[0]])
    assert turned_left[2:] == pytest.approx(level[2:])


def test_noise_of_each_sensor_is_its_own():
    noise = Noise(position=0.1, attitude=0.2, rate=0.3, specific_force=0.4)
    rng = np.random.default_rng(0)
    spread = [x.std() for x in (*noise.mocap(rng, 4000), *noise.imu(rng, 4000))]
    assert spread == pytest.approx([0.1, 0.2, 0.3, 0.4], rel=0.05)
    out = np.empty(4)
    turned(exp(np.array([0.3, 0.0, 0.0])), np.array([0.4, 0.0, 0.0]), out)
    assert out == pytest.approx(exp(np.array([0.7, 0.0, 0.0])))


def test_servos_have_the_gains_of_their_dynamics():
    ideal = Truth.ideal(OMAV)
    second = SecondOrder(natural_frequency=30.0, damping_ratio=0.7)
    servos = ideal.servos.model_copy(update={"dynamics": second, "max_rate": 5.0})
    kp, kv, most = servo_gains(ideal.model_copy(update={"servos": servos}))
    assert np.sqrt(kp / SERVO_INERTIA) == pytest.approx(30.0)
    assert kv / (2.0 * np.sqrt(kp * SERVO_INERTIA)) == pytest.approx(0.7)
    assert most / kv == pytest.approx(5.0)
    kp, kv, most = servo_gains(ideal)
    assert kv / kp == pytest.approx(ideal.servos.dynamics.time_constant)
    assert exact(ideal).servos.dynamics.time_constant == pytest.approx(ideal.servos.dynamics.time_constant + 5e-4)


def test_hiding_sets_what_it_names_on_the_rotor_that_it_names():
    ideal = Truth.ideal(QUAD)
    one = hide(QUAD, [("rotor_effectiveness", {"rotor": 2, "factor": 0.8}), ("thrust_scale", {"factor": 0.5})])
    assert one.rotors.thrust_factor == pytest.approx((0.5, 0.5, 0.4, 0.5))
    lag = hide(QUAD, [("rotor_lag", {"extra_time_constant": 0.02})]).rotors
    assert lag.rise_time_constant == pytest.approx(ideal.rotors.rise_time_constant + 0.02)
    assert lag.fall_time_constant == pytest.approx(ideal.rotors.fall_time_constant + 0.02)
    body = hide(
        QUAD, [("inertia_error", {"dyy": 0.001}), ("mass_offset", {"dm": 0.1}), ("com_offset", {"r": [0, 0.01, 0]})]
    )
    assert (body.inertia.xx, body.inertia.yy) == pytest.approx((QUAD.inertia.xx, QUAD.inertia.yy + 0.001))
    assert body.mass == pytest.approx(QUAD.mass + 0.1)
    assert np.subtract(body.center_of_mass, ideal.center_of_mass) == pytest.approx([0.0, 0.01, 0.0])
    windy = gusty(ideal, QUAD, {"speed": 3.0, "height": 5.0, "drag": 0.2}, np.random.default_rng(0)).hidden.disturbance
    assert windy.gusts.drag == pytest.approx(0.2 * QUAD.mass)
    assert windy.gusts.speed == 3.0


def compiled(vehicle, effect, **values):
    """The bodies of a plant with one thing hidden."""
    return Bodies(vehicle, hide(vehicle, [(effect, values)]), 1e-3)


@pytest.mark.parametrize("share", [0.05, 0.3])
def test_a_mass_that_sloshes_swings_at_its_frequency_and_dies_by_its_damping_ratio(share):
    made = compiled(OMAV, "slosh", mass=0.4, place=[0.0, 0.0, -0.05], frequency=1.2, damping_ratio=share).model
    omega = 2.0 * np.pi * 1.2
    for name in ("slosh_x", "slosh_y"):
        joint = made.joint(name)
        assert joint.stiffness[0] / 0.4 == pytest.approx(omega**2)
        assert made.dof_damping[joint.dofadr[0]] / 0.4 == pytest.approx(2.0 * share * omega)


def test_an_arm_that_bends_swings_about_its_root_at_its_frequency():
    made = compiled(QUAD, "flexible_arm", rotor=2, tip_mass=0.05, frequency=7.0, damping_ratio=0.03).model
    omega, moment = 2.0 * np.pi * 7.0, 0.05 * np.sum(np.square(QUAD.rotors[2].position[:2]))
    joint = made.joint("flex")
    assert joint.stiffness[0] / moment == pytest.approx(omega**2)
    assert made.dof_damping[joint.dofadr[0]] / moment == pytest.approx(2.0 * 0.03 * omega)


def test_a_load_hangs_below_and_is_carried():
    truth = hide(QUAD, [("suspended_load", {"mass": 0.2, "length": 0.7})])
    made = Bodies(QUAD, truth, 1e-3).model
    assert made.body("load").ipos == pytest.approx([0.0, 0.0, -0.7])
    command = StaticPlant(QUAD, truth).hold(np.array([0.0, 0.0, 1.0]))
    assert command[2] == pytest.approx((QUAD.mass + 0.2) * QUAD.gravity)


def test_clutter_turns_a_large_vehicle_by_its_arms():
    """Torque of the turbulence: a share of the weight times the rotors' mean distance, and force of the weight."""
    sizes = {
        "rotors": 0.0,
        "inertia": 0.02,
        "center_of_mass": 0.003,
        "force": 0.01,
        "torque": 0.02,
        "correlation_time": 0.5,
    }
    made = clutter(Truth.ideal(QUAD), QUAD, sizes, np.random.default_rng(0))
    weight, reach = QUAD.mass * QUAD.gravity, np.mean([np.linalg.norm(r.position) for r in QUAD.rotors])
    air = made.hidden.disturbance.turbulence
    assert (air.force, air.torque) == pytest.approx((0.01 * weight, 0.02 * weight * reach))
    assert np.linalg.norm(np.subtract(made.center_of_mass, Truth.ideal(QUAD).center_of_mass)) == pytest.approx(0.003)
    off = np.diag(made.inertia.matrix()) / np.diag(QUAD.inertia_matrix()) - 1.0
    assert np.abs(off) == pytest.approx([0.02] * 3)
