"""The vehicle file: the omav's numbers, and one line for everything that can be wrong in a file."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from infotraj.errors import InputError
from infotraj.vehicle import load_vehicle, parse_vehicle

OMAV = Path(__file__).parents[1] / "config" / "vehicles" / "omav.yaml"
SMALL = {
    "name": "small",
    "mass": 1.0,
    "inertia": {"xx": 0.01, "yy": 0.01, "zz": 0.015},
    "rotors": [
        {"name": "r0", "position": [0.1, 0, 0], "spin": 1, "thrust_coefficient": 1e-6, "moment_constant": 0.01},
        {"name": "r1", "position": [-0.1, 0, 0], "spin": -1, "thrust_coefficient": 1e-6, "moment_constant": 0.01},
    ],
}


def changed(**changes) -> dict:
    content = copy.deepcopy(SMALL)
    for path, value in changes.items():
        *parents, last = path.split("__")
        place: Any = content
        for key in parents:
            place = place[int(key) if isinstance(place, list) else key]
        if value is None:
            del place[last]
        else:
            place[int(last) if isinstance(place, list) else last] = value
    return content


def test_the_omav_is_the_one_of_the_spec():
    omav = load_vehicle(OMAV)
    assert omav.mass == 4.04
    assert np.allclose(omav.inertia_matrix(), np.diag([0.0784, 0.0818, 0.1534]))
    azimuth = np.degrees([np.arctan2(t.axis[1], t.axis[0]) for t in omav.tilts])
    assert np.allclose((azimuth - [-90, 90, 30, 210, -30, 150] + 180) % 360, 180, atol=1e-3)
    for k, rotor in enumerate(omav.rotors):
        arm = np.array(omav.tilts[rotor.tilt].axis)
        assert np.allclose(rotor.position, 0.3 * arm + [0, 0, 0.06 if k < 6 else -0.06], atol=1e-5)
        assert rotor.coaxial == ("upper" if k < 6 else "lower")
    assert [r.spin for r in omav.rotors[:6]] == [1, -1, 1, -1, -1, 1]
    assert [a.spin + b.spin for a, b in zip(omav.rotors[:6], omav.rotors[6:], strict=True)] == [0] * 6


def test_the_omav_hovers_at_the_speed_that_the_spec_states():
    omav = load_vehicle(OMAV)
    coefficient = sum(r.thrust_coefficient for r in omav.rotors)
    assert np.sqrt(omav.mass * omav.gravity / coefficient) == pytest.approx(677, abs=1)


def test_axes_are_normalised_on_reading():
    vehicle = parse_vehicle(changed(rotors__0__axis=[0, 3, 4]))
    assert np.allclose(vehicle.rotors[0].axis, [0, 0.6, 0.8])


def test_what_a_file_leaves_out_is_unknown_and_asking_for_it_says_so():
    vehicle = parse_vehicle(changed(inertia=None, mass=None))
    assert vehicle.mass is None
    with pytest.raises(InputError, match=r"vehicle small has no inertia; expected"):
        vehicle.inertia_matrix()


def test_moments_of_a_flat_body_that_are_off_by_ten_percent_are_read_and_doubted():
    assert parse_vehicle(SMALL).inertia.doubt == ""
    assert parse_vehicle(changed(inertia__zz=0.02)).inertia.beyond == 0.0
    measured = parse_vehicle(changed(inertia__zz=0.0208)).inertia  # 4 % more, as a flat body measured to 2 % may have
    assert measured.beyond > 0.0
    assert measured.doubt == ""
    flat = parse_vehicle(changed(inertia__zz=0.0219)).inertia
    assert flat.beyond == pytest.approx(0.095)
    assert "one moment is 9.5 % larger than the sum of the other two" in flat.doubt
    assert parse_vehicle(changed(inertia__zz=0.0249)).inertia.beyond > 0.24
    with pytest.raises(InputError, match="no body has the principal moments"):
        parse_vehicle(changed(inertia__zz=0.0251))


def test_products_of_inertia_stand_on_both_sides():
    matrix = parse_vehicle(changed(inertia__xy=0.001, inertia__yz=-0.002)).inertia_matrix()
    assert np.array_equal(matrix, matrix.T)
    assert (matrix[0, 1], matrix[1, 2]) == (0.001, -0.002)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"mass": -1.0}, "mass: .*greater than 0"),
        ({"mass": float("nan")}, "mass"),
        ({"mass": "heavy"}, "mass: .*found 'heavy'"),
        ({"name": None}, "name: "),
        ({"masss": 2.0}, "masss: unknown key"),
        ({"rotors__0__spn": 1}, r"rotors\.0\.spn: unknown key"),
        ({"rotors__0__spin": 0}, r"rotors\.0\.spin"),
        ({"rotors__0__axis": [0, 0, 0]}, r"rotors\.0\.axis: an axis needs a direction"),
        ({"rotors__0__thrust_coefficient": None}, "r0: a rotor with a speed input needs"),
        ({"rotors__0__input": "throttle"}, "needs `thrust_polynomial`"),
        ({"rotors__0__tilt": 0}, "r0: tilt 0, but there are 0 tilts"),
        ({"rotors__1__name": "r0"}, "names must differ"),
        ({"inertia__zz": 0.5}, "no body has the principal moments"),
        ({"inertia__xy": 0.02}, "no body has the principal moments"),
        ({"rotors": []}, "no rotors; list them, or write `inputs: wrench`"),
        ({"inputs": "wrench"}, "`inputs: wrench` takes the commanded wrench and no rotors"),
        ({"thrust_axis": [0, 0, 1]}, "`thrust_axis` is of a vehicle with `inputs: wrench`"),
        ({"time_constant": 0.1}, "`time_constant` is of a vehicle with `inputs: wrench`"),
        (
            {"rotors__0__thrust_polynomial": [0, 1, 0]},
            "r0: `thrust_polynomial` is of a throttle, but the input is a speed",
        ),
        (
            {"rotors__0__input": "thrust", "rotors__0__thrust_polynomial": [0, 1, 0]},
            "r0: `thrust_polynomial` is of a throttle, but the input is a thrust",
        ),
        (
            {
                "rotors__0__input": "thrust",
                "rotors__0__thrust_coefficient": None,
                "rotors__0__max_speed": 900,
            },
            "r0: `max_speed` limits no thrust without `thrust_coefficient`",
        ),
        ({"rotors__0__input": "pwm"}, r"rotors\.0\.input"),
    ],
)
def test_what_is_wrong_is_said_in_one_line_that_names_the_file(changes, says):
    with pytest.raises(InputError, match=says) as caught:
        parse_vehicle(changed(**changes), source="here.yaml")
    assert str(caught.value).startswith("here.yaml: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"\x80\x81", b"a: [", b"- 1\n- 2\n", b""])
def test_a_file_that_holds_no_vehicle_is_one_line(tmp_path, content):
    path = tmp_path / "vehicle.yaml"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_vehicle(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match="Check the path"):
        load_vehicle(tmp_path / "none.yaml")


def test_a_thrust_needs_no_coefficient_and_a_wrench_no_rotors():
    thrust = parse_vehicle(changed(rotors__0__input="thrust", rotors__0__thrust_coefficient=None))
    assert thrust.rotors[0].thrust_coefficient is None
    wrench = parse_vehicle(changed(rotors=None, inputs="wrench", time_constant=0.04, thrust_axis=[0, 0, 2]))
    assert wrench.rotors == ()
    assert wrench.thrust_axis == (0, 0, 1)
    assert np.array_equal(wrench.input_time_constants, np.full(6, 0.04))


def test_the_example_of_the_errors_is_itself_valid():
    assert parse_vehicle(yaml.safe_load(yaml.safe_dump(SMALL))).name == "small"


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"mas": 1.0}, "mas: unknown key; did you mean mass?"),
        ({"rotors__1__thrust_coeficient": 1e-6}, "rotors.1.thrust_coeficient: unknown key; did you mean thrust_coeff"),
        ({"inertia__moment": 1.0}, "inertia.moment: unknown key; known: xx, yy, zz, xy, xz, yz"),
        ({"legs": 0.18}, "legs: unknown key; known: name, mass, inertia,"),
    ],
)
def test_an_unknown_key_is_told_from_the_nearest_of_the_known_ones_at_its_place(changes, says):
    with pytest.raises(InputError) as caught:
        parse_vehicle(changed(**changes), source="mine.yaml")
    assert f"mine.yaml: {says}" in str(caught.value)
    assert "\n" not in str(caught.value)
