"""What stands when the model that is given takes a name away: a rival that is impossible is none."""

import pytest

from infotraj.diagnosis.judge.deciding import _demoted
from infotraj.diagnosis.judge.verdicts import Finding

PAIR = ("mass_offset", "thrust_scale")


def alike(names):
    return tuple(Finding(n, "Not separable", names, None, {}, {}, "cannot tell") for n in names)


@pytest.mark.parametrize(("impossible", "verdict"), [({"thrust_scale"}, "Supported"), (set(), "Plausible")])
def test_what_is_left_of_a_group_is_sure_only_where_the_other_is_impossible(impossible, verdict):
    mass, thrust = _demoted(alike(PAIR), {"thrust_scale": "why it went"}, impossible)
    assert (thrust.verdict, thrust.reason) == ("Plausible", "why it went")
    assert (mass.verdict, mass.group) == (verdict, ("mass_offset",))
    assert ("why it went" in mass.reason) == (verdict == "Plausible")


def test_of_three_alike_two_stay_a_group():
    left = _demoted(alike((*PAIR, "battery_sag")), {"thrust_scale": "why it went"}, {"thrust_scale"})
    assert [f.verdict for f in left] == ["Not separable", "Plausible", "Not separable"]
    assert left[0].group == ("mass_offset", "battery_sag")
