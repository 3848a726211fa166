"""A file against a flight by made torques: what is quiet, unrelated, opposite, or of another size."""

import numpy as np
import pytest

from infotraj.comparing.equation_error import EquationError
from infotraj.describing.against import seen

T = 0.01 * np.arange(4000)
WAVE = np.sin(2.1 * T) + 0.4 * np.sin(5.7 * T)
OTHER = np.cos(3.3 * T) - 0.4 * np.sin(7.1 * T)
SOME = dict(red=np.ones(6), unit={}, force_from="", window=0.15, left_out={})


def said(measured, predicted, thrust=1.0, reasons=None):
    """What is seen of thrust and of the torque about x, whose sides are given; noise leaves 0.05 there."""
    sides = np.zeros((2, len(T), 6))
    sides[0, :, 3], sides[1, :, 3] = measured, predicted
    sides[0, :, 2], sides[1, :, 2] = 8.0 * thrust + WAVE, 8.0 + WAVE / thrust
    found = seen(EquationError(T, *sides, floor=np.full(6, 0.05), reasons=reasons or {}, **SOME))
    return {one.axis: one for one in found}


@pytest.mark.parametrize(("size", "asked"), [(0.1, False), (0.2, True)])
def test_a_torque_that_is_below_three_times_its_noise_on_both_sides_says_nothing(size, asked):
    """The wave's deviation is 0.76 of its size."""
    found = said(size * WAVE, -size * WAVE)["tx"]
    assert ("too quiet" in found.sentence) != asked
    assert found.good != asked
    # One loud side is enough to ask.
    assert not said(0.05 * OTHER, WAVE)["tx"].good


def test_a_torque_goes_against_its_commands_or_does_not_go_with_them():
    against, beside = said(-WAVE, WAVE)["tx"], said(OTHER, WAVE)["tx"]
    assert "goes against" in against.sentence
    assert "correlation -1.00" in against.sentence
    assert "does not go with" in beside.sentence
    # What goes with it by half is not unrelated: a correlation of 1 / sqrt(1 + 1.5^2).
    assert "goes with the commands (correlation 0.5" in said(WAVE + 1.5 * OTHER, WAVE)["tx"].sentence
    # A trim says nothing of order and spins.
    assert said(WAVE + 5.0, WAVE - 3.0)["tx"].good


@pytest.mark.parametrize(("share", "good"), [(1.1, True), (0.9, True), (1.25, False), (0.75, False)])
def test_a_torque_is_as_large_as_predicted_within_a_sixth(share, good):
    found = said(share * WAVE, WAVE)["tx"]
    assert found.good == good
    assert f"{share:.2f} as large" in found.sentence
    assert (f"divide inertia.xx by {share:.2f}" in found.sentence) != good


@pytest.mark.parametrize(("thrust", "good"), [(1.02, True), (1.05, False), (0.9, False)])
def test_thrust_is_right_within_three_hundredths_of_its_mean(thrust, good):
    found = said(WAVE, WAVE, thrust)["fz"]
    assert found.good == good
    assert f"the flight has {thrust:.3f} of what" in found.sentence


def test_a_vehicle_without_rotors_is_told_of_none():
    """Its force and torque are commanded: what may be wrong in its file is the mass and the inertia."""
    assert said(WAVE, WAVE, 0.8)["fz"].sentence.endswith("; divide the mass by 0.800")
    assert "rotor" not in said(1.5 * WAVE, WAVE, 0.8)["tx"].sentence


def test_an_axis_that_cannot_be_said_is_not_asked():
    assert said(WAVE, -WAVE, reasons={"tx": "no rates"})["tx"].sentence == "tx: not asked (no rates)"
