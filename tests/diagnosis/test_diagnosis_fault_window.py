"""Which seconds of a flight are asked whether the vehicle file has an entry wrong."""

import numpy as np

from infotraj.diagnosis.gates.vehicle_faults import _SECONDS, _fullest


def test_seconds_on_the_ground_in_the_middle_of_a_flight_are_not_asked():
    used = np.concatenate([np.arange(1.0, 9.0, 0.01), np.arange(15.0, 23.0, 0.01)])
    begin = _fullest(used)
    inside = (used >= begin) & (used < begin + _SECONDS)
    assert inside.sum() >= 0.95 * _SECONDS / 0.01


def test_the_middle_of_a_flight_without_gaps_is_asked():
    used = np.arange(0.0, 30.0, 0.01)
    assert abs(_fullest(used) + _SECONDS / 2 - 15.0) < 0.1
