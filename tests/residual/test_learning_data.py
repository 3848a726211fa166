"""From a flight to learning data: one filter on both sides, exact for held commands, errors that say what to do."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from infotraj.dynamics import rigid_body
from infotraj.errors import InputError
from infotraj.evaluation.angular_acceleration import prediction_error, tracking_error
from infotraj.flight import Flight
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.learning_data import Slope, learning_data
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle(Path(__file__).parents[2] / "config" / "vehicles" / "omav.yaml")


def held_flight(residual=(0.0, 0.0, 0.0), rows=600, noise=0.0):
    """A vehicle whose angular acceleration is, from row to row, exactly the commanded torque plus `residual`."""
    rng = np.random.default_rng(0)
    dt, inertia = 0.005, OMAV.inertia_matrix()
    t = dt * np.arange(rows)
    torque = np.stack([np.sin(3 * t), np.cos(5 * t), 0.4 * np.sin(2 * t)], axis=1) * np.diag(inertia)
    rate = np.zeros((rows, 3))
    for k in range(rows - 1):  # many small Euler steps: the tests do not trust the library's integrator
        w = rate[k]
        for _ in range(20):
            w = w + dt / 20 * np.linalg.solve(
                inertia, torque[k] + np.diag(inertia) * residual - np.cross(w, inertia @ w)
            )
        rate[k + 1] = w
    columns = {"t": t, "cmd_fx": 0 * t, "cmd_fy": 0 * t, "cmd_fz": 39.6 + 0 * t}
    columns |= dict(zip(("cmd_tx", "cmd_ty", "cmd_tz"), torque.T, strict=True))
    columns |= dict(zip(("wx", "wy", "wz"), (rate + noise * rng.standard_normal(rate.shape)).T, strict=True))
    columns |= dict(
        zip(("demand_alphax", "demand_alphay", "demand_alphaz"), (torque / np.diag(inertia)).T, strict=True)
    )
    return Flight(pd.DataFrame(columns))


def test_the_slope_and_its_mean_are_the_same_filter():
    slope, rng = Slope.over(0.15, 0.005), np.random.default_rng(0)
    held = rng.standard_normal((300, 2))
    rate = np.concatenate([np.zeros((1, 2)), np.cumsum(0.005 * held, axis=0)])[:-1]
    np.testing.assert_allclose(slope.derivative(rate), slope.mean(held), atol=1e-10)


def test_noise_of_the_slope_is_that_of_a_least_squares_line():
    slope, rng = Slope.over(0.15, 0.005), np.random.default_rng(1)
    white = 0.01 * rng.standard_normal((100_000, 1))
    t = slope.dt * np.arange(-slope.half, slope.half + 1)
    assert slope.derivative(white).std() == pytest.approx(0.01 / np.sqrt(t @ t), rel=0.05)


def test_a_constant_residual_is_recovered():
    wanted = np.array([0.7, -0.4, 0.2])
    data = learning_data(held_flight(wanted), OMAV, response_of_model=False)
    np.testing.assert_allclose(data.outputs, np.broadcast_to(wanted, data.outputs.shape), atol=0.01)
    np.testing.assert_allclose(data.inputs[:, 2], 39.6 / OMAV.mass)
    assert data.t[0] >= 0.5


def test_tracking_error_is_the_residual_that_the_demand_did_not_expect():
    errors = tracking_error(held_flight((0.5, 0.0, -0.25)), OMAV)
    np.testing.assert_allclose(errors.by_axis, [0.5, 0.0, 0.25], atol=0.01)
    assert errors.mean == pytest.approx(0.25, abs=0.01)


def test_prediction_error_of_a_model_that_knows_is_nothing():
    data = learning_data(held_flight((0.5, 0.0, -0.25)), OMAV, response_of_model=False)
    knows = GaussianProcess.empty(np.ones((3, 6)), np.ones(3), np.ones(3), [0.5, 0.0, -0.25])
    assert prediction_error(knows, data).mean < 0.01
    assert prediction_error(None, data).mean == pytest.approx(0.25, abs=0.01)


def test_the_models_response_is_used_when_asked_for():
    flight = held_flight()
    speeds = {f"cmd_rotor_{i}": 677.0 + 100.0 * (flight.t > 1.0) for i in range(12)}
    tilts = {f"cmd_tilt_{i}": 0.0 * flight.t for i in range(6)}
    data = learning_data(Flight(flight.table.assign(**speeds, **tilts)), OMAV, response_of_model=True)
    after = data.inputs[np.searchsorted(data.t, 1.005 + 0.075 + 5 * 0.01875), 2]
    before = data.inputs[np.searchsorted(data.t, 1.0 - 0.08), 2]
    full = 12 * 7.2e-6 * 777.0**2 / rigid_body.scale(OMAV)[2]
    assert before == pytest.approx(12 * 7.2e-6 * 677.0**2 / OMAV.mass)
    assert 0.9 * full < after < full


def test_a_gap_is_named_with_its_time():
    table = held_flight().table.drop(index=range(200, 240)).reset_index(drop=True)
    with pytest.raises(InputError, match=r"a gap at 0\.995 s"):
        learning_data(Flight(table), OMAV, response_of_model=False)
