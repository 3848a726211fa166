"""While a log is read it is said what share of it is read already, where that can be counted."""

from __future__ import annotations

import numpy as np
import pytest
from flights_made import made_flight
from writers_bag import write_bag2
from writers_crazyflie import floats, micro_sd
from writers_dataflash import dataflash_text
from writers_ulog import write_ulog

from infotraj.flight import Flight
from infotraj.importing import crazyflie, dataflash_messages, import_log, importer, reading, rosbag, table, ulog
from infotraj.importing.crazyflie import CrazyflieLog
from infotraj.importing.table_format import TableFormat


@pytest.fixture
def said(monkeypatch):
    """Names of parts and shares in the order in which they were said; each reader says so of every few messages."""
    out = []
    for module in (crazyflie, dataflash_messages, importer, reading, rosbag, table, ulog):
        monkeypatch.setattr(module, "reached", lambda part, done=0, of=1: out.append((part, done / of)))
        if hasattr(module, "_EVERY"):
            monkeypatch.setattr(module, "_EVERY", 7)
    return out


def shares(said):
    return [share for part, share in said if part == "reading"]


def throttles():
    flight = made_flight(0.6)
    commands = [c for c in flight.table if c.startswith("cmd_rotor")]
    return Flight(flight.table.assign(**dict.fromkeys(commands, 0.5)), {"source": "made"})


@pytest.mark.parametrize("kind", ["bag", "ulog", "dataflash"])
def test_messages_are_counted_as_they_are_read(kind, said, tmp_path):
    if kind == "bag":
        path = write_bag2(throttles(), tmp_path / "log", storage="mcap")
    elif kind == "ulog":
        path = write_ulog(throttles(), tmp_path / "log.ulg")
    else:
        path = tmp_path / "log.log"
        path.write_bytes(dataflash_text(throttles()))
    import_log(path)
    found = shares(said)
    assert len(found) > 20
    assert found == sorted(found)
    assert found[0] < 0.1
    assert 0.8 < found[-1] <= 1.0
    assert [part for part, _ in said][-1] == "checks"
    assert ("streams", 0.0) in said
    assert ("rows", 0.0) in said


def test_records_of_several_events_are_counted(said, tmp_path):
    t = np.arange(60) / 100.0
    values = np.zeros((60, 3))
    path = micro_sd(tmp_path / "log00", t, floats("gyro.", "x y z", values))
    data = bytearray(path.read_bytes())
    # A second event that is declared and never logged: records are walked one by one.
    data[3:5] = (2).to_bytes(2, "little")
    data[5:5] = (9).to_bytes(2, "little") + b"never\0" + (0).to_bytes(2, "little")
    path.write_bytes(data)
    CrazyflieLog(path, allow_damaged=True)
    found = shares(said)
    assert len(found) > 20
    assert found == sorted(found)
    assert 0.9 < found[-1] <= 1.0


@pytest.mark.parametrize("laid_out", [False, True])
def test_rows_of_a_text_are_counted_by_the_chunk(laid_out, said, monkeypatch, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t,x\n" + "".join(f"{k / 100},{k}\n" for k in range(30_000)))
    monkeypatch.setattr(table, "_CHUNK", 1000)
    log = table.TableFile(path, layout=TableFormat(separator=",") if laid_out else None)
    chunks = list(log._chunks(["t", "x"]))
    assert sum(map(len, chunks)) == 30_000
    found = shares(said)
    assert len(found) == 31
    assert found == sorted(found)
    assert found[0] == 0.0
    assert found[10] < 1.0
    assert found[-1] == 1.0


def test_rows_of_a_parquet_file_are_counted_by_the_chunk(said, tmp_path):
    path = tmp_path / "log.parquet"
    throttles().table.to_parquet(path)
    import_log(path)
    assert shares(said) == [0.0]
