"""Standard errors of numbers of which flights tell all but a factor that they have in common."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from linear_fits import ROWS, VEHICLE, linear_fit

from infotraj.diagnosis.judge.anchor import _covariance, off_by, told_errors
from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.select.prior import Scales

ROTORS = [f"rotor_effectiveness {k}" for k in range(4)]
NAMES = ["mass_offset", *ROTORS, "inertia_error", "moment_scale"]
SHARE = np.array([0.05, *4 * [0.15], 0.15, 0.3])  # of a number is its usual size
MASS, THRUST, INERTIA, MOMENT = 0, [1, 2, 3, 4], 5, 6


def flights(off, mixed=True):
    """Rows in which mass and thrusts, and moments of inertia and thrusts, move the residual against one another.

    off: (7,) what is off, as shares of each number; mixed: each rotor moves the vehicle in its own way, too.
    """

    def rows(rng, k):
        lift, roll, yaw = rng.normal(0.0, 30.0, (3, ROWS))
        each = rng.normal(0.0, 30.0, (ROWS, 4)) if mixed else np.zeros((ROWS, 4))
        x = np.zeros((ROWS, 1 + len(NAMES)))
        x[:, 1 + MASS] = -lift
        x[:, 1 + INERTIA] = -roll - yaw
        x[:, 1 + MOMENT] = yaw
        for i, c in enumerate(THRUST):
            x[:, 1 + c] = (lift + roll + yaw) / 4.0 + each[:, i] - each.mean(axis=1)
        x[:, 0] = x[:, 1:] @ off + rng.normal(size=ROWS)
        x[:, 1:] *= SHARE
        return x

    return rows


def fitted(off, chosen=(), scale=0.05, **changed):
    _, whole = linear_fit(NAMES, flights(np.array(off, dtype=float)), chosen)
    scales = Scales(scale)
    made = replace(whole, scales=scales, solution=whole.linear.scorer(scales).solution(whole.chosen))
    return replace(made, **changed)


def test_what_moves_a_vehicle_alike_is_as_exact_as_the_file():
    """In a file that seems exact the mass is told to 0.1 % beside its rotors: its ratio to them is so exact."""
    made = fitted([0.2, *6 * [0.0]], ["mass_offset"])
    of_flights = np.sqrt(np.diag(overdispersion(made)[1]))
    told = told_errors(made)
    assert of_flights[MASS] * 0.05 < 0.001
    assert 0.005 < told[MASS] * 0.05 < 0.02
    assert np.all(told >= of_flights)


def test_rotors_are_told_from_one_another_exactly_and_each_as_exactly_as_the_mass_is_weighed():
    made = fitted([0.0, -0.15, *5 * [0.0]], ["rotor_effectiveness 0"], scale=1.0)
    along = np.zeros(7)
    along[THRUST] = [1.0, -1.0, 0.0, 0.0]
    exact = overdispersion(made)[1]
    assert np.sqrt(along @ exact @ along) * 0.15 < 0.002
    assert told_errors(made)[1] * 0.15 == pytest.approx(0.005, rel=0.2)  # of a mass, as files have it


def test_one_kind_that_is_off_may_be_what_is_missing_a_second_one_says_that_it_is_the_file():
    assert off_by(fitted(7 * [0.0])) == 1.0
    assert off_by(fitted([0.3, *6 * [0.0]], ["mass_offset"])) == 1.0
    both = fitted([0.3, *4 * [0.0], 0.12, 0.0], ["mass_offset", "inertia_error"])
    assert 3.0 < off_by(both) < 9.0
    alone = fitted([0.3, *6 * [0.0]], ["mass_offset"])
    assert told_errors(both)[MASS] > 2.0 * told_errors(alone)[MASS]


def test_an_error_grows_with_what_the_file_is_off_by_and_no_further_than_files_are():
    small, large, absurd = (
        fitted([0.02, 0.1, -0.1, 0.0, 0.0, off, off], NAMES[:3] + NAMES[5:]) for off in (0.05, 0.12, 0.9)
    )
    assert off_by(small) < off_by(large) < off_by(absurd) == 9.0
    assert told_errors(small)[MASS] < told_errors(large)[MASS]


def test_a_set_that_is_fitted_beside_the_file_as_it_is_has_the_errors_of_a_file_that_was_found_to_be_wrong():
    both = fitted([0.3, *4 * [0.0], 0.12, 0.0], ["mass_offset", "inertia_error"])
    taken = fitted([0.3, *4 * [0.0], 0.12, 0.0], ["mass_offset", "inertia_error"], scale=0.0)
    alone = fitted([0.3, *4 * [0.0], 0.12, 0.0], ["mass_offset"], scale=0.0)
    assert told_errors(taken)[MASS] == pytest.approx(told_errors(both)[MASS], rel=0.1)
    assert told_errors(alone, both)[MASS] > 2.0 * told_errors(alone)[MASS]


def test_against_healthy_flights_nothing_is_added():
    made = fitted([0.2, *6 * [0.0]], ["mass_offset"], scale=0.3)
    against = SimpleNamespace(**{**vars(made.linear.observation), "healthy": object()})
    own = made.linear
    linear = SimpleNamespace(observation=against, absent=own.absent, scatter=None, choices=own.choices)
    known = {k: getattr(made, k) for k in ("scorer", "chosen", "solution", "scales")}
    bare = SimpleNamespace(linear=linear, **known)
    assert told_errors(bare) == pytest.approx(np.sqrt(np.diag(overdispersion(made)[1])))


@pytest.mark.parametrize("name", ["mass_offset", "thrust_scale"])
def test_thrust_over_mass_that_is_off_counts_by_whichever_name_it_is_told(name):
    """With an inertia that is off there are two kinds: the file is no anchor, whether a search took mass or thrust."""
    names = [*NAMES, "thrust_scale"]

    def rows(rng, k):
        x = flights(np.array([0.3, *4 * [0.0], 0.12, 0.0]))(rng, k)
        lift = x[:, 2:6].sum(axis=1) / SHARE[1]
        return np.column_stack([x, lift * 0.15])

    _, whole = linear_fit(names, rows, [name, "inertia_error"])
    scales = Scales(0.05)
    made = replace(whole, scales=scales, solution=whole.linear.scorer(scales).solution(whole.chosen))
    assert off_by(made) > 5.0


@pytest.mark.parametrize(
    ("chosen", "off", "error"),
    [(["mass_offset"], 1.0, 0.01), (["mass_offset"], 3.0, 0.0287), (["mass_offset", "thrust_scale"], 1.0, 0.0894)],
)
def test_a_mass_beside_a_force_that_is_commanded_is_as_exact_as_that_force_is(chosen, off, error):
    """Flights tell one from the other by nothing: 1 % of the force, times what the file is off, or of 10 and 20 %."""

    def rows(rng, k):
        lift = rng.normal(0.0, 30.0, ROWS)
        return np.column_stack([rng.normal(size=ROWS), -0.05 * lift, 0.1 * lift])

    _, whole = linear_fit(["mass_offset", "thrust_scale"], rows, chosen)
    own = whole.linear
    flown = SimpleNamespace(**{**vars(own.observation), "vehicle": VEHICLE.model_copy(update={"rotors": ()})})
    taken = {k: getattr(own, k) for k in ("columns", "choices", "scorer", "spike")}
    linear = SimpleNamespace(**taken, observation=flown)
    of = {k: getattr(whole, k) for k in ("chosen", "solution", "scales", "held", "scorer")}
    mass, force = np.sqrt(np.diag(_covariance(SimpleNamespace(linear=linear, **of), off)))[:2] * [0.05, 0.1]
    assert [mass, force] == pytest.approx([error, error], rel=0.03)


def test_a_commanded_force_that_the_model_has_already_is_one_number():
    def rows(rng, k):
        lift = rng.normal(0.0, 30.0, ROWS)
        return np.column_stack([rng.normal(size=ROWS), -0.05 * lift, 0.1 * lift])

    _, whole = linear_fit(["mass_offset", "thrust_scale"], rows, ["mass_offset"])
    own = whole.linear
    point = tuple(replace(m, held=m.candidate.name == "thrust_scale") for m in own.point)
    flown = SimpleNamespace(**{**vars(own.observation), "vehicle": VEHICLE.model_copy(update={"rotors": ()})})
    held = replace(own, point=point, observation=flown)
    made = replace(whole, linear=held, scales=Scales(1.0))
    assert held.kept == (1,)
    assert np.all(np.isfinite(told_errors(made)))
