"""Which rows are in the air where only the height tells, and where only motors do."""

import numpy as np
import pandas as pd
import pytest

from infotraj.checking.airborne import airborne_rows
from infotraj.flight import Flight

T = np.arange(0.0, 20.0, 0.02)


@pytest.mark.parametrize("at_the_end", [False, True])
def test_a_rest_of_a_second_at_either_end_says_where_the_ground_is(at_the_end):
    rest = 1.0
    height = 0.3 + np.maximum(T - rest, 0.0) * (1.0 + 0.2 * np.sin(T))  # climbs from the ground, not from a stop
    height = height[::-1] if at_the_end else height
    found = airborne_rows(Flight(pd.DataFrame({"t": T, "px": 0.0, "py": 0.0, "pz": height})))
    assert found.ground == pytest.approx(0.3, abs=0.01)
    on_ground = (T[-1] - T if at_the_end else T) < rest
    assert not found.rows[on_ground].any()
    assert found.rows[~on_ground].mean() > 0.95


@pytest.mark.parametrize("minutes", [1, 10])
@pytest.mark.parametrize("prefix", ["rotor_", "cmd_rotor_"])
def test_a_short_flight_after_minutes_of_idling_motors_is_the_flight(minutes, prefix):
    t = np.arange(0.0, 60.0 * minutes, 0.02)
    flies = (t >= 40.0) & (t < 42.5)
    speed = np.where(flies, 600.0 + 30.0 * np.sin(5 * t), 120.0)
    speed[[100, 1000, 1500]] = 3000.0  # spikes of the log
    found = airborne_rows(Flight(pd.DataFrame({"t": t} | {f"{prefix}{i}": speed for i in range(4)})))
    flown = found.rows.copy()
    flown[[100, 1000, 1500]] = flies[[100, 1000, 1500]]
    np.testing.assert_array_equal(flown, flies)
