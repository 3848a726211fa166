"""The vehicle files that ship: they load, say where their numbers are from, and are what their sources say."""

import re
import textwrap
from pathlib import Path

import numpy as np
import pytest
import yaml

from infotraj.datasets.location import find_dataset, how_to_get
from infotraj.importing import import_log
from infotraj.vehicle import load_vehicle, parse_vehicle

VEHICLES = Path(__file__).parents[1] / "config" / "vehicles"


@pytest.mark.parametrize("path", sorted(VEHICLES.glob("*.yaml")), ids=lambda p: p.stem)
def test_every_vehicle_file_loads_and_says_where_its_numbers_come_from(path):
    vehicle = load_vehicle(path)
    assert vehicle.name == path.stem
    for line in path.read_text().splitlines():
        if line.startswith(("mass:", "inertia:")):
            assert "[" in line.partition("#")[2] or "assumed" in line, line


def test_the_examples_of_the_guide_are_valid_one_for_each_input():
    blocks = re.findall(
        r"(?m)^    name: by_\w+\n(?:    .*\n)+", (VEHICLES.parents[1] / "docs" / "vehicle.md").read_text()
    )
    vehicles = [parse_vehicle(yaml.safe_load(textwrap.dedent(b))) for b in blocks]
    assert [v.name for v in vehicles] == ["by_speed", "by_throttle", "by_thrust", "by_wrench"]
    assert [v.rotors[0].input for v in vehicles[:3]] == ["speed", "throttle", "thrust"]
    assert vehicles[3].inputs == "wrench"


def test_the_x8_is_the_one_of_its_mixer_turned_into_forward_left_up():
    vehicle = load_vehicle(VEHICLES / "acsl_x8.yaml")
    signs = ["-++", "++-", "+-+", "---", "+++", "-+-", "--+", "+--"]
    turn = np.diag([1.0, -1.0, -1.0])
    for rotor, (roll, pitch, yaw) in zip(vehicle.rotors, signs, strict=True):
        place, push = turn @ rotor.position, turn @ rotor.axis
        torque = np.cross(place, push) - rotor.spin * rotor.moment_constant * push
        assert [np.sign(x) for x in torque] == [float(f"{s}1") for s in (roll, pitch, yaw)]
        np.testing.assert_allclose(np.abs(torque), [0.1083450, 0.0881269, 0.01])
    down = np.array([[2.271990e-2, -6.557e-6, -1.003498e-3], [-6.557e-6, 2.202047e-2, 5.6584e-6],
                     [-1.003498e-3, 5.6584e-6, 1.614693e-2]])  # fmt: skip
    np.testing.assert_allclose(turn @ down @ turn, vehicle.inertia_matrix())
    pairs = [(k, j) for k in range(4) for j in range(4, 8) if vehicle.rotors[k].position == vehicle.rotors[j].position]
    assert len(pairs) == 4
    assert all(vehicle.rotors[k].spin == -vehicle.rotors[j].spin for k, j in pairs)


def test_motors_stand_and_turn_as_their_firmwares_number_them():
    corners = {"betaflight_5inch": "-x-y +x-y -x+y +x+y", "crazypad": "+x-y -x-y -x+y +x+y"}
    spins = {"betaflight_5inch": (-1, 1, 1, -1), "crazypad": (1, -1, 1, -1)}
    for name, wanted in corners.items():
        rotors = load_vehicle(VEHICLES / f"{name}.yaml").rotors
        found = [f"{'+' if r.position[0] > 0 else '-'}x{'+' if r.position[1] > 0 else '-'}y" for r in rotors]
        assert found == wanted.split()
        assert tuple(r.spin for r in rotors) == spins[name]


def test_the_two_files_of_crazypad_are_one_vehicle_by_what_was_asked_and_by_what_was_given():
    asked, given = (yaml.safe_load((VEHICLES / f"crazypad{kind}.yaml").read_text()) for kind in ("_requested", ""))
    thrusts = {tuple(rotor.pop("thrust_polynomial")) for rotor in asked["rotors"]}
    assert thrusts == {(0.0, 0.14715, 0.0)}
    for rotor in given["rotors"]:
        del rotor["thrust_polynomial"]
    del asked["name"], given["name"]
    assert asked == given


def test_what_was_given_to_crazypads_motors_follows_from_what_was_asked_as_its_file_says():
    """The firmware's compensation of the battery, in which what is asked is a thrust: logs that hold both."""
    folder = find_dataset("crazypad")
    if folder is None:
        pytest.skip(how_to_get("crazypad"))
    log = folder / "motor_data" / "normal_flight" / "E8_log00"
    fields = {"rotor_command": {"fields": [f"motor.m{k}" for k in (1, 2, 3, 4)]}}
    given, asked = (import_log(log, "crazyflie", settings=s) for s in (None, fields))
    thrust = 60.0 * asked.numbered("cmd_rotor_") * 65535 / 65536  # g
    pwm = (0.088 * thrust - 0.0006239 * thrust**2) / given.get("battery")
    flown = given.get("pz")[:, 0] > 0.3
    ratio = given.numbered("cmd_rotor_")[flown] / pwm[flown]
    np.testing.assert_allclose(np.median(ratio), 1.0, atol=2e-4)
    assert np.quantile(np.abs(ratio - 1.0), 0.9) < 5e-4, np.quantile(np.abs(ratio - 1.0), [0.5, 0.9, 0.99])
