"""How exact a vehicle file is, and what ordinary tolerances explain: on sums of one axis, without a flight."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from infotraj.diagnosis.allowance import TOLERANCES, beside_members, ordinary, scale_and_spread
from infotraj.diagnosis.sums import Sums
from infotraj.diagnosis.tolerance import least_tolerance, reached

ROTORS = 6
ONE = TOLERANCES["rotor_effectiveness"]  # usual sizes: 1 % of a rotor's thrust


def rotors(values, samples=4000, loud=30.0, seed=0, members=0):
    """Sums of `samples` whose residual holds these numbers (usual sizes) of six rotors' columns, and what they are."""
    rng = np.random.default_rng(seed)
    columns = loud * rng.standard_normal((samples, members + ROTORS))
    residual = columns[:, members:] @ np.asarray(values) + rng.standard_normal(samples)
    parts = np.array_split(np.arange(samples), 8)
    gram = np.array([[columns[i].T @ columns[i] for i in parts]])
    right = np.array([[columns[i].T @ residual[i] for i in parts]])
    square = np.array([[residual[i] @ residual[i] for i in parts]])
    fold = np.arange(8)
    choices = tuple(
        SimpleNamespace(
            columns=(members + i,),
            scale=np.array([0.15]),
            candidate=SimpleNamespace(label=f"rotor_effectiveness {i}", name="rotor_effectiveness"),
        )
        for i in range(ROTORS)
    )
    found = SimpleNamespace(of_members=tuple(range(members)), choices=choices, command_step=0.005)
    return Sums(gram, right, square, np.full((1, 8), samples / 80), ("fz",), fold, fold), found


def test_an_exact_file_has_no_tolerances():
    assert scale_and_spread(*rotors(np.zeros(ROTORS)))[0] == 0.0


def test_one_rotor_that_is_off_says_nothing_about_the_file():
    assert scale_and_spread(*rotors([15 * ONE, 0, 0, 0, 0, 0]))[0] == 0.0


@pytest.mark.parametrize("seed", range(5))
def test_rotors_that_are_all_off_say_how_exact_the_file_is(seed):
    values = ONE * np.random.default_rng(100 + seed).standard_normal(ROTORS)
    assert 0.3 <= scale_and_spread(*rotors(values, seed=seed))[0] <= 1.5


def test_tolerances_widen_what_a_fit_says_of_its_own_numbers():
    quiet = scale_and_spread(*rotors(np.zeros(ROTORS), members=1))[1]
    clutter = ONE * np.array([1.0, -1.2, 0.8, 1.1, -0.7, 0.9])
    loud = scale_and_spread(*rotors(clutter, members=1))[1]
    assert quiet.shape == loud.shape == (1,)
    assert loud[0] > quiet[0]


def test_what_is_extraordinary_is_no_tolerance():
    sums, found = rotors([15 * ONE, 0.5 * ONE, 0, 0, 0, 0])
    columns, deviation = ordinary(sums, found, 1.0)
    assert columns == [1, 2, 3, 4, 5]
    numbers = beside_members(sums, found, columns, deviation)
    assert numbers[0] == 0.0
    assert len(numbers) == ROTORS


@pytest.mark.parametrize("size", [0.5, 1.0, 2.0])
def test_the_least_tolerance_is_the_size_of_what_is_off(size):
    values = np.zeros(ROTORS)
    values[2] = size * ONE
    sums, found = rotors(values, loud=300.0)
    allowed = 1.02 * 4000 * np.ones(1)
    least = least_tolerance(sums, found, list(range(ROTORS)), np.full(ROTORS, ONE), allowed)
    assert 0.3 * size**2 < least < 1.1 * size**2


def test_what_a_model_reaches_is_no_mixture_of_two_models_blocks():
    plain = rotors(np.zeros(ROTORS))[0]
    swapped = replace(plain, square=plain.square * np.where(np.arange(8) % 2, 1.01, 0.99))
    assert reached(swapped, plain) == pytest.approx(min(swapped.square.sum(), plain.square.sum()))
