"""Thrust over mass that is further off than in any file is a finding, on real flights of a coaxial octorotor."""

import pytest
from real_cases import cut, used

from infotraj.diagnosis.diagnosis import diagnose

NAMES = {"coaxial_loss", "thrust_scale", "mass_offset"}


@pytest.mark.long
def test_thrust_that_coaxial_pairs_lose_is_named_as_one_group(tmp_path):
    """The X8 hovers with 21 to 26 N where its weight is 18.8 N; which of three names it is no hover tells."""
    case, model = cut("acsl_x8", tmp_path)
    found = diagnose(model, used(case, tmp_path, model))
    (name,) = NAMES & set(found.supported)
    finding = found.finding(name)
    assert set(finding.group) == NAMES
    assert finding.verdict == "Not separable"
    assert finding.evidence.heldout_change < -0.1
    assert not NAMES & set(found.beside)
    assert found.after.rmse[2] < 0.5 * found.before.rmse[2]
    lost = found.finding("thrust_scale").parameters["factor"]
    assert lost == pytest.approx(18.83 / 23.5, abs=0.12)
