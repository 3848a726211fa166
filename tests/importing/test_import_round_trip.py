"""A flight table written in every format and imported again equals the original to the precision of the format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from flights_made import made_flight
from writers_bag import write_bag1, write_bag2
from writers_table import NED_MAPPING, write_ned_csv
from writers_ulog import write_ulog

from infotraj.flight import Flight, read_flight
from infotraj.importing import import_log, parse_mapping

DOUBLE = 2e-14  # relative to the largest value of a column: a few roundings of a double
SINGLE = 4e-7  # of a float32


def assert_equal(found: Flight, wanted: Flight, relative: float, columns: list[str] | None = None) -> None:
    columns = columns or [c for c in wanted.table if c != "t"]
    np.testing.assert_allclose(found.t, wanted.t, rtol=0, atol=1e-9)
    if "qw" in columns:
        q, p = found.get("qw", "qx", "qy", "qz"), wanted.get("qw", "qx", "qy", "qz")
        sign = np.where(np.einsum("ij,ij->i", q, p) < 0, -1.0, 1.0)[:, None]
        np.testing.assert_allclose(q * sign, p, rtol=0, atol=relative)
    for name in (c for c in columns if c not in ("qw", "qx", "qy", "qz")):
        expected = wanted.table[name].to_numpy()
        scale = max(1.0, float(np.nanmax(np.abs(expected))))
        np.testing.assert_allclose(
            found.table[name].to_numpy(), expected, rtol=0, atol=relative * scale, equal_nan=True, err_msg=name
        )


@pytest.fixture(scope="module")
def flight() -> Flight:
    return made_flight()


@pytest.fixture(scope="module")
def gappy(flight: Flight) -> Flight:
    """The same with single lost commands, a battery every tenth row, 0.3 s without IMU, and 0.5 s without anything."""
    table = flight.table.copy()
    table.loc[table.index % 10 != 0, "battery"] = np.nan
    table.loc[[7, 40, 41, 90], [c for c in table if c.startswith("cmd_")]] = np.nan
    table.loc[100:129, ["ax", "ay", "az"]] = np.nan
    kept = table.drop(index=range(200, 250)).reset_index(drop=True)
    return Flight(kept, {"source": "gappy"})


@pytest.mark.parametrize("which", ["flight", "gappy"])
@pytest.mark.parametrize("form", ["bag1", "mcap", "sqlite3"])
def test_bag(which: str, form: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    wanted = request.getfixturevalue(which)
    path = (
        write_bag1(wanted, tmp_path / "log.bag")
        if form == "bag1"
        else write_bag2(wanted, tmp_path / "log", storage=form)  # type: ignore[arg-type]
    )
    found = import_log(path)
    assert found.meta["mapping"] == "ros"
    assert found.meta["derived"] == []
    # The battery is a float32 in its message. The gyro is the IMU's, and stops where the IMU stops.
    columns = [c for c in wanted.table if c not in ("t", "battery", "wx", "wy", "wz")]
    assert_equal(found, wanted, DOUBLE, columns)
    assert_equal(found, wanted, SINGLE, ["battery"])
    rate = wanted.get("wx", "wy", "wz").copy()
    rate[np.isnan(wanted.get("ax")[:, 0])] = np.nan
    np.testing.assert_array_equal(found.get("wx", "wy", "wz"), rate)
    assert found.meta["clock"]["gaps"] == (1 if which == "gappy" else 0)
    if which == "gappy":
        assert found.meta["channels"]["specific_force"]["gaps"]["count"] == 2
        assert found.meta["clock"]["longest_gap_s"] == pytest.approx(0.51)


def test_bare_storage_files(flight: Flight, tmp_path: Path) -> None:
    for storage, suffix in (("mcap", "mcap"), ("sqlite3", "db3")):
        folder = write_bag2(flight, tmp_path / storage, storage=storage)  # type: ignore[arg-type]
        for path in (folder / f"{storage}.{suffix}", folder):
            assert_equal(import_log(path), flight, DOUBLE, ["px", "qw", "vx", "cmd_rotor_3", "cmd_tilt_1"])
        (folder / "metadata.yaml").unlink()
        assert len(import_log(folder).table) == len(flight.table)


@pytest.mark.parametrize("which", ["flight", "gappy"])
def test_ulog(which: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    original = request.getfixturevalue(which)
    throttle = {c: original.table[c] / 1000.0 for c in original.table if c.startswith("cmd_rotor_")}
    table = original.table.assign(**throttle).drop(columns=["cmd_tilt_0", "cmd_tilt_1"])
    table[["ax", "ay", "az"]] = table[["ax", "ay", "az"]].ffill()
    wanted = Flight(table, {})
    found = import_log(write_ulog(wanted, tmp_path / "log.ulg"))
    assert found.meta["mapping"] == "px4_ulog"
    np.testing.assert_allclose(found.t, wanted.t + 5.0, atol=1e-9)  # the vehicle's boot clock is kept
    moved = Flight(found.table.assign(t=found.t - 5.0), found.meta)
    assert_equal(moved, wanted, SINGLE)
    assert sum(c.startswith("cmd_rotor_") for c in found.table) == 4  # the unused places of control[12] are dropped
    assert any("battery_status[1] would fit too" in note for note in found.meta["notes"])


def test_csv_in_ned_with_degrees(flight: Flight, tmp_path: Path) -> None:
    path = write_ned_csv(flight, tmp_path / "log.csv")
    found = import_log(path, parse_mapping(NED_MAPPING))
    assert_equal(found, flight, 1e-13)


@pytest.mark.parametrize("name", ["log.csv", "log.parquet"])
def test_flight_table_is_kept_to_the_bit(name: str, gappy: Flight, tmp_path: Path) -> None:
    gappy.write(tmp_path / name)
    found = import_log(tmp_path / name)
    assert found.meta["mapping"] == "flight_table"
    pd.testing.assert_frame_equal(found.table, gappy.table, check_exact=True)
    found.write(tmp_path / f"again_{name}")
    again = read_flight(tmp_path / f"again_{name}")
    pd.testing.assert_frame_equal(again.table, gappy.table, check_exact=True)
    assert again.meta["mapping"] == "flight_table"
    assert again.meta["source_sha256"] == found.meta["source_sha256"]
