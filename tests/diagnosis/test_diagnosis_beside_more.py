"""What is left beside an effect, in the plane in which it acts most, against what it takes off there."""

import pytest

from infotraj.diagnosis.judge.unexplained import Structure, Unexplained, more_stays


def doubt(falls, rises, left):
    """What is said of what makes the errors fall so, and rise so without it, beside what is left by axis."""
    axes = tuple(Structure(a, 0.9, 0.0, rise, (), None, 0.0) for a, rise in left.items())
    return more_stays(Unexplained(bool(axes), axes), falls, rises)


def test_more_that_is_left_across_its_axis_puts_an_effect_in_doubt():
    assert doubt({"ty": 0.3}, {"ty": 1.0}, {"tx": 1.1}).startswith("on tx more is left")
    assert doubt({"ty": 0.3}, {"ty": 1.0}, {"tx": 0.7, "ty": 0.6}).startswith("on tx more is left")
    assert doubt({"vy": 0.3}, {"vy": 1.0}, {"vx": 1.1}).startswith("on fx more is left")


@pytest.mark.parametrize("left", [{}, {"tx": 0.5, "ty": 0.4}, {"tz": 9.0}, {"fx": 9.0, "fz": 9.0}])
def test_what_is_less_or_lies_in_another_plane_does_not(left):
    assert doubt({"ty": 0.3}, {"ty": 1.0}, left) == ""


def test_where_an_effect_acts_most_is_told_by_what_falls_most():
    """A drag touches the yaw by the file's arms: a rise there says nothing of it."""
    falls, rises = {"fx": 0.4, "fy": 0.2, "tz": 0.1}, {"fx": 6.0, "fy": 3.0, "tz": 27.0}
    assert doubt(falls, rises, {"tz": 30.0}) == ""
    assert doubt(falls, rises, {"fx": 9.1}).startswith("on fx more is left")


def test_nothing_that_is_left_is_never_more():
    """What takes half of an error beside the file as it is may make flights worse beside one that may be off."""
    assert doubt({"ty": -0.1}, {"ty": -0.2}, {}) == ""
    assert doubt({"ty": -0.1}, {"ty": -0.2}, {"fx": 3.0}) == ""
    assert doubt({}, {"ty": 0.0}, {"ty": 3.0}) == ""
    assert doubt({"ty": -0.1}, {"ty": -0.2}, {"ty": 0.1}).startswith("on ty more is left")
