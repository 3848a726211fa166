"""Broken inputs: each gets one clear line, exit status 3 (the log) or 2 (the call), no traceback, no output file."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from click.testing import CliRunner
from flights_made import made_flight
from test_import_bytes import bag1_bytes, crazyflie_v1_bytes, mcap_bytes
from writers_bag import write_bag1, write_bag2
from writers_ulog import FORMATS, ulog_bytes, write_ulog

from infotraj.errors import InfotrajError
from infotraj.flight import Flight, read_flight
from infotraj.importing.command import import_command

GOOD = made_flight(2.0)
THROTTLE = Flight(GOOD.table.assign(**{c: GOOD.table[c] / 1000 for c in GOOD.table if c.startswith("cmd_rotor_")}), {})


def run(arguments: list[str]) -> tuple[int, list[str]]:
    """Exit status and the lines that reject; an InfotrajError counts as the program's one line."""
    result = CliRunner().invoke(import_command, arguments)
    if isinstance(result.exception, InfotrajError):
        return result.exception.exit_status, str(result.exception).splitlines()
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise AssertionError(f"a traceback: {result.exception!r}") from result.exception
    return result.exit_code, [line for line in result.stderr.splitlines() if not line.startswith("note: ")]


def _table(**changes: object) -> pd.DataFrame:
    return GOOD.table.assign(**changes)


def _csv(change: Callable[[pd.DataFrame], pd.DataFrame | None]) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        table = GOOD.table.copy()
        changed = change(table)
        (changed if changed is not None else table).to_csv(folder / "log.csv", index=False)
        return folder / "log.csv"

    return make


def _bytes(name: str, data: bytes | Callable[[], bytes]) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        (folder / name).write_bytes(data() if callable(data) else data)
        return folder / name

    return make


def _whole(form: str, folder: Path) -> Path:
    if form == "bag":
        return write_bag1(GOOD, folder / "log.bag")
    if form in ("mcap", "db3"):
        kind = "mcap" if form == "mcap" else "sqlite3"
        bag = write_bag2(GOOD, folder / "made", storage=kind)  # type: ignore[arg-type]
        return bag / f"made.{form}"
    if form == "ulg":
        return write_ulog(THROTTLE, folder / "log.ulg")
    if form == "crazyflie":
        rows = [(1000 + k, [1.0, 2.0, 3.0]) for k in range(300)]
        return _bytes("log00", crazyflie_v1_bytes(rows, [(1000, 4.0)]))(folder)
    GOOD.write(folder / f"log.{form}")
    return folder / f"log.{form}"


def _cut(form: str, tenth: int) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        whole = _whole(form, folder)
        data = whole.read_bytes()
        keep = len(data) * tenth // 10
        if form == "csv":  # a cut at the end of a line is not seen; this one is inside of one
            keep = data.index(b"\n", keep) - 20
        path = folder / f"cut{whole.suffix}"
        path.write_bytes(data[:keep])
        return path

    return make


def _flipped(form: str, at: float) -> Callable[[Path], Path]:
    """Sixty-four bytes overwritten at a share of the file's length."""

    def make(folder: Path) -> Path:
        whole = _whole(form, folder)
        data = bytearray(whole.read_bytes())
        place = int(len(data) * at)
        data[place : place + 64] = bytes([0xFF]) * 64
        path = folder / f"flipped{whole.suffix}"
        path.write_bytes(bytes(data))
        return path

    return make


def _jump(seconds: float) -> Callable[[Path], Path]:
    """Header stamps that jump in the middle, while the recorder's clock goes on."""
    return lambda folder: write_bag1(GOOD, folder / "jump.bag", 10**13, lambda t: t + (seconds if t >= 1.0 else 0.0))


def _stamp(ns: int, k: int) -> list[tuple[int, list[float]]]:
    return [(ns + 10_000_000 * j, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]) for j in range(k)]


def _checked(data: bytes) -> bytes:
    return data[:-4] + struct.pack("<I", zlib.crc32(data[:-4]))


