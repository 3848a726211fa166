"""An axis of the residual is called by what it is of."""

import pytest

from infotraj.diagnosis.report.reasons import axis_in_words


@pytest.mark.parametrize(
    ("axis", "words"),
    [
        ("tx", "tx"),
        ("vz", "vz"),
        ("push y", "velocity against accelerometer along y"),
        ("turn z", "attitude against gyro about z"),
    ],
)
def test_an_axis_is_called_by_what_it_is_of(axis, words):
    assert axis_in_words(axis) == words
