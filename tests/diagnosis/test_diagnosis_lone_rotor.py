"""A rotor that is out of line with the others is found by their own spread, as seldom falsely as the level says."""

import numpy as np
import pytest

from infotraj.diagnosis.judge.lone_rotor import LEVEL, chance_of_each

NOTHING = np.zeros((4, 4))


def lone(x, covariance=NOTHING):
    return float(chance_of_each(np.asarray(x), covariance).min()) * len(x) < LEVEL


@pytest.mark.parametrize("count", [4, 6, 8])
def test_files_whose_rotors_differ_at_random_have_a_lone_one_as_seldom_as_the_level_says(count):
    rng = np.random.default_rng(count)
    draws = 0.05 * rng.standard_normal((4000, count))
    found = np.mean([lone(x, np.zeros((count, count))) for x in draws])
    assert 0.4 * LEVEL < found < 1.6 * LEVEL


def test_a_weak_rotor_beside_others_that_agree_is_found_however_far_off_the_file_is_in_common():
    assert lone([0.065, -0.095, 0.072, 0.073])
    assert lone([0.165, 0.005, 0.172, 0.173])
    assert not lone([0.065, -0.095, 0.03, 0.073])
    assert lone([0.065, -0.095, 0.05, 0.073, 0.06, 0.068], np.zeros((6, 6)))
    x = np.array([0.065, -0.095, 0.072, 0.073])
    assert int(np.argmin(chance_of_each(x, NOTHING))) == 1


def test_what_flights_do_not_tell_of_a_rotor_makes_it_no_lone_one():
    x, one = [0.065, -0.095, 0.072, 0.073], np.eye(4)
    assert lone(x, 0.005**2 * one)
    assert not lone(x, 0.05**2 * one)
    # What is not known of all rotors alike takes nothing from what is known of one beside the others.
    assert lone(x, 0.2**2 * np.ones((4, 4)))
