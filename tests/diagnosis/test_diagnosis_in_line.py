"""What a vehicle file that is off in several kinds of numbers is off by is no missing effect."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from linear_fits import ROWS, linear_fit

from infotraj.diagnosis.judge.in_line import in_line
from infotraj.diagnosis.judge.verdicts import Finding
from infotraj.diagnosis.select.prior import Scales

ROTORS = [f"rotor_effectiveness {k}" for k in range(4)]
NAMES = ["mass_offset", *ROTORS, "inertia_error", "moment_scale"]
SHARE = np.array([0.05, *4 * [0.15], 0.15, 0.3])  # of a number is its usual size


def fitted(off, chosen, scale=0.05):
    """A file that is off by these shares (7,), beside a set of effects, as `test_diagnosis_anchor` has them."""

    def rows(rng, k):
        lift, roll, yaw = rng.normal(0.0, 30.0, (3, ROWS))
        each = rng.normal(0.0, 30.0, (ROWS, 4))
        x = np.zeros((ROWS, 8))
        x[:, 1], x[:, 6], x[:, 7] = -lift, -roll - yaw, yaw
        x[:, 2:6] = (lift + roll + yaw)[:, None] / 4.0 + each - each.mean(axis=1, keepdims=True)
        x[:, 0] = x[:, 1:] @ np.array(off, dtype=float) + rng.normal(size=ROWS)
        x[:, 1:] *= SHARE
        return x

    _, whole = linear_fit(NAMES, rows, chosen)
    scales = Scales(scale)
    return replace(whole, scales=scales, solution=whole.linear.scorer(scales).solution(whole.chosen))


def named(*names, group=()):
    return [Finding(n, "Supported", group or (n,), None, {}, {}) for n in names]


FOUR = ["mass_offset", "rotor_effectiveness 3", "inertia_error", "moment_scale"]


def test_a_file_that_is_off_by_as_much_in_every_kind_lacks_nothing():
    """Its rotors agree but for one of 2 %, and so it looked exact: four names."""
    told = fitted([0.02, 0.0, 0.0, 0.0, 0.02, 0.08, 0.09], FOUR)
    why = in_line(named(*(x.split()[0] for x in FOUR)), told, {})
    assert sorted(why) == ["inertia_error", "mass_offset", "moment_scale", "rotor_effectiveness"]
    assert "no further off than this vehicle file is" in why["inertia_error"]


@pytest.mark.parametrize("name", ["inertia_error", "moment_scale", "rotor_effectiveness 3", "mass_offset"])
def test_beside_an_exact_file_a_small_number_is_missing(name):
    off = np.zeros(7)
    off[NAMES.index(name)] = 0.03
    assert in_line(named(name.split()[0]), fitted(off, [name]), {}) == {}


def test_two_kinds_that_are_off_beside_an_exact_rest_are_missing():
    """Flights cannot tell what mass, thrusts and inertia have in common: the rest of the file does."""
    told = fitted([0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.3], ["mass_offset", "moment_scale"])
    assert in_line(named("mass_offset", "moment_scale"), told, {}) == {}


def test_a_rotor_is_held_against_the_others_whatever_else_is_off():
    weak = fitted([0.02, 0.0, 0.0, 0.0, -0.1, 0.08, 0.09], FOUR)
    assert "rotor_effectiveness" not in in_line(named(*(x.split()[0] for x in FOUR)), weak, {})
    # Among rotors that differ by 5 % each one of 8 % is none.
    uneven = fitted([0.0, 0.05, -0.05, 0.05, -0.08, 0.08, 0.09], ["rotor_effectiveness 3"], scale=5.0)
    assert list(in_line(named("rotor_effectiveness"), uneven, {})) == ["rotor_effectiveness"]


def test_of_names_that_are_not_told_apart_all_have_to_be_the_file_s():
    told = fitted([0.02, 0.0, 0.0, 0.0, 0.02, 0.08, 0.09], FOUR)
    both = ("inertia_error", "com_offset")
    assert in_line(named(*both, group=both), told, {}) == {}


def test_a_drag_and_a_change_from_healthy_flights_are_no_numbers_of_the_file():
    told = fitted([0.02, 0.0, 0.0, 0.0, 0.02, 0.08, 0.09], FOUR)
    assert in_line(named("linear_drag"), told, {}) == {}
    healthy = SimpleNamespace(linear=SimpleNamespace(observation=SimpleNamespace(healthy=object())))
    assert in_line(named("mass_offset"), healthy, {}) == {}


def test_a_rival_that_is_not_in_the_set_is_judged_by_the_fit_in_which_it_is():
    """A mass, or an inertia in its place, both within what the file is off by: neither is missing."""
    told = fitted([0.02, 0.0, 0.0, 0.0, 0.02, 0.08, 0.09], ["mass_offset", "moment_scale"])
    instead = fitted([0.02, 0.0, 0.0, 0.0, 0.02, 0.08, 0.09], ["inertia_error", "moment_scale"])
    far = fitted([0.02, 0.0, 0.0, 0.0, 0.02, 0.9, 0.09], ["inertia_error", "moment_scale"])
    group = ("mass_offset", "inertia_error")
    for fit, names in ((instead, sorted(group)), (far, [])):
        stand = {"inertia_error": SimpleNamespace(fit=fit)}
        assert sorted(in_line(named(*group, group=group), told, stand)) == names
    assert in_line(named(*group, group=group), told, {}) == {}


def test_a_name_stays_where_what_is_no_number_of_the_file_cannot_be_told_from_it():
    told = fitted([0.02, 0.0, 0.0, 0.0, 0.02, 0.08, 0.09], FOUR)
    beside = named("battery_sag", group=("battery_sag", "inertia_error"))
    why = in_line([*named("inertia_error", "moment_scale"), *beside], told, {})
    assert list(why) == ["moment_scale"]


def test_where_flights_do_not_show_thrust_over_mass_it_is_not_the_file_s():
    """Without a mass in the file, or with every rotor named, nothing says how far it is off."""
    told = fitted([0.02, 0.0, 0.0, 0.0, 0.02, 0.08, 0.09], [*ROTORS, "mass_offset"])
    assert "mass_offset" not in in_line(named("mass_offset", "rotor_effectiveness"), told, {})
    told = fitted([0.02, 0.0, 0.0, 0.0, 0.02, 0.08, 0.09], FOUR)
    assert "mass_offset" in in_line(named("mass_offset"), told, {})
    seen = told.linear.observation
    seen.vehicle = seen.vehicle.model_copy(update={"mass": None})
    assert in_line(named("mass_offset"), told, {}) == {}


def test_thrust_over_mass_that_is_further_off_than_in_any_file_is_missing():
    told = fitted([0.25, 0.0, 0.0, 0.0, 0.0, 0.3, 0.3], ["mass_offset", "inertia_error", "moment_scale"])
    assert "mass_offset" not in in_line(named("mass_offset"), told, {})


def test_what_coaxial_pairs_lose_is_no_sum_of_thrusts():
    names = [*NAMES, "coaxial_loss"]

    def rows(rng, k):
        return np.column_stack([rng.normal(size=ROWS), rng.normal(0.0, 30.0, (ROWS, len(names))) * [*SHARE, 0.1]])

    _, told = linear_fit(names, rows, ["mass_offset", "coaxial_loss"])
    assert in_line(named("mass_offset"), told, {}) == {}
    assert "mass_offset" in in_line(named("mass_offset"), linear_fit(names, rows, ["mass_offset"])[1], {})


def test_a_rotor_that_no_fit_has_is_not_in_line():
    told = fitted([0.02, 0.0, 0.0, 0.0, 0.02, 0.08, 0.09], ["mass_offset", "inertia_error", "moment_scale"])
    assert "rotor_effectiveness" not in in_line(named("rotor_effectiveness", "mass_offset"), told, {})


@pytest.mark.parametrize(("inertia", "its_own"), [(0.29, True), (0.33, False)])
def test_what_no_flight_tells_of_an_inertia_is_no_missing_part_of_it(inertia, its_own):
    """Three times what the file is off by are 0.27, and 0.31 with the factor that it has in common with thrusts."""
    told = fitted([0.02, 0.0, 0.0, 0.0, 0.02, inertia, 0.09], FOUR)
    assert ("inertia_error" in in_line(named("inertia_error"), told, {})) is its_own
