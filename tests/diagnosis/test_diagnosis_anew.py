"""Columns of effects outside the model, made again beside a file whose numbers have moved."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.select.around import linearised
from infotraj.diagnosis.select.search import Search
from infotraj.effects import catalogue
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

FILE = Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml"


def candidate(name, *fixed):
    cls = catalogue()[name]
    return Candidate(cls, tuple(p for p in cls.parameters if not p.index), fixed)


@pytest.fixture(scope="module")
def around():
    """The model around the file as it is, and around one with a third more mass and inertia: old columns, and new."""
    vehicle = load_vehicle(FILE)
    flight = Flight(fly(yaml.safe_load(FILE.read_text()), [], seconds=6.0, seed=3), {})
    observation = observe(Model(vehicle), [flight])
    mass, inertia = candidate("mass_offset"), candidate("inertia_error")
    rotors = [candidate("rotor_effectiveness", ("rotor", k)) for k in range(4)]
    known = [mass, inertia, candidate("thrust_scale"), *rotors]
    numbers = {k: getattr(vehicle.inertia, k[1:]) / 3 for k in ("dxx", "dyy", "dzz")}
    first = linearised(observation, [], known)
    point = [Member(mass, mass.cls(dm=vehicle.mass / 3)), Member(inertia, inertia.cls(**numbers))]
    return [first, *(linearised(observation, point, known, like=first, frozen=True, anew=a) for a in (False, True))]


def told_apart(now):
    """The share of the column of all rotors' thrust that the columns of the single rotors do not have together."""
    whole = [i for i, c in enumerate(now.columns) if c.candidate.name == "thrust_scale"]
    each = [i for i, c in enumerate(now.columns) if c.candidate.name == "rotor_effectiveness"]
    gram = now.sums.gram.sum(axis=(0, 1))[1:, 1:]
    weights = np.array([now.columns[whole[0]].scale / now.columns[i].scale for i in each])
    left = gram[whole[0], whole[0]] - 2 * weights @ gram[each, whole[0]] + weights @ gram[np.ix_(each, each)] @ weights
    return left / gram[whole[0], whole[0]]


def length(now, name="thrust_scale"):
    """That of the first column of an effect, by default of all rotors' thrust, weighted."""
    i = next(i for i, c in enumerate(now.columns) if c.candidate.name == name)
    return np.sqrt(now.sums.gram.sum(axis=(0, 1))[1 + i, 1 + i])


def test_the_same_thrust_makes_less_of_a_vehicle_that_is_heavier_than_its_file(around):
    first, old, new = around
    assert length(old) == pytest.approx(length(first))
    assert length(new) == pytest.approx(length(first) * 3 / 4, rel=0.02)


def test_what_acts_on_all_rotors_is_what_acts_on_each(around):
    assert told_apart(around[0]) < 1e-3
    assert told_apart(around[2]) < 1e-3


def test_choices_stay_the_same(around):
    first, _, new = around
    inside = {"mass_offset", "inertia_error"}
    assert sorted(c.label for c in new.choices) == sorted(c.label for c in first.choices)
    assert {c.label for c, v in zip(new.choices, new.variants, strict=True) if v is None} == inside


def test_the_column_of_a_number_that_stays_is_made_anew_beside_others_that_moved(around):
    """Of a vehicle a third heavier a rotor makes three quarters, and its own number has not moved."""
    first = around[0]
    o, known = first.observation, list(dict.fromkeys(c.candidate for c in first.columns))
    mass = candidate("mass_offset")
    rotor = next(c for c in known if c.label == "rotor_effectiveness 0")
    mine = Member(rotor, rotor.at({"factor": 1.1}))
    alone = linearised(o, [mine], known, like=first, frozen=True)
    heavy = [mine, Member(mass, mass.cls(dm=o.vehicle.mass / 3))]
    beside = linearised(o, heavy, known, like=alone, frozen=True)
    fresh = linearised(o, heavy, known)
    force = []
    for x in (alone, beside, fresh):
        at = next(i for i, c in enumerate(x.columns) if c.candidate.label == rotor.label)
        force.append(next(s for s in x.found if s.axis == "fz").values[:, 1 + at])
    np.testing.assert_allclose(force[1], force[2], rtol=1e-9, atol=1e-12)
    assert np.linalg.norm(force[1]) == pytest.approx(0.75 * np.linalg.norm(force[0]), rel=0.02)


def test_a_search_ends_with_columns_beside_the_file_as_it_was_found():
    """Inertia and rotors are off by what files are off by: nothing is missing, and a torque turns the body faster."""
    vehicle, true = load_vehicle(FILE), yaml.safe_load(FILE.read_text())
    noise = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.001, "velocity": 0.005}
    flights = [Flight(fly(true, [], seconds=6.0, seed=k, noise=noise), {}) for k in (3, 4)]
    rotors = [
        r.model_copy(update={"thrust_coefficient": r.thrust_coefficient * f})
        for r, f in zip(vehicle.rotors, (1.05, 0.96, 1.03, 0.96), strict=True)
    ]
    inertia = vehicle.inertia.model_copy(update={"xx": 1.12 * vehicle.inertia.xx, "yy": 0.9 * vehicle.inertia.yy})
    file = vehicle.model_copy(update={"inertia": inertia, "rotors": tuple(rotors)})
    observation = observe(Model(file), flights)
    each = [candidate("rotor_effectiveness", ("rotor", k)) for k in range(4)]
    known = [candidate("inertia_error"), candidate("steady_torque"), *each]
    found = Search(observation, tuple(known), ()).best(linearised(observation, [], known))
    assert {m.candidate.label for m in found.linear.point} > set(found.labels)
    again = linearised(observation, found.linear.point, known, like=found.linear, frozen=True, anew=True)
    assert length(found.linear, "steady_torque") == pytest.approx(length(again, "steady_torque"), rel=0.01)
