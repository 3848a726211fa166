"""What a residual model is told before any flight, and that it is not lost on the way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from infotraj.experiment.common.config import Learning
from infotraj.experiment.paper.learning import known, learn
from infotraj.residual.learning_data import LearningData
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[2] / "config" / "vehicles" / "omav.yaml")


@pytest.fixture(scope="module")
def held() -> LearningData:
    """A flight whose feedback holds a disturbance of 0.2 rad/s^2 that is no function of the command (servo play): it
    commands minus it, and little else. Its outputs are then nearly minus its commanded torques."""
    rng = np.random.default_rng(0)
    disturbance = np.cumsum(rng.normal(0.0, 0.1, (300, 3)), axis=0)
    disturbance = 0.2 * (disturbance - disturbance.mean(axis=0)) / disturbance.std(axis=0)
    asked = rng.normal(0.0, 0.02, (300, 3))
    force = np.array([0.0, 0.0, 9.81]) + rng.normal(0.0, 0.3, (300, 3))
    return LearningData(
        0.1 * np.arange(300, dtype=np.float64), np.concatenate([force, asked - disturbance], axis=1), disturbance
    )


def slopes(learning: Learning, data: LearningData) -> np.ndarray:
    model = learn(data, 20, learning, np.random.default_rng(1), affine=known(learning, VEHICLE))
    at, step = data.inputs.mean(axis=0), 1e-5 * np.eye(6)[3:]
    return np.diag(model.mean(at + step) - model.mean(at - step)) / 2e-5


def test_effects_explain_less_of_what_feedback_holds(held):
    """The inversion multiplies the loop gain by 1 / (1 + slope): without bound at -1."""
    assert (1.0 + slopes(Learning(), held) < 0.0).all()
    assert (1.0 + slopes(Learning(prior="physics"), held) > 0.08).all()


def test_a_model_that_learns_on_keeps_its_prior(held, tmp_path):
    learning, rng = Learning(prior="physics", restarts=0), np.random.default_rng(2)
    first = learn(held, 10, learning, rng, affine=known(learning, VEHICLE))
    first.save(tmp_path / "prior.npz")
    second = learn(held, 10, learning, rng, type(first).load(tmp_path / "prior.npz"))
    assert second.n == 20
    np.testing.assert_array_equal(second.affine.covariance, first.affine.covariance)
    assert known(Learning(), VEHICLE) is None
