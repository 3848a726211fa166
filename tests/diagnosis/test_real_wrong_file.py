"""Real flights beside a vehicle file that is off by 10 %."""

import pytest
from real_cases import cut, used

from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.gates.premises import doubts
from infotraj.models import Model
from infotraj.vehicle import Inertia


@pytest.mark.long
def test_a_centre_of_mass_that_is_not_where_the_file_has_it_refuses_no_flight(tmp_path):
    """Along y it predicts the opposite of what was measured, beside a mass 4 % and inertias 10 to 40 % off."""
    case, given = cut("crazyswarm2_free", tmp_path)
    inertia = {**given.vehicle.inertia.model_dump(), "xx": 1.03e-5, "yy": 1.45e-5, "zz": 2.61e-5}
    off = {"mass": 0.03337, "center_of_mass": (0.0003, -0.0014, -0.0027), "inertia": Inertia(**inertia)}
    model = Model(given.vehicle.model_copy(update=off), given.effects)
    flights = used(case, tmp_path, model)
    assert len(flights) == len(case.fit)
    assert not [d for d in doubts(model, flights) if d.counts]
    found = diagnose(model, flights)
    assert "linear_drag" in found.supported
    assert "suspended_load" not in found.supported
    assert found.finding("linear_drag").parameters["d"][1] == pytest.approx(0.0133, rel=0.15)
    left = found.after.rmse / found.before.rmse
    assert left[2] < 0.3
    assert left[3] < 0.3
    told = next(n for n in found.file if n.ratio)
    assert told.value == pytest.approx(1.12, abs=0.04)
