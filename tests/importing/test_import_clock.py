"""Streams without stamps go by the recording times, also where the two clocks run at different speeds."""

from __future__ import annotations

import numpy as np
import pytest

from infotraj.importing.clock import Ticks, align


@pytest.mark.parametrize("speed", [0.98, 1.0, 1.02])
def test_a_stream_without_stamps_is_put_on_the_clock_of_one_that_has_them(speed: float) -> None:
    record = 5_000_000_000 + 10_000_000 * np.arange(1001, dtype=np.int64)
    stamp = (7_000_000 + speed * (record - record[0])).astype(np.int64)
    rows, other = Ticks(stamp, "header.stamp", record), Ticks(record[::50], "record", record[::50])
    notes: list[str] = []
    align(rows, {"motors": other}, notes)
    np.testing.assert_allclose(other.values, stamp[::50], atol=10)  # ns
    assert "motors: it has no stamps" in notes[0]
