"""Which rows are in the air where only the height tells."""

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
