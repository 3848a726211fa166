"""A swinging load: its cable's length wherever a fit starts, and how sure that is, on flights of the exact simulation.

Over a whole flight the squared error has local minima beside the true length.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.adding import add
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.linear.candidates import candidates
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.select.around import linearised
from infotraj.diagnosis.select.swinging import shape_of, swung
from infotraj.effects import catalogue
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

FILE = Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml"
CONTENT = yaml.safe_load(FILE.read_text())
VEHICLE = load_vehicle(FILE)
NOISE = {"gyro": 0.003, "accelerometer": 0.05, "position": 0.002, "attitude": 0.001, "velocity": 0.01}


@cache
def flights(mass, length, seed):
    hidden = {"suspended_load": {"mass": mass, "length": length}} if mass else {}
    return tuple(
        Flight(fly(CONTENT, hidden, seconds=16, seed=10 * seed + k, noise=NOISE), {"source": f"{k}"}) for k in range(2)
    )


@pytest.mark.long
@pytest.mark.parametrize(("mass", "length"), [(0.08, 0.5), (0.1, 0.35), (0.1, 2.5)])
def test_a_length_is_looked_for_where_no_start_is_near(mass, length):
    made = flights(mass, length, 1)
    known, _ = candidates({"suspended_load": catalogue()["suspended_load"]}, VEHICLE, made)
    assert shape_of(known[0], VEHICLE) == 1
    found = swung(linearised(observe(Model(VEHICLE), made), (), known), known)
    assert found.variants[-1].start[1] == pytest.approx(length, rel=0.05)


def test_an_effect_without_a_shape_is_not_scanned():
    known, _ = candidates({n: catalogue()[n] for n in ("thrust_scale", "rotor_lag")}, VEHICLE, flights(0.08, 0.5, 1))
    assert [shape_of(c, VEHICLE) for c in known] == [None, None]
    now = linearised(observe(Model(VEHICLE), flights(0.08, 0.5, 1)), (), known)
    assert swung(now, known) is now


def test_a_load_that_the_model_has_is_looked_for_in_its_place():
    """Healthy flights may have one, and a model has no second."""
    known, _ = candidates({"suspended_load": catalogue()["suspended_load"]}, VEHICLE, flights(0.08, 0.5, 1))
    there = Member(known[0], catalogue()["suspended_load"](mass=0.01, length=0.6))
    found = swung(linearised(observe(Model(VEHICLE), flights(0.08, 0.5, 1)), (there,), known), known)
    assert found.point == (there,)


@pytest.mark.long
def test_diagnose_and_add_say_the_length_of_a_long_cable():
    made = flights(0.1, 2.5, 2)
    found = diagnose(Model(VEHICLE), made)
    assert found.supported == ("suspended_load",)
    said = found.finding("suspended_load")
    added = add(Model(VEHICLE), ["suspended_load"], made)
    for numbers in (said.parameters, added.model.effects[0].values):
        assert numbers["length"] == pytest.approx(2.5, rel=0.03)
        assert numbers["mass"] == pytest.approx(0.1, rel=0.1)
    assert np.max(added.after.rmse[:3] / added.before.rmse[:3]) < 0.1


@pytest.mark.long
def test_the_length_holds_over_a_minute():
    table = fly(CONTENT, {"suspended_load": {"mass": 0.1, "length": 0.8}}, seconds=60, seed=0, noise=NOISE)
    added = add(Model(VEHICLE), ["suspended_load"], (Flight(table, {}),))
    assert added.model.effects[0].length == pytest.approx(0.8, rel=0.01)
