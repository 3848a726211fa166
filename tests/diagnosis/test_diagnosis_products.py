"""Products of inertia that a file leaves out: told where flights show them, and nothing else is named for them.

Flights of the exact simulation, which shares no code with the library.
"""

import copy
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import yaml
from exact_simulation import fly
from linear_fits import ROWS, linear_fit

from infotraj.diagnosis import diagnosis
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.judge.products import Products, free_products
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.select.prior import SCALES, Scales, price, spikes
from infotraj.diagnosis.select.search import Search
from infotraj.effects import effect_class
from infotraj.effects.inertia_products import InertiaProducts
from infotraj.effects.laws import BodyLaw
from infotraj.experiment.hidden.file_profiles import wrong_file
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle, parse_vehicle

FILE = Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml"
QUAD = load_vehicle(FILE)
NOISE = {"gyro": 0.002, "accelerometer": 0.03, "position": 0.0002, "attitude": 0.0005, "velocity": 0.003}
PLACE = np.array([0.04, -0.03, -0.05])  # m, of a load of 12 %


def of_a_load(place=PLACE, share=0.12):
    """The vehicle with a load: what it flies as, in the simulation's words."""
    content = yaml.safe_load(FILE.read_text())
    load = share * content["mass"]
    reduced = content["mass"] * load / (content["mass"] + load)
    moments = reduced * (place @ place * np.eye(3) - np.outer(place, place))
    true = copy.deepcopy(content)
    true["inertia"].update(xy=moments[0, 1].item(), xz=moments[0, 2].item(), yz=moments[1, 2].item())
    moved = (load * place / (content["mass"] + load)).tolist()
    changes = {f"d{a}{a}": moments[i, i].item() for i, a in enumerate("xyz")}
    return true, {"mass_offset": {"dm": load}, "com_offset": {"r": moved}, "inertia_error": changes}


def flown(true, hidden, seeds):
    measured = [f"rotor_{i}" for i in range(4)]
    return [Flight(fly(true, hidden, seconds=8.0, seed=k, noise=NOISE).drop(columns=measured), {}) for k in seeds]


def test_they_are_added_to_what_the_file_says_of_them():
    effect = InertiaProducts(dxy=1e-4, dxz=-2e-4, dyz=3e-4)
    before, after = (m.body_law.inertia for m in (Model(QUAD), Model(QUAD, [effect])))
    np.testing.assert_allclose(after - before, [[0, 1e-4, -2e-4], [1e-4, 0, 3e-4], [-2e-4, 3e-4, 0]], atol=1e-18)
    nothing = BodyLaw.declared(QUAD.model_copy(update={"inertia": None}))
    assert effect.body(nothing) is nothing
    assert effect_class("inertia_products") is InertiaProducts
    own = QUAD.model_copy(update={"inertia": QUAD.inertia.model_copy(update={"xz": 7e-5})})
    assert InertiaProducts.in_the_file(own, 1, 0) == ("inertia.xz", 7e-5, 1.0)
    assert InertiaProducts.in_the_file(own, 2, 0) == ("inertia.yz", 0.0, 1.0)


def test_no_body_has_more_than_their_bounds():
    """With all of them at a bound no moment is negative."""
    content = {**yaml.safe_load(FILE.read_text()), "inertia": {"xx": 0.01, "yy": 0.02, "zz": 0.025}}
    vehicle = parse_vehicle(content)
    most = [InertiaProducts.bounds(vehicle, p) for p in InertiaProducts.parameters]
    roots = np.sqrt([0.01 * 0.02, 0.01 * 0.025, 0.02 * 0.025])
    np.testing.assert_allclose(most, [(-0.3 * x, 0.3 * x) for x in roots])
    for signs in ((1, 1, 1), (-1, 1, 1), (-1, -1, -1)):
        values = {p.name: s * x[1] for p, s, x in zip(InertiaProducts.parameters, signs, most, strict=True)}
        assert np.linalg.eigvalsh(InertiaProducts(**values).body(BodyLaw.declared(vehicle)).inertia)[0] > 0


def test_how_far_they_are_off_says_nothing_of_how_far_the_file_is():
    """Five percent of the moments, beside any file; and no name is asked for them."""
    candidate = Candidate(InertiaProducts, InertiaProducts.parameters)
    size = InertiaProducts.scale(QUAD, InertiaProducts.parameters[0])
    off = [spikes([(candidate, size)], Scales(s), 0.01, QUAD)[0] * size for s in SCALES]
    moments = np.sqrt(QUAD.inertia.xx * QUAD.inertia.yy)
    np.testing.assert_allclose(off, 0.05 * moments)
    assert price(candidate, 1, 3) == float("inf")


