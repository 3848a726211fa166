"""When a name is withheld: beside structure that is left, beside much larger effects, beside a formula that fails."""

import numpy as np
import pytest

from infotraj.diagnosis.evidence import Evidence
from infotraj.diagnosis.profile import Profile
from infotraj.diagnosis.unexplained import Structure, Unexplained
from infotraj.diagnosis.verdicts import _dwarfed, _overshadowed, _part_of


def evidence(**by_axis):
    axis = max(by_axis, key=by_axis.get)
    return Evidence(-0.1, (-0.2, -0.05), (4, 4), 1.0, by_axis[axis], axis, 500.0, by_axis)


def left(axis, rise, share=0.3):
    s = Structure(axis, share, 0.05, rise, (), None, 0.0)
    return Unexplained(True, (s,), {axis: s})


@pytest.mark.parametrize(("rise", "hidden"), [(0.1, False), (0.19, False), (0.21, True), (2.0, True)])
def test_a_fifth_left_on_its_own_axis_hides_a_name(rise, hidden):
    assert (_overshadowed(evidence(fx=1.0), left("fx", rise)) is not None) == hidden


@pytest.mark.parametrize(("rise", "hidden"), [(0.25, False), (0.4, True)])
def test_a_third_left_on_another_axis_hides_a_name(rise, hidden):
    assert (_overshadowed(evidence(fx=1.0), left("tz", rise)) is not None) == hidden


def test_what_no_force_or_torque_shows_hides_no_name():
    assert _overshadowed(evidence(fx=1.0), left("push x", 10.0)) is None


def test_a_small_effect_is_dwarfed_only_where_the_large_one_acts_on_all_its_axes():
    small = evidence(fx=0.1, tz=0.01)
    assert _dwarfed(small, {"fx": 100.0}, 0.05, 0.003)
    assert not _dwarfed(small, {"fx": 20.0}, 0.05, 0.003)
    assert not _dwarfed(evidence(fx=0.1, tz=0.1), {"fx": 100.0}, 0.05, 0.003)


def test_an_effect_is_part_of_another_on_the_axis_where_that_shows():
    assert _part_of(evidence(ty=0.2), evidence(ty=0.15))
    assert not _part_of(evidence(ty=2.0), evidence(ty=0.15))
    assert not _part_of(evidence(fx=0.2), evidence(ty=0.15))


def test_the_profile_is_that_of_least_squares():
    rng = np.random.default_rng(0)
    columns = rng.standard_normal((300, 4))
    residual = columns @ [0.5, -1.0, 0.2, 2.0] + 0.1 * rng.standard_normal(300)
    gain, times = Profile(np.column_stack([residual, columns[:, :3]])).gain(columns[:, 3])

    def cost(x):
        return np.sum((residual - x @ np.linalg.lstsq(x, residual, rcond=None)[0]) ** 2)

    assert gain == pytest.approx(cost(columns[:, :3]) - cost(columns), rel=1e-2)
    assert times == pytest.approx(2.0, abs=0.05)
    assert Profile(np.column_stack([residual, columns[:, :3]])).gain(-columns[:, 3]) == (0.0, 0.0)
