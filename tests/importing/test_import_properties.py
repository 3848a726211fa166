"""Properties of the readers on made inputs: any damage is read or one line; any flight table survives to the bit."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd
import pytest
from flights_made import made_flight
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_import_bytes import bag1_bytes, crazyflie_v1_bytes, mcap_bytes
from writers_ulog import ulog_bytes

from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.importing import import_log
from infotraj.importing.resample import gap_limit, put

SMALL = made_flight(0.5)
THROTTLE = Flight(
    SMALL.table.assign(**{c: SMALL.table[c] / 1000 for c in SMALL.table if c.startswith("cmd_rotor_")}), {}
)
POSES = [
    (10**9 + round(t * 1e9), [float(v) for v in row])
    for t, row in zip(SMALL.t, SMALL.get("px", "py", "pz", "qx", "qy", "qz", "qw"), strict=True)
]
WHOLE = {
    "log.bag": bag1_bytes(POSES),
    "log.mcap": mcap_bytes(POSES, "uint64 micros\nfloat32[3] xyz\nfloat32[4] xyzw"),
    "log.ulg": ulog_bytes(THROTTLE),
    "log07": crazyflie_v1_bytes([(k, [1.0, 2.0, 3.0]) for k in range(100)], [(5, 4.0)]),
    "log.csv": SMALL.table.to_csv(index=False).encode(),
}
QUIET = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def outcome(name: str, data: bytes, **options: Any) -> Flight | str:
    """The flight, or the one line that rejects it; anything else raises."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(data)
        try:
            return import_log(path, **options)
        except InputError as error:
            line = str(error)
            assert "\n" not in line
            assert line.startswith(str(path))
            return line


def assert_is_a_flight(found: Flight) -> None:
    assert len(found.table) >= 2
    assert np.isfinite(found.t).all()
    assert (np.diff(found.t) > 0).all()
    assert not np.isinf(found.table.to_numpy()).any()
    assert found.meta["source_sha256"]


@pytest.mark.parametrize("name", list(WHOLE))
@given(data=st.data())
@QUIET
def test_overwritten_bytes_are_read_or_rejected(name: str, data: st.DataObject) -> None:
    whole = bytearray(WHOLE[name])
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(whole) - 1))
        new = data.draw(st.binary(min_size=1, max_size=16))
        whole[place : place + len(new)] = new
    found = outcome(name, bytes(whole), allow_damaged=data.draw(st.booleans()))
    if isinstance(found, Flight):
        assert_is_a_flight(found)


@pytest.mark.parametrize("name", list(WHOLE))
@given(data=st.data())
@QUIET
def test_removed_bytes_are_read_or_rejected(name: str, data: st.DataObject) -> None:
    whole = WHOLE[name]
    start = data.draw(st.integers(0, len(whole)))
    stop = data.draw(st.integers(start, len(whole)))
    found = outcome(name, whole[:start] + whole[stop:], allow_damaged=data.draw(st.booleans()))
    if isinstance(found, Flight):
        assert_is_a_flight(found)


@given(st.binary(max_size=300), st.sampled_from(["", ".bag", ".mcap", ".db3", ".ulg", ".csv", ".parquet", ".txt"]))
@settings(max_examples=100, deadline=None)
def test_any_bytes_are_read_or_rejected(data: bytes, suffix: str) -> None:
    found = outcome(f"log{suffix}", data)
    if isinstance(found, Flight):
        assert_is_a_flight(found)


def times(least: int, most: int, span_ms: int) -> st.SearchStrategy[Any]:
    """Increasing times in whole milliseconds, in s."""
    whole = st.lists(st.integers(0, span_ms), min_size=least, max_size=most, unique=True)
    return whole.map(lambda ms: np.sort(np.array(ms)) / 1000.0)


@given(
    t=times(2, 30, 3_000_000),
    seed=st.integers(0, 2**32 - 1),
    columns=st.sets(st.sampled_from(["px", "vx", "wx", "ax", "cmd_fx", "battery"]), min_size=1),
    suffix=st.sampled_from([".csv", ".parquet"]),
)
@settings(max_examples=60, deadline=None)
def test_any_flight_table_survives_to_the_bit(t: Any, seed: int, columns: set[str], suffix: str) -> None:
    rng = np.random.default_rng(seed)
    table = {"t": t}
    for first in sorted(columns):
        names = [first] if first == "battery" else [first[:-1] + axis for axis in "xyz"]
        for name in names:
            values = rng.normal(size=t.size) * 10.0 ** rng.integers(-8, 3)
            values[rng.random(t.size) < 0.2] = np.nan
            values[0] = rng.normal()
            table[name] = values
    wanted = pd.DataFrame(table)
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"flight{suffix}"
        Flight(wanted, {"source": "x"}).write(path)
        if columns == {"battery"}:
            with pytest.raises(InputError, match="no channel holds a number"):
                import_log(path)
            return
        found = import_log(path)
    kept = found.table.drop(columns=found.meta["derived"])
    pd.testing.assert_frame_equal(kept, wanted[list(kept.columns)], check_exact=True)
    assert set(wanted.columns) == set(kept.columns)


@given(
    rows=times(2, 40, 10_000),
    t=times(1, 40, 10_000),
    rule=st.sampled_from(["linear", "mean", "hold", "sample"]),
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=150, deadline=None)
def test_resampling_invents_nothing(rows: Any, t: Any, rule: Any, seed: int) -> None:
    """Every value lies within the range of the samples; a constant stays that constant; nothing precedes the first."""
    values = np.random.default_rng(seed).normal(size=(t.size, 1))
    out = put(rows, t, values, rule, gap_limit(t))
    there = np.isfinite(out)
    assert out.shape == (rows.size, 1)
    assert (out[there] >= values.min() - 1e-9).all()
    assert (out[there] <= values.max() + 1e-9).all()
    same = put(rows, t, np.full_like(values, 7.0), rule, gap_limit(t))
    np.testing.assert_allclose(same[np.isfinite(same)], 7.0, rtol=1e-9)
    if rule in ("linear", "hold"):
        assert np.isnan(out[rows < t[0] - 1e-6]).all()
