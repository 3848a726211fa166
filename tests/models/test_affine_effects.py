"""The effects' columns as functions of the wrench: mechanics where it is exact, nothing where there is nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from infotraj.effects.registry import effect_class
from infotraj.models.affine_effects import affine_effects, affine_prior, hover
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[2] / "config" / "vehicles" / "omav.yaml")
INERTIA = np.diag(VEHICLE.inertia_matrix())


@pytest.fixture(scope="module")
def columns() -> dict[str, np.ndarray]:
    names, weights = affine_effects(VEHICLE)
    return dict(zip(names, weights, strict=True))


def values(weights: np.ndarray, wrench: np.ndarray) -> np.ndarray:
    return weights @ [1.0, *(wrench - hover(VEHICLE))]


@pytest.mark.parametrize("axis", range(3))
def test_a_shifted_centre_of_mass_turns_with_the_force(columns, axis):
    """J dw = -r x f, the force being the commanded one."""
    wrench = np.array([0.8, -1.1, 9.0, 0.0, 0.0, 0.0])
    com_offset = effect_class("com_offset")
    size = com_offset.scale(VEHICLE, com_offset.parameters[0])
    turned = -np.cross(size * np.eye(3)[axis], VEHICLE.mass * wrench[:3]) / INERTIA
    np.testing.assert_allclose(values(columns[f"com_offset r {axis}"], wrench), turned, atol=1e-6)


@pytest.mark.parametrize("axis", range(3))
def test_a_larger_inertia_is_a_slope_against_the_torque(columns, axis):
    """J u = (J + d) (u + slope u)."""
    inertia_error = effect_class("inertia_error")
    name = f"inertia_error d{'xyz'[axis] * 2} 0"
    size = inertia_error.scale(VEHICLE, inertia_error.parameters[axis])
    assert columns[name][axis, 4 + axis] == pytest.approx(INERTIA[axis] / (INERTIA[axis] + size) - 1.0, abs=2e-3)
    others = np.delete(columns[name].reshape(-1), 7 * axis + 4 + axis)
    np.testing.assert_allclose(others, 0.0, atol=2e-3)


def test_a_steady_torque_is_a_constant(columns):
    for axis in range(3):
        weights = columns[f"steady_torque t {axis}"]
        assert weights[axis, 0] > 0.1
        np.testing.assert_allclose(weights[:, 1:], 0.0, atol=1e-9)


def test_all_rotors_weaker_is_a_weaker_thrust(columns):
    """12 rotors off by 15 % each, and all by 10 %: the wrench is linear in the thrusts."""
    rotors = sum(columns[f"rotor_effectiveness {i} factor 0"] for i in range(12))
    np.testing.assert_allclose(rotors / 0.15, columns["thrust_scale factor 0"] / 0.10, atol=1e-6)


def test_what_does_nothing_at_rest_has_no_column(columns):
    for effect in ("linear_drag", "rotor_lag", "gyro_bias", "suspended_load", "angular_damping", "mass_offset"):
        assert not any(name.startswith(effect) for name in columns)


def test_the_prior_is_the_sum_of_the_columns(columns):
    prior, wrench = affine_prior(VEHICLE), np.array([1.0, -2.0, 10.5, 0.7, 0.3, -1.2])
    total = sum(values(weights, wrench) ** 2 for weights in columns.values())
    np.testing.assert_allclose(prior.variance(wrench[None])[:, 0], total)
