"""Axes that are refused after a fit: what the model said of them before is no less true for a fit that went astray."""

from pathlib import Path

import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.gates.refusal import unanswered
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
