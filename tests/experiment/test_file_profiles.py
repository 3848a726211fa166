"""Vehicle files that are wrong as files are: sizes, what stays, and which answers state the file's own errors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from infotraj.dynamics.allocation import Allocation
from infotraj.errors import UsageError
from infotraj.experiment.hidden.file_errors import beside_the_file, cancelled, excused, states_the_file
from infotraj.experiment.hidden.file_profiles import LEVELS, wrong_file
from infotraj.models.file import vehicle_content
from infotraj.vehicle import load_vehicle, parse_vehicle

VEHICLES = {name: load_vehicle(f"config/vehicles/{name}.yaml") for name in ("omav", "quadrotor")}
QUAD = VEHICLES["quadrotor"]


def files(vehicle, level, count=80):
    return [wrong_file(vehicle, level, np.random.default_rng(k)) for k in range(count)]


@pytest.mark.parametrize("level", ["1%", "3%", "10%"])
@pytest.mark.parametrize("name", VEHICLES)
def test_a_file_is_as_wrong_as_its_level_says(name, level):
    vehicle, s = VEHICLES[name], LEVELS[level]
    made = files(vehicle, level)
    thrust = np.array([[r.thrust_coefficient for r in f.rotors] for f in made]) / vehicle.rotors[0].thrust_coefficient
    assert np.log(thrust).std() == pytest.approx(s, rel=0.15)
    # every rotor by itself
    assert np.log(thrust / thrust.mean(axis=1, keepdims=True)).std() > 0.8 * s
    assert np.log([f.mass / vehicle.mass for f in made]).std() == pytest.approx(0.5 * s, rel=0.25)
    assert np.std([f.center_of_mass for f in made]) == pytest.approx(s / 0.03 * 1e-3, rel=0.2)
    places = [np.subtract(a.position, b.position) for f in made for a, b in zip(f.rotors, vehicle.rotors, strict=True)]
    moved = np.array(places)[np.abs(places) > 0]
    assert np.sqrt(np.sum(np.square(places)) / len(places)) == pytest.approx(
        s / 0.03 * 2e-3 * np.sqrt(2 if vehicle.tilts else 3), rel=0.15
    )
    assert len(moved)
    assert np.log([f.rotors[0].time_constant / vehicle.rotors[0].time_constant for f in made]).std() == pytest.approx(
        5 * s, rel=0.25
    )


@pytest.mark.parametrize("name", VEHICLES)
def test_a_wrong_file_is_still_a_vehicle_file_that_can_be_allocated(name):
    for file in files(VEHICLES[name], "10%", 20):
        assert parse_vehicle(vehicle_content(file)) == file
        Allocation(file)


def test_the_errors_grow_with_the_level_and_the_exact_file_is_untouched():
    exact, *wrong = (wrong_file(QUAD, level, np.random.default_rng(4)) for level in LEVELS)
    assert exact == QUAD
    off = [np.log(w.rotors[2].thrust_coefficient / QUAD.rotors[2].thrust_coefficient) for w in wrong]
    assert np.array(off) / off[0] == pytest.approx([1.0, 3.0, 10.0], rel=1e-3)


def test_an_unknown_level_is_refused():
    with pytest.raises(UsageError, match="2%"):
        wrong_file(QUAD, "2%", np.random.default_rng(0))


def off_by(**values):
    return QUAD.model_copy(update=values)


def test_an_answer_states_the_file_where_it_takes_half_of_its_error_away():
    file = off_by(mass=0.76)
    assert states_the_file("mass_offset", {"dm": 0.04}, file, QUAD)
    assert states_the_file("mass_offset", {"dm": 0.025}, file, QUAD)
    assert not states_the_file("mass_offset", {"dm": 0.015}, file, QUAD)
    assert not states_the_file("mass_offset", {"dm": -0.04}, file, QUAD)
    assert not states_the_file("mass_offset", {"dm": 0.04}, QUAD, QUAD)
    assert not states_the_file("linear_drag", {"d": [0.1, 0.1, 0.1]}, file, QUAD)


def test_a_rotor_is_stated_at_its_place_or_beside_a_common_factor():
    rotors = [r.model_copy(update={"thrust_coefficient": r.thrust_coefficient * 1.05}) for r in QUAD.rotors]
    rotors[1] = rotors[1].model_copy(update={"thrust_coefficient": QUAD.rotors[1].thrust_coefficient * 1.20})
    file = off_by(rotors=tuple(rotors))
    assert states_the_file("rotor_effectiveness", {"rotor": 1, "factor": 1 / 1.2}, file, QUAD)
    assert states_the_file("rotor_effectiveness", {"rotor": 1, "factor": 0.91}, file, QUAD)
    assert not states_the_file("rotor_effectiveness", {"rotor": 2, "factor": 1 / 1.2}, file, QUAD)
    assert states_the_file("thrust_scale", {"factor": 0.92}, file, QUAD)


def test_hidden_numbers_add_to_what_the_file_has_wrong():
    rotors = tuple(r.model_copy(update={"time_constant": 0.025, "thrust_coefficient": 1.6e-6}) for r in QUAD.rotors)
    file = off_by(mass=0.76, rotors=rotors)
    assert beside_the_file("mass_offset", {"dm": 0.1}, file, QUAD)["dm"] == pytest.approx(0.14)
    lag = beside_the_file("rotor_lag", {"extra_time_constant": 0.03}, file, QUAD)
    assert lag["extra_time_constant"] == pytest.approx(0.035)
    weak = beside_the_file("rotor_effectiveness", {"rotor": 2, "factor": 0.8}, file, QUAD)
    assert weak == {"rotor": 2, "factor": pytest.approx(0.8 * 15 / 16)}
    assert beside_the_file("linear_drag", {"d": [0.1, 0.2, 0.3]}, file, QUAD) == {"d": [0.1, 0.2, 0.3]}


def test_what_the_file_happens_to_hold_need_not_be_named():
    assert cancelled("mass_offset", {"dm": -0.04}, off_by(mass=0.77), QUAD)
    assert not cancelled("mass_offset", {"dm": 0.04}, off_by(mass=0.77), QUAD)
    assert not cancelled("mass_offset", {"dm": 0.04}, QUAD, QUAD)


def test_groups_that_state_the_file_or_the_log_are_told_from_invented_ones():
    numbers: dict[str, Any] = {
        "mass_offset": [{"dm": 0.04}],
        "steady_force": [{"f": [0, 0, -0.4]}],
        "linear_drag": [{"d": [1, 1, 1]}],
    }
    groups = [(0, ["steady_force", "mass_offset"]), (1, ["linear_drag"]), (2, ["actuation_delay"])]
    found = excused(groups, lambda n: numbers.get(n, [{}]), off_by(mass=0.76), QUAD, frozenset({"actuation_delay"}))
    assert found == (["steady_force"], ["actuation_delay"], {0, 2})
    assert excused(groups[:2], lambda n: numbers.get(n, [{}]), QUAD, QUAD, frozenset()) == ([], [], set())