@pytest.fixture(scope="module")
def loaded():
    true, hidden = of_a_load()
    return true, hidden, diagnose(Model(QUAD), flown(true, hidden, (1, 2, 3)))


def test_a_load_beside_the_middle_is_told_by_its_centre_its_thrust_over_mass_and_its_products(loaded):
    true, hidden, found = loaded
    centre = found.finding("com_offset")
    assert centre.verdict == "Supported"
    np.testing.assert_allclose(centre.parameters["r"], hidden["com_offset"]["r"], atol=0.4e-3)
    ratio = found.finding("mass_offset")
    assert set(ratio.group) == {"mass_offset", "thrust_scale"}
    assert found.finding("thrust_scale").parameters["factor"] == pytest.approx(1 / 1.12, abs=0.01)
    assert set(found.supported) <= {"com_offset", "mass_offset", "thrust_scale"}
    told = {n.name: n for n in found.file}
    for name in ("xy", "xz", "yz"):
        n = told[f"inertia.{name}"]
        assert abs(n.value - true["inertia"][name]) < 3.0 * n.standard_error
        assert n.standard_error < 0.2 * abs(n.value)
    assert not any("moment_constant" in name for name in told)
    assert not found.unexplained.found


def test_without_a_load_no_product_is_told():
    content = yaml.safe_load(FILE.read_text())
    found = diagnose(Model(QUAD), flown(content, {}, (4, 5)))
    assert found.supported == ()
    assert not any(n.name.startswith("inertia.") for n in found.file)
    assert "inertia_products" not in found.beside


def test_what_predicts_too_little_beside_them_is_named_no_more_and_of_what_is_named_alone(monkeypatch):
    """Of two effects one makes all of the residual that is no noise, the other 4 % of what is left."""

    def rows(rng, _):
        x = rng.standard_normal((ROWS, 3))
        x[:, 0] += x[:, 1] + 0.3 * x[:, 2]
        return x

    both, candidate = ["linear_drag", "imu_misalignment"], Candidate(InertiaProducts, InertiaProducts.parameters)
    search, beside = linear_fit(both, rows, both)
    told: Any = object()
    products = Products(cast(Any, search), candidate, {id(told): (told, beside)})
    monkeypatch.setattr(Products, "at", lambda self, told: search)
    explained = products.explain(told, both, np.random.default_rng(0))
    assert explained.keys() == {"imu_misalignment"}
    little = "beside products of inertia other than the file's it takes [345]% of the error off flights"
    assert re.match(little, explained["imu_misalignment"])
    assert products.explain(told, ["linear_drag"], np.random.default_rng(0)) == {}


@pytest.mark.parametrize(("odds", "free"), [(19.0, False), (21.0, True)])
def test_they_are_free_where_flights_are_twenty_times_as_probable_with_them(monkeypatch, odds, free):
    """Tempered by how much the data scatter, here as their noise says; never beside healthy flights."""
    _, whole = linear_fit(["linear_drag"], lambda rng, _: rng.standard_normal((ROWS, 2)), ["linear_drag"])
    more = SimpleNamespace(worth=whole.worth + float(np.log(odds)))
    monkeypatch.setattr(Products, "beside", lambda self, told: more)
    monkeypatch.setattr("infotraj.diagnosis.judge.products.overdispersion", lambda made: (1.0, None))
    inertia = effect_class("inertia_error")
    known = (Candidate(inertia, inertia.parameters),)
    observation: Any = SimpleNamespace(healthy=None)
    assert (free_products(Search(observation, known, ()), whole) is not None) == free
    assert free_products(Search(observation, (), ()), whole) is None  # what nothing can be tested on
    own = Member(known[0], inertia())
    held = (Member(Candidate(InertiaProducts, InertiaProducts.parameters), InertiaProducts()),)
    other = (Candidate(effect_class("linear_drag"), effect_class("linear_drag").parameters),)
    # In the model already: moments of which it has some are asked about, products themselves are not asked twice.
    assert (free_products(Search(observation, other, (own,)), whole) is not None) == free
    assert free_products(Search(observation, known, held), whole) is None
    observation.healthy = object()
    assert free_products(Search(observation, known, ()), whole) is None


