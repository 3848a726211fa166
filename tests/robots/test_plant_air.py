"""Rotors and air: signs and sizes against their equations, and drag that only takes energy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from infotraj.dynamics.actuators import rotor_frames
from infotraj.robots.plant import aerodynamics
from infotraj.robots.plant.truth import Air, Interference, Truth
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle("config/vehicles/omav.yaml")
IDEAL = Truth.ideal(OMAV)
HOVER = 677.0  # rad/s


def placed(truth, tilt):
    rotors, axes = aerodynamics.rotor_table(OMAV, truth), aerodynamics.tilt_axes(OMAV)
    position, direction = np.empty((12, 3)), np.empty((12, 3))
    aerodynamics.frames(rotors, axes, np.asarray(tilt, dtype=float), position, direction)
    return rotors, position, direction


def thrust(air, tilt, velocity=(0, 0, 0), rate=(0, 0, 0)):
    truth = IDEAL.model_copy(update={"air": air})
    rotors, position, direction = placed(truth, tilt)
    result = np.empty(12)
    aerodynamics.thrusts(
        rotors, aerodynamics.air_table(truth), np.full(12, HOVER**2), np.array(velocity, dtype=float),
        np.array(rate, dtype=float), position, direction, np.empty(12), result,
    )  # fmt: skip
    return result


def drag(air, tilt, velocity, rate):
    truth = IDEAL.model_copy(update={"air": air})
    rotors, position, direction = placed(truth, tilt)
    wrench = np.empty(6)
    aerodynamics.drag(
        rotors, aerodynamics.air_table(truth), np.full(12, HOVER**2), np.array(velocity, dtype=float),
        np.array(rate, dtype=float), position, direction, wrench,
    )  # fmt: skip
    return wrench


def test_a_rotor_speeds_up_and_slows_down_by_lags_of_their_own():
    lags = IDEAL.rotors.model_copy(update={"rise_time_constant": 0.02, "fall_time_constant": 0.06})
    rotors = aerodynamics.rotor_table(OMAV, IDEAL.model_copy(update={"rotors": lags}))
    speed, command = np.full(12, 500.0), np.repeat([600.0, 400.0], 6)
    aerodynamics.spin_up(rotors, command, 0.01, speed, np.empty(12))
    gap = -100.0 * np.exp(-0.01 / 0.02), 100.0 * np.exp(-0.01 / 0.06)
    np.testing.assert_allclose(speed, command + np.repeat(gap, 6), rtol=1e-12)


def test_quadratic_drag_pulls_back_whichever_way_the_body_flies():
    there, back = (
        drag(Air(quadratic_drag=(0.1, 0.2, 0.3)), np.zeros(6), s * np.array([2.0, 1.0, 3.0]), np.zeros(3))
        for s in (1, -1)
    )
    np.testing.assert_allclose(there[:3], [-0.4, -0.2, -2.7], rtol=1e-12)
    np.testing.assert_allclose(back[:3], -there[:3], rtol=1e-12)


def test_frames_are_those_of_the_model():
    tilt = np.random.default_rng(0).uniform(-3, 3, 6)
    _, position, direction = placed(IDEAL, tilt)
    expected = rotor_frames(OMAV, tilt)
    np.testing.assert_allclose(position, expected[0], atol=1e-14)
    np.testing.assert_allclose(direction, expected[1], atol=1e-14)


def test_the_coaxial_loss_is_the_lower_rotors():
    np.testing.assert_allclose(thrust(Air(coaxial_loss=0.1), np.zeros(6)), 7.2e-6 * HOVER**2 * np.repeat([1.0, 0.9], 6))


def test_a_wake_lowers_the_thrust_of_the_neighbour_it_blows_at_and_of_no_other():
    # Arm 2 stands at 30 deg, its neighbours 4 at -30 deg and 1 at 90 deg.
    air = Air(interference=Interference(strength=0.3, spread=0.2))
    level = thrust(air, np.zeros(6))
    for angle in (-1.2, 1.2):
        tilt = np.zeros(6)
        tilt[2] = angle
        _, position, direction = placed(IDEAL, tilt)
        towards = {arm: -direction[2] @ (position[arm] - position[2]) for arm in (1, 4)}
        hit, spared = (1, 4) if towards[1] > towards[4] else (4, 1)
        change = thrust(air, tilt) / level - 1.0
        assert change[[hit, hit + 6]].max() < -0.01
        assert change[[spared, spared + 6]].min() > -1e-3


def test_the_wakes_strength_at_one_place():
    # Right on the wake's axis only the distance counts.
    air = Air(interference=Interference(strength=0.3, spread=0.2))
    truth = IDEAL.model_copy(update={"air": air})
    rotors = aerodynamics.rotor_table(OMAV, truth)[:2].copy()
    rotors["arm"] = 0, 1
    position, direction = np.array([[0, 0, 0.3], [0, 0, 0.1]]), np.tile([0.0, 0.0, 1.0], (2, 1))
    loss = np.empty(2)
    aerodynamics.wake_losses(rotors, aerodynamics.air_table(truth), np.array([5.0, 5.0]), position, direction, loss)
    R, s = 0.1143, 0.2
    expected = 0.3 * s / np.hypot(s, R) * (0.7 * R / (0.7 * R + 0.2 * s)) ** 2
    np.testing.assert_allclose(loss, [0.0, expected], rtol=1e-12)


def test_axial_inflow_takes_k_w_times_the_climb():
    k = 2e-4
    np.testing.assert_allclose(
        thrust(Air(axial_inflow=k), np.zeros(6), velocity=(0, 0, 1.5)), 7.2e-6 * HOVER**2 - k * HOVER * 1.5
    )
    rolling = thrust(Air(axial_inflow=k), np.zeros(6), rate=(1.0, 0, 0))
    y = np.array([r.position[1] for r in OMAV.rotors])
    np.testing.assert_allclose(rolling, 7.2e-6 * HOVER**2 - k * HOVER * y)


def test_rotor_drag_is_across_the_axes_only():
    k = 1e-4
    np.testing.assert_allclose(drag(Air(rotor_drag=k), np.zeros(6), (0, 0, 2), (0, 0, 0)), 0.0, atol=1e-12)
    sideways = drag(Air(rotor_drag=k), np.zeros(6), (2, 0, 0), (0, 0, 0))
    assert sideways[0] == pytest.approx(-12 * k * HOVER * 2)


numbers = st.floats(-5, 5)
vectors = st.tuples(numbers, numbers, numbers)


@settings(max_examples=60, deadline=None)
@given(velocity=vectors, rate=vectors, tilt=st.tuples(*[st.floats(-3, 3)] * 6))
def test_drag_never_gives_energy(velocity, rate, tilt):
    air = Air(
        rotor_drag=1e-4, linear_drag=(0.1, 0.2, 0.3), quadratic_drag=(0.1, 0.2, 0.1), angular_damping=(0.05, 0.03, 0.1)
    )
    assert drag(air, tilt, velocity, rate) @ np.array([*velocity, *rate]) <= 1e-12