FAULTS: dict[str, Callable[[Path], Path]] = {
    **{f"{form} cut at {k}/10": _cut(form, k) for form in ("bag", "mcap", "db3", "ulg", "parquet") for k in range(10)},
    **{f"{form} cut at {k}/10": _cut(form, k) for form in ("csv", "crazyflie") for k in (1, 3, 5, 7, 9)},
    **{f"{form} overwritten at the start": _flipped(form, 0.0) for form in ("bag", "mcap", "db3", "ulg", "crazyflie")},
    **{f"{form} overwritten near the end": _flipped(form, 0.97) for form in ("bag", "crazyflie", "parquet")},
    "no such file": lambda folder: folder / "absent.bag",
    "an empty directory": lambda folder: folder,
    "a directory of two bags": lambda folder: (
        _bytes("a.mcap", b"x")(folder) and _bytes("b.mcap", b"x")(folder) and folder
    ),
    "a metadata.yaml alone": lambda folder: _bytes("metadata.yaml", b"rosbag2_bagfile_information: 3\n")(folder).parent,
    "an empty file": _bytes("log.csv", b""),
    "a text file named .mcap": _bytes("log.mcap", b"t,px,py,pz\n0,0,0,0\n1,0,0,0\n"),
    "a text file named .bag": _bytes("log.bag", b"hello\n"),
    "a text file named .ulg": _bytes("log.ulg", b"hello\n"),
    "a text file named .parquet": _bytes("log.parquet", b"t,px\n0,0\n"),
    "random bytes": _bytes("log.csv", bytes(np.random.default_rng(0).integers(0, 256, 4000, dtype=np.uint8))),
    "zero bytes": _bytes("log.ulg", bytes(5000)),
    "a picture": _bytes("log.png", b"\x89PNG\r\n\x1a\n" + bytes(100)),
    "a ULog header alone": _bytes("log.ulg", ulog_bytes(THROTTLE)[:16]),
    "a ULog without data": _bytes("log.ulg", lambda: ulog_bytes(THROTTLE)[: 16 + 43 + 60]),
    "a ULog of another version of flags": _bytes(
        "log.ulg", lambda: ulog_bytes(THROTTLE)[:27] + b"\xff" + ulog_bytes(THROTTLE)[28:]
    ),
    "a Crazyflie log of version 7": _bytes("log01", b"\xbc" + struct.pack("<HH", 7, 1) + bytes(40)),
    "a Crazyflie log of an unknown type": _bytes(
        "log01", b"\xbc" + struct.pack("<HHH", 2, 1, 0) + b"e\0" + struct.pack("<H", 1) + b"a(Z)\0" + bytes(40)
    ),
    "a Crazyflie log without known variables": _bytes(
        "log01", lambda: _checked(crazyflie_v1_bytes([(1, [0.0] * 3)], [(1, 4.0)]).replace(b"gyro.", b"gyru."))
    ),
    "an MCAP of an unknown encoding": _bytes("log.mcap", lambda: mcap_bytes(_stamp(10**9, 9), "syntax", "protobuf")),
    "an MCAP with a broken definition": _bytes("log.mcap", lambda: mcap_bytes(_stamp(10**9, 9), "float32[ xyz @@")),
    "an MCAP with no messages": _bytes("log.mcap", lambda: mcap_bytes([], "uint64 micros")),
    "a bag of one message": _bytes("log.bag", lambda: bag1_bytes(_stamp(10**9, 1))),
    "a bag whose stamps stand still": _bytes("log.bag", lambda: bag1_bytes(_stamp(10**9, 1) * 50)),
    "a bag whose definition lies": _bytes(
        "log.bag", lambda: bag1_bytes(_stamp(10**9, 50)).replace(b"float64 w\n", b"float32 w\n")
    ),
    "a bag clock set back by 1 s": _jump(-1.0),
    "a bag clock that jumps by a day": _jump(86400.0),
    "a CSV header alone": _csv(lambda d: d.iloc[:0]),
    "a CSV of one row": _csv(lambda d: d.iloc[:1]),
    "a CSV without t": _csv(lambda d: d.drop(columns="t")),
    "a CSV with t alone": _csv(lambda d: d[["t"]]),
    "a CSV with text in a column": _csv(lambda d: d.astype({"px": object}).replace({"px": {d.px[50]: "broken"}})),
    "a CSV with dates for t": _csv(lambda d: d.assign(t=pd.date_range("2024-01-01", periods=len(d)))),
    "a CSV with a column twice": _bytes("log.csv", b"t,px,px,py,pz\n" + b"0,1,1,1,1\n1,1,1,1,1\n"),
    "a CSV with too many fields in a row": _bytes("log.csv", b"t,px,py,pz\n0,1,1,1\n1,1,1,1,1,1\n2,1,1,1\n"),
    "a CSV with NUL bytes": _bytes("log.csv", b"t,px,py,pz\n0,1\0,1,1\n1,1,1,1\n2,1,1,1\n"),
    "a CSV in UTF-16": _bytes("log.csv", "t,px,py,pz\n0,1,1,1\n1,1,1,1\n".encode("utf-16")),
    "NaN in t": _csv(lambda d: d.assign(t=d.t.where(d.index != 30))),
    "infinity in t": _csv(lambda d: d.assign(t=d.t.where(d.index != 30, np.inf))),
    "NaN in every channel": _csv(lambda d: d.assign(**{c: np.nan for c in d if c != "t"})),
    "time running backwards": _csv(lambda d: d.assign(t=d.t[::-1].to_numpy())),
    "a step back in time": _csv(lambda d: d.assign(t=d.t.where(d.index < 80, d.t - 0.3))),
    "a CSV with a short row": _bytes("log.csv", b"t,px,py,pz\n0,1,1,1\n1,1\n2,1,1,1\n"),
    "a jump of two hours": _csv(lambda d: d.assign(t=d.t.where(d.index < 80, d.t + 7200))),
    "time standing still": _csv(lambda d: d.assign(t=1.0)),
    "a huge position": _csv(lambda d: d.assign(px=d.px.where(d.index != 9, 1e30))),
    "an infinite rate": _csv(lambda d: d.assign(wx=d.wx.where(d.index != 9, np.inf))),
    "a huge acceleration": _csv(lambda d: d.assign(az=1e12)),
    "quaternions of norm 2": _csv(lambda d: d.assign(**{c: 2 * d[c] for c in ("qw", "qx", "qy", "qz")})),
    "quaternions all zero": _csv(lambda d: d[["t", "qw", "qx", "qy", "qz"]] * [1, 0, 0, 0, 0]),
    "degrees in the quaternion's columns": _csv(lambda d: d.assign(qw=0.0, qx=10.0, qy=-20.0, qz=170.0)),
}


