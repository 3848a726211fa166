"""Axes that are refused after a fit: what the model said of them before is no less true for a fit that went astray."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.comparing.equation_error import EquationError
from infotraj.diagnosis.gates.refusal import _explained, hardly_predicted, unanswered
from infotraj.effects.actuators import ActuationDelay
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import Vehicle

CONTENT = yaml.safe_load((Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml").read_text())
VEHICLE = Vehicle.model_validate(CONTENT)


@pytest.fixture(scope="module")
def flight():
    return Flight(fly(CONTENT, {}, seconds=6.0, seed=3, noise={"gyro": 0.01}), {"source": "made"})


def axes(doubts):
    return {axis for d in doubts for axis in d.axes}


def test_an_axis_that_the_given_model_explains_is_not_refused_for_a_fit_that_went_astray(flight):
    given, astray = Model(VEHICLE, []), Model(VEHICLE, [ActuationDelay(delay=0.25)])
    assert axes(unanswered(astray, [flight])) >= {"tx"}
    assert not axes(unanswered(astray, [flight], given=given)) & {"tx"}


def test_an_axis_that_no_model_explains_is_refused(flight):
    astray = Model(VEHICLE, [ActuationDelay(delay=0.25)])
    assert axes(unanswered(astray, [flight], given=Model(VEHICLE, [ActuationDelay(delay=0.3)]))) >= {"tx"}


def test_a_force_that_carries_the_weight_is_explained_whatever_its_changes_are_and_a_steady_torque_is_not():
    rng = np.random.default_rng(0)
    measured, scored = 10.0 + 0.1 * rng.standard_normal((300, 6)), np.ones((300, 6), dtype=bool)
    made = [SimpleNamespace(measured=measured, residual=0.3 * rng.standard_normal((300, 6)), scored=scored)]
    assert _explained(made, 2) > 0.99
    assert _explained(made, 4) < 0.0


SOME = dict(red=np.ones(6), unit={}, force_from="", window=0.15, reasons={}, left_out={})


def errors_of(measured, predicted, floor):
    return [EquationError(np.arange(len(measured)) * 0.01, measured, predicted, floor=np.full(6, floor), **SOME)]


def test_a_torque_is_hardly_predicted_where_less_than_half_of_what_is_no_noise_goes_with_it():
    rng = np.random.default_rng(0)
    predicted, noise = rng.standard_normal((2, 3000, 6))

    def found(size, floor):
        made = errors_of(predicted + size * noise, predicted, floor)
        return hardly_predicted(made, made)

    assert found(0.9, 0.01) == {}
    shares = found(1.2, 0.01)
    assert list(shares) == ["tx", "ty", "tz"]
    assert shares["ty"] == pytest.approx(1.0 / (1.0 + 1.2**2), abs=0.04)
    assert found(1.2, 0.5) == {}
    # Of a variance of 10 noise makes 0.81.
    assert found(3.0, 0.9)["tx"] == pytest.approx(0.1 / (1.0 - 0.81 / 10.0), abs=0.02)


def test_a_prediction_that_was_made_small_until_the_error_was_noise_is_none():
    """What was predicted and never came is no smaller torque: as given the error was far above the floor."""
    rng = np.random.default_rng(0)
    wanted, noise = rng.standard_normal((2, 3000, 6))
    given = errors_of(noise, 5.0 * wanted, 0.9)
    made = errors_of(noise, 0.01 * wanted, 0.9)
    shares = hardly_predicted(made, given)
    assert list(shares) == ["tx", "ty", "tz"]
    assert max(shares.values()) < 0.05
    assert hardly_predicted(made, made) == {}
    # A gentle flight of which the rest is noise: what is no noise goes with the prediction, as was not so before.
    right = errors_of(wanted + noise, wanted, 1.0)
    assert hardly_predicted(right, errors_of(wanted + noise, 5.0 * wanted, 1.0)) == {}
    # Without noise, and without motion, nothing is said, and nothing is divided by.
    still = errors_of(np.zeros_like(noise), np.zeros_like(noise), 0.0)
    assert set(hardly_predicted(still, still)) == set()
