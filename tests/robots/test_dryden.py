"""Gusts have the sizes, lengths and correlations of MIL-F-8785C, and act on what acts on the air's velocity."""

from __future__ import annotations

import numpy as np
import pytest

from infotraj.robots.plant.disturbances import Disturbances
from infotraj.robots.plant.dryden import FOOT, scales, velocities
from infotraj.robots.plant.hidden import Disturbance, Gusts
from infotraj.robots.plant.hiding import gusty, hide
from infotraj.robots.plant.plant import Plant
from infotraj.vehicle import load_vehicle

QUAD = load_vehicle("config/vehicles/quadrotor.yaml")
WIND = Gusts(speed=5.0)


def test_the_scales_are_the_standard_s():
    sigma, length = scales(Gusts(speed=10.0, height=1000 * FOOT))
    # at 1000 ft the air is isotropic: sigma = 0.1 W_20 and L = 1000 ft, all alike
    assert sigma == pytest.approx([1.0, 1.0, 1.0], rel=1e-6)
    assert length == pytest.approx([1000 * FOOT] * 3, rel=1e-6)
    low, short = scales(WIND)
    assert low[0] == low[1] > low[2] == pytest.approx(0.5)
    assert short[2] == pytest.approx(6.0)


def test_gusts_are_as_large_and_as_long_as_they_should_be():
    sigma, length = scales(WIND)
    rng = np.random.default_rng(2)
    made = np.stack([velocities(WIND, 4000, 0.05, rng) for _ in range(60)])
    assert made.std(axis=(0, 1)) == pytest.approx(sigma, rel=0.06)
    # stationary from the first row
    assert made[:, 0].std(axis=0) == pytest.approx(sigma, rel=0.35)
    for axis in range(3):
        x = made[..., axis]
        for rows in (4, 20, 60):
            lag = rows * 0.05 / (length[axis] / WIND.speed)
            right = np.exp(-lag) * (1.0 if axis == 0 else 1.0 - 0.5 * lag)
            assert np.mean(x[:, rows:] * x[:, :-rows]) / sigma[axis] ** 2 == pytest.approx(right, abs=0.08)


def test_gusts_do_not_depend_on_the_row_s_period():
    sizes = [np.diff(velocities(WIND, n, p, np.random.default_rng(1)), axis=0)[:, 2].std() / np.sqrt(p)
             for n, p in ((40000, 0.005), (20000, 0.01))]  # fmt: skip
    assert sizes[0] == pytest.approx(sizes[1], rel=0.05)


def test_the_wind_turns_with_its_heading():
    east, north = (velocities(Gusts(speed=5.0, heading=h), 50, 0.1, np.random.default_rng(3)) for h in (0.0, np.pi / 2))
    np.testing.assert_allclose(north[:, 1], east[:, 0], atol=1e-12)
    np.testing.assert_allclose(north[:, 0], -east[:, 1], atol=1e-12)


def test_gusts_push_and_are_seen_by_drag():
    truth = gusty(hide(QUAD, [("linear_drag", {"d": [0.2, 0.2, 0.2]})]), QUAD,
                  {"speed": 8.0, "height": 6.0, "drag": 0.3}, np.random.default_rng(0))  # fmt: skip
    assert truth.hidden.disturbance.gusts.drag == pytest.approx(0.24)
    plant = Plant(QUAD, truth)
    plant._disturbances = Disturbances(truth.hidden.disturbance, 100, 0.005, np.random.default_rng(5))
    plant.reset(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), np.full(4, 1144.0), np.zeros(0))
    wind = plant._disturbances.wind
    np.testing.assert_allclose(plant.bodies.applied[:3], (0.2 + 0.24) * wind, atol=1e-9)


def test_still_air_stays_still():
    assert not Disturbances(Disturbance(), 10, 0.005, np.random.default_rng(0)).wind.any()
