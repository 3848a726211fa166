"""What `vehicle check` says of a file by itself."""

from pathlib import Path

import pytest
import yaml

from infotraj.describing.alone import alone
from infotraj.describing.guesses import thrust_coefficient_of_propeller
from infotraj.vehicle import load_vehicle, parse_vehicle

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"
CONTENT = yaml.safe_load((VEHICLES / "quadrotor.yaml").read_text())


def doubts(content):
    return [one.sentence for one in alone(parse_vehicle(content)) if not one.good]


def with_rotors(change):
    return {**CONTENT, "rotors": [{**r, **change(i, r)} for i, r in enumerate(CONTENT["rotors"])]}


@pytest.mark.parametrize("path", sorted(VEHICLES.glob("*.yaml")), ids=lambda p: p.stem)
def test_the_shipped_files_are_possible(path):
    assert all(one.good for one in alone(load_vehicle(path)))


def test_how_it_hovers_is_said_in_both_units():
    first = alone(parse_vehicle(CONTENT))[0].sentence
    total = sum(r["thrust_coefficient"] for r in CONTENT["rotors"])
    speed = (CONTENT["mass"] * CONTENT["gravity"] / total) ** 0.5
    assert f"{speed:.4g} rad/s" in first
    assert f"{speed * 60 / 6.283185307:.4g} rpm" in first


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda i, r: {"thrust_coefficient": 100 * r["thrust_coefficient"]}, "thrust_coefficient"),
        (lambda i, r: {"thrust_coefficient": r["thrust_coefficient"] / 91}, "mass or thrust_coefficient?"),
        (lambda i, r: {"position": CONTENT["rotors"][0]["position"]} if i == 1 else {}, "stand in one place"),
        (lambda i, r: {"max_speed": 300.0}, "it cannot hover: at max_speed its rotors lift"),
        (lambda i, r: {"moment_constant": 5.0} if i == 1 else {}, "moment_constant 5 m: 0.01 to 1 diameters are usual"),
        (lambda i, r: {"time_constant": 30.0} if i == 1 else {}, "time_constant 30 s: at most 1 s is usual"),
        (lambda i, r: {"spin": 1}, "4 rotors turn counter-clockwise and 0 clockwise"),
    ],
    ids=["unit of the coefficient", "rpm for rad/s", "two hubs in one place", "max speed", "torque", "lag", "spins"],
)
def test_what_no_vehicle_can_be_is_doubted(change, says):
    assert any(says in sentence for sentence in doubts(with_rotors(change)))


def test_moments_that_no_body_has_are_doubted():
    inertia = {**CONTENT["inertia"], "zz": 1.1 * (CONTENT["inertia"]["xx"] + CONTENT["inertia"]["yy"])}
    assert any("no body has this inertia" in sentence for sentence in doubts({**CONTENT, "inertia": inertia}))


@pytest.mark.parametrize(("factor", "doubted"), [(4.0, False), (6.0, True), (0.25, False), (0.16, True)])
def test_a_propeller_pushes_within_a_factor_of_five_of_others_of_its_diameter(factor, doubted):
    radius = CONTENT["rotors"][0]["radius"]
    usual = thrust_coefficient_of_propeller(2 * radius).value
    said = doubts(with_rotors(lambda i, r: {"thrust_coefficient": factor * usual}))
    assert any("propellers of" in sentence for sentence in said) == doubted


@pytest.mark.parametrize(("tip", "good"), [(9.0, False), (11.0, True), (240.0, True), (260.0, False)])
def test_tips_move_between_10_and_250_m_per_s(tip, good):
    """In hover a rotor carries a quarter of the weight at tip / radius."""
    radius = CONTENT["rotors"][0]["radius"]
    weight = CONTENT["mass"] * CONTENT["gravity"]
    first = alone(parse_vehicle(with_rotors(lambda i, r: {"thrust_coefficient": weight / 4 / (tip / radius) ** 2})))[0]
    assert f"tips at {tip:.3g} m/s" in first.sentence
    assert first.good == good


@pytest.mark.parametrize(("apart", "doubted"), [(0.01, True), (0.05, False)])
def test_two_hubs_stand_in_one_place_within_a_fiftieth_of_an_arm(apart, doubted):
    first = CONTENT["rotors"][0]["position"]
    reach = sum(x**2 for x in first) ** 0.5
    beside = [first[0] + apart * reach, *first[1:]]
    said = doubts(with_rotors(lambda i, r: {"position": beside} if i == 1 else {}))
    assert any("stand in one place" in sentence for sentence in said) == doubted