@pytest.mark.long
def test_they_are_told_where_nothing_is_missing_and_no_moment_constant_is_below_zero(monkeypatch):
    true = yaml.safe_load(FILE.read_text())
    true["inertia"].update(xz=6e-4, xy=3e-4)
    flights = flown(true, {}, (6, 7))
    found = diagnose(Model(QUAD), flights)
    assert found.supported == ()
    told = {n.name: n.value for n in found.file if n.name.startswith(("inertia", "rotor"))}
    assert told == {"inertia.xy": pytest.approx(3e-4, rel=0.05), "inertia.xz": pytest.approx(6e-4, rel=0.05)}
    assert "inertia_products" in found.beside  # the search went on with them
    # As it is without them, which is why they are asked about.
    monkeypatch.setattr("infotraj.diagnosis.diagnosis.free_products", lambda search, whole: None)
    without = diagnose(Model(QUAD), flights)
    assert any("moment_constant" in n.name and n.value < 0.0 for n in without.file)


@pytest.mark.long
def test_where_they_take_a_name_what_is_left_is_judged_beside_them(monkeypatch):
    """As if the mass and the thrust had stood for them: both are Plausible, and products are in the model then."""
    true, hidden = of_a_load()
    asked: list[object] = []

    def once(self, told, names, rng):
        asked.append(names)
        return {n: "they explain it" for n in ("mass_offset", "thrust_scale") if n in names}

    monkeypatch.setattr(Products, "explain", once)
    found = diagnose(Model(QUAD), flown(true, hidden, (1, 2, 3)))
    assert len(asked) == 1
    assert {found.finding(n).verdict for n in ("mass_offset", "thrust_scale")} == {"Plausible"}
    assert "they explain it" in {found.finding(n).reason for n in ("mass_offset", "thrust_scale")}
    assert found.supported == ("com_offset",)
    assert "inertia_products" in found.beside
    (given,) = (e for e in found.model.effects if e.name == "inertia_products")
    assert given.dxz == pytest.approx(true["inertia"]["xz"], rel=0.2)
    assert not found.unexplained.found


def test_products_that_the_model_has_stay_in_it_against_healthy_flights():
    inertia = effect_class("inertia_error")
    known = [Candidate(inertia, inertia.parameters)]
    own = InertiaProducts(dxy=1e-4, dxz=0.0, dyz=0.0)
    healthy = SimpleNamespace(effects={"inertia_products": own})
    observation = cast(Any, SimpleNamespace(healthy=healthy, vehicle=QUAD, flights=[]))
    (member,) = diagnosis._healthy_members(observation, known)
    assert member.effect is own


@pytest.mark.long
def test_a_weight_on_an_arm_is_no_weak_rotor_against_healthy_flights():
    true, hidden = of_a_load(np.array([0.11, 0.09, -0.02]), 0.06)
    file = wrong_file(QUAD, "10%", np.random.default_rng(4))
    healthy = flown(yaml.safe_load(FILE.read_text()), {}, (11, 12, 13))
    found = diagnose(Model(file), flown(true, hidden, (14, 15)), reference=healthy)
    told = {x for f in found.findings if f.verdict in ("Supported", "Not separable") for x in f.group}
    assert "com_offset" in told
    assert told <= {"com_offset", "mass_offset", "thrust_scale", "battery_sag", "inertia_error"}
    centre = found.finding("com_offset")
    moved = np.subtract(centre.parameters["r"], found.healthy_numbers(centre)["parameters"]["r"])
    expected = np.array(hidden["com_offset"]["r"])
    assert np.all(np.abs(moved - expected) < 3.0 * np.array(centre.standard_errors["r"]) + 0.05 * np.abs(expected))


@pytest.mark.long
def test_an_imu_that_is_turned_is_named_beside_them():
    true = yaml.safe_load(FILE.read_text())
    true["inertia"].update(xz=6e-4, xy=3e-4)
    found = diagnose(Model(QUAD), flown(true, {"imu_misalignment": {"rotvec": [0.0, 0.03, 0.0]}}, (6, 7)))
    assert found.supported == ("imu_misalignment",)
    np.testing.assert_allclose(found.finding("imu_misalignment").parameters["rotvec"], [0.0, 0.03, 0.0], atol=0.004)
