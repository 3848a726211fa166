"""What `vehicle check` says of a file by itself."""

from pathlib import Path

import pytest
import yaml

from infotraj.describing.alone import alone
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
        (lambda i, r: {"spin": 1}, "4 rotors turn counter-clockwise and 0 clockwise"),
    ],
    ids=["unit of the coefficient", "rpm for rad/s", "two hubs in one place", "spins"],
)
def test_what_no_vehicle_can_be_is_doubted(change, says):
    assert any(says in sentence for sentence in doubts(with_rotors(change)))
