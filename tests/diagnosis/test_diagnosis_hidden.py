"""Hidden effects in flights of the MuJoCo plant: three effects, a pair and nothing. None is named without need."""

from typing import Any

import numpy as np
import pytest
from hidden_flights import OMAV, fly, truth

from infotraj.diagnosis.diagnosis import diagnose
from infotraj.models import Model

FACTOR = (1.0,) * 5 + (0.8,) + (1.0,) * 6

CASES: dict[str, Any] = {
    "nothing": (truth(), {}),
    "linear_drag": (truth(air={"linear_drag": (0.5, 0.5, 0.8)}), {"linear_drag": {"d": [0.5, 0.5, 0.8]}}),
    "com_offset": (truth(center_of_mass=(0.008, -0.005, 0.006)), {"com_offset": {"r": [0.008, -0.005, 0.006]}}),
    "rotor_effectiveness": (
        truth(rotors={"thrust_factor": FACTOR}),
        {"rotor_effectiveness": {"rotor": 5, "factor": 0.8}},
    ),
    "pair": (
        truth(mass=4.24, air={"axial_inflow": 2e-4}),
        {"mass_offset": {"dm": 0.2}, "axial_inflow": {"k": 2e-4}},
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("case", CASES)
def test_a_hidden_effect_is_named_with_its_numbers(case):
    hidden, expected = CASES[case]
    found = diagnose(Model(OMAV), fly(hidden))
    assert sorted(found.supported) == sorted(expected)
    assert not found.unexplained.found
    for name, values in expected.items():
        finding = found.finding(name)
        assert finding.verdict == "Supported"
        assert finding.evidence.rise > 0.05
        assert finding.evidence.ci95[1] < 0
        for parameter, value in values.items():
            np.testing.assert_allclose(finding.parameters[parameter], value, rtol=0.1, atol=6e-4)