@pytest.mark.parametrize("fault", list(FAULTS))
def test_one_line_and_no_output(fault: str, tmp_path: Path) -> None:
    inputs, outputs = tmp_path / "in", tmp_path / "out"
    inputs.mkdir()
    outputs.mkdir()
    path = FAULTS[fault](inputs)
    status, lines = run([str(path), "-o", str(outputs / "flight.parquet")])
    assert status in (2, 3), (status, lines)
    assert len(lines) == 1, lines
    assert str(path) in lines[0]
    assert "; expected " in lines[0]
    assert "Traceback" not in lines[0]
    assert list(outputs.iterdir()) == []


def test_the_corpus_is_large_enough() -> None:
    assert len(FAULTS) >= 60
    assert set(FORMATS)  # the corpus is cut from files that are good when whole, which the next test shows


@pytest.mark.parametrize("form", ["bag", "mcap", "db3", "ulg", "crazyflie", "csv", "parquet"])
def test_the_whole_files_are_good(form: str, tmp_path: Path) -> None:
    status, lines = run([str(_whole(form, tmp_path)), "-o", str(tmp_path / "out.parquet")])
    assert status == 0, lines
    assert (tmp_path / "out.parquet").is_file()


@pytest.mark.parametrize("form", ["bag", "mcap", "db3", "csv", "parquet"])
def test_a_name_in_capitals_is_the_same_name(form: str, tmp_path: Path) -> None:
    small = _whole(form, tmp_path)
    capitals = small.rename(small.with_name(small.name.upper()))
    status, lines = run([str(capitals), "-o", str(tmp_path / "out.parquet")])
    assert status == 0, lines
    if form in ("csv", "parquet"):
        assert len(read_flight(capitals).t) == len(GOOD.t)


CALLS: dict[str, Callable[[Path], list[str]]] = {
    "no output": lambda f: [str(_whole("csv", f))],
    "an output of unknown kind": lambda f: [str(_whole("csv", f)), "-o", str(f / "x.xlsx")],
    "the log as output": lambda f: [str(_whole("csv", f)), "-o", str(f / "log.csv")],
    "an unknown mapping": lambda f: [str(_whole("csv", f)), "-o", str(f / "o.csv"), "--mapping", "nope"],
    "a mapping for another kind": lambda f: [str(_whole("csv", f)), "-o", str(f / "o.csv"), "--mapping", "px4_ulog"],
    "--to before --from": lambda f: [str(_whole("csv", f)), "-o", str(f / "o.csv"), "--from", "3", "--to", "2"],
    "unknown rows": lambda f: [str(_whole("csv", f)), "-o", str(f / "o.csv"), "--rows", "weather"],
    "definitions that are not there": lambda f: [
        str(_whole("bag", f)), "-o", str(f / "o.csv"), "--definitions", str(f / "none"),
    ],
    "one file for two logs": lambda f: [str(_whole("csv", f)), str(_whole("bag", f)), "-o", str(f / "o.csv")],
}  # fmt: skip


@pytest.mark.parametrize("call", list(CALLS))
def test_wrong_calls_are_status_2(call: str, tmp_path: Path) -> None:
    status, lines = run(CALLS[call](tmp_path))
    assert (status, len(lines)) == (2, 1), lines
    assert not (tmp_path / "o.csv").exists()


def _mapping(**changes: object) -> dict[str, object]:
    channel = {"fields": ["a", "b", "c"]}
    stream = {"name": "s", "channels": {"position": channel}}
    return {"name": "m", "reads": ["table"], "time": {"fields": "t"}, "streams": [stream], **changes}


def _channel(**changes: object) -> dict[str, object]:
    return _mapping(streams=[{"name": "s", "channels": {"position": {"fields": ["a", "b", "c"], **changes}}}])


MAPPINGS: dict[str, object] = {
    "no mapping": 3,
    "empty": {},
    "an unknown key": _mapping(colour="red"),
    "an unknown kind": _mapping(reads=["telepathy"]),
    "no streams": _mapping(streams=[]),
    "an unknown frame": _mapping(world="UP"),
    "left-handed axes": _mapping(body=["x", "y", "-z"]),
    "an unknown channel": _mapping(streams=[{"name": "s", "channels": {"mood": {"fields": "a"}}}]),
    "two fields for three": _channel(fields=["a", "b"]),
    "a unit of another dimension": _channel(unit="rpm"),
    "an order that is none": _mapping(
        streams=[{"name": "s", "channels": {"attitude": {"fields": ["a", "b", "c", "d"], "order": "zyyw"}}}]
    ),
    "a time unit that is none": _mapping(time={"fields": "t", "unit": "fortnight"}),
    "a broken pattern": _mapping(streams=[{"name": "s", "match": "(", "channels": {"battery": {"fields": "a"}}}]),
    "a name twice": _mapping(streams=[{"name": "s", "channels": {"battery": {"fields": "a"}}}] * 2),
    "a clock of an unknown channel": _mapping(clock={"channel": "sun"}),
    "a negative gap": _mapping(streams=[{"name": "s", "max_gap": -1, "channels": {"battery": {"fields": "a"}}}]),
    "no time": {k: v for k, v in _mapping().items() if k != "time"},
}


@pytest.mark.parametrize("name", list(MAPPINGS))
def test_wrong_mappings_are_status_2(name: str, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("t,a,b,c\n0,1,2,3\n1,1,2,3\n")
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(MAPPINGS[name]))
    status, lines = run(
        [str(tmp_path / "log.csv"), "-o", str(tmp_path / "o.csv"), "--mapping", str(tmp_path / "m.yaml")]
    )
    assert (status, len(lines)) == (2, 1), lines
    assert not (tmp_path / "o.csv").exists()
