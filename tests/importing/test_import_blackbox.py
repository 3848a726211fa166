"""Blackbox logs: equal to what another decoder (blackbox-log, in Rust) read from these files, and true to physics."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from flights_made import made_flight
from writers_blackbox import blackbox_bytes

from infotraj import rotations
from infotraj.cli import cli
from infotraj.datasets.location import find_dataset
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.importing import import_log
from infotraj.importing.blackbox import BlackboxLog
from infotraj.importing.blackbox_frames import AVERAGE

LOGS = ["error-recovery.bbl", "LOG00037.BFL", "btfl_001.bbl", "btfl_002.bbl", "btfl_all.bbl"]


def _data() -> Path:
    folder = find_dataset("blackbox")
    if folder is None:
        pytest.skip("no blackbox logs under $INFOTRAJ_DATA")
    return folder


def _log(name: str) -> Path:
    inside = "expected/tests/logs" if name.startswith("error") else "src/test-data"
    return _data() / inside / name


def _expected(name: str) -> list[str]:
    """What the other decoder says of the first two logs of a file, as text."""
    short = "snapshots__own.snap" if name.startswith("error") else f"snapshots__fc_blackbox@{name}.snap"
    text = (_data() / "expected/tests/snapshots" / short).read_text()
    return re.split(r"\n    Ok\(Log\(", text)[1:]


def _field_lines(text: str) -> dict[str, dict[str, Any]]:
    found = {}
    for name, body in re.findall(
        r'name: "([^"]+)",\s+unit: \w+,\s+history: FieldSnapshot\((.*?)\n            \)', text, re.S
    ):
        found[name] = _numbers(body)
    return found


def _numbers(body: str) -> dict[str, Any]:
    said: dict[str, Any] = {k: int(v) for k, v in re.findall(r"(min|max|unique): (-?\d+)", body)}
    counts = re.search(r"histogram: \(([^)]*)\)", body)
    said["histogram"] = [int(c) for c in counts[1].split(",") if c.strip()] if counts else None
    return said


def _summary(values: np.ndarray) -> dict[str, Any]:
    """The other decoder's summary: it starts from 0, and its histogram counts |value| modulo 16."""
    whole = np.round(values).astype(np.int64)
    unique = len(np.unique(whole))
    counts = np.bincount(np.abs(whole) % 16, minlength=16).tolist()
    return {
        "min": min(int(whole.min()), 0),
        "max": max(int(whole.max()), 0),
        "unique": unique,
        "histogram": counts if unique > 1 else None,
    }


def _with_its_history(name: str, log: BlackboxLog) -> np.ndarray:
    """A field as the other decoder predicts it: behind a complete frame it averages with the frame before that.

    The firmware starts its history anew with each complete frame; the other decoder's motors pass full scale (2075 of
    2047 in btfl_002). Ours are turned into its numbers here, from the differences that the log holds.
    """
    ours = np.round(_raw(name, log)).astype(np.int64).tolist()
    whole = (log._main["loopIteration"] % int(log.header.number("I interval")) == 0).tolist()
    theirs: list[int] = []
    for k, value in enumerate(ours):
        if whole[k]:
            theirs.append(value)
            continue
        before = ours[k - 1] if whole[k - 1] else ours[k - 2]
        difference = value - int((ours[k - 1] + before) / 2)
        theirs.append(difference + int((theirs[k - 1] + (theirs[k - 2] if k > 1 else theirs[k - 1])) / 2))
    return np.array(theirs)


def _raw(name: str, log: BlackboxLog) -> np.ndarray:
    counts = log.header.number("acc_1G") if name.startswith("accSmooth") else 1.0
    return log._main[name] * counts


def _in_its_units(name: str, log: BlackboxLog) -> np.ndarray:
    values = log._main[name].astype(float)
    if log.header.coding["P"][0, log.header.names["I"].index(name)] == AVERAGE:
        values = _with_its_history(name, log).astype(float)
        if name.startswith("accSmooth"):
            values /= log.header.number("acc_1G")
    if name == "loopIteration":
        # It counts logged loops one by one from each complete frame; ours are the loops that the header says.
        every = log.header.number("P interval")
        whole = log.header.number("I interval")
        return values // whole * whole + values % whole / every
    if name.startswith("vbatLatest"):
        return values * 1000.0  # mV
    if name.startswith("amperageLatest"):
        return values * 10.0  # mA
    if name.startswith("accSmooth"):
        return values * 980.665  # cm/s^2
    return values


@pytest.mark.parametrize("name", LOGS)
def test_every_field_is_what_the_other_decoder_read(name: str) -> None:
    compared = 0
    for number, text in enumerate(_expected(name), start=1):
        count = {k: int(re.search(rf"\b{k}: (\d+)", text)[1]) for k in ("main", "slow", "gps", "gps_home")}  # type: ignore[index]
        if count["main"] < 2:
            continue
        log = BlackboxLog(_log(name).with_name(f"{name}#{number}"))
        assert log.topics[0].messages == count["main"]
        assert log.topics[1].messages == count["slow"]
        clock = re.search(r"main: MainFrame\(.*?time: FieldSnapshot\((.*?)\n        \)", text, re.S)
        assert clock is not None
        assert _summary(log._main["time"]) == _numbers(clock[1])
        fields = _field_lines(text[clock.end() : text.index("slow: SlowFrame")])  # before the rare frames' fields
        assert {"gyroADC[2]", "accSmooth[0]", "motor[3]", "vbatLatest", "loopIteration"} <= set(fields)
        for field, expected in fields.items():
            assert _summary(_in_its_units(field, log)) == expected, field
            compared += 1
        armed = re.search(r'"ARM": (\d+)', text)
        assert int(log._slow["armed"].sum()) == int(armed[1] if armed else 0)
        unknown = dict(re.findall(r'^          "([^"]+)": "([^"]*)",$', text, re.M))
        assert len(unknown) > 60
        assert {k: log.header.values.get(k) for k in unknown} == unknown
    assert compared >= 33


def test_events_and_rare_frames_are_those_of_the_other_decoder() -> None:
    from infotraj.importing import blackbox
    from infotraj.importing.blackbox_header import MAGIC

    kinds = {"SyncBeep": 0, "FlightMode": 30, "Disarm": 15, "Resume": 14}
    for name in LOGS:
        data = _log(name).read_bytes()
        starts = [*blackbox._places(data, MAGIC), len(data)]
        for text, a, b in zip(_expected(name), starts[:-1], starts[1:], strict=False):
            _, _, _, counts, events = blackbox._decoded(data[a:b])
            block = re.search(r"events: \[(.*?)\n      \]", text, re.S)
            wanted = [
                (kinds[kind], [int(v) for v in re.findall(r"\d+", rest)])
                for kind, rest in re.findall(
                    r"(SyncBeep|FlightMode|Disarm|Resume)\(([^)]*)\)", block[1] if block else ""
                )
            ]
            # It repeats a disarm at the end of one log, and leaves out some logs' ends.
            wanted = [w for k, w in enumerate(wanted) if k == 0 or w != wanted[k - 1]]
            ours = [(int(e[0]), [int(v) for v in e[1:3]][: 1 if e[0] in (0, 15) else 2]) for e in events if e[0] != 255]
            assert ours == wanted, name
            frames = [re.findall(rf"\b{k}: (\d+)", text)[0] for k in ("gps", "gps_home")]
            assert [int(c) for c in counts[2:4]] == [int(f) for f in frames]


def test_gyro_and_accelerometer_turn_together_as_forward_left_up_axes_do() -> None:
    """The mean specific force over seconds is gravity, in axes turned by the gyro, and for no mirrored gyro."""
    flight = import_log(_log("btfl_002.bbl"))
    t, rate, force = flight.t[::4], flight.get("wx", "wy", "wz")[::4], flight.get("ax", "ay", "az")[::4]
    scatter = {}
    for mirror in ((1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)):
        turns = rotations.exp(rate * mirror * float(np.median(np.diff(t))))
        found = []
        for start in range(0, len(t) - 750, 750):
            q = np.empty((750, 4))
            q[0] = 1.0, 0.0, 0.0, 0.0
            for k in range(1, 750):
                q[k] = rotations.multiply(q[k - 1], turns[start + k - 1])
            thirds = rotations.to_world(q, force[start : start + 750]).reshape(3, 250, 3).mean(axis=1)
            found.append(np.linalg.norm(thirds - thirds.mean(axis=0)))
        scatter[mirror] = np.median(found)
    assert min(scatter, key=lambda m: scatter[m]) == (1, 1, 1)
    assert sorted(scatter.values())[1] > 1.5 * scatter[1, 1, 1]
    # Motors in the firmware's order: left minus right rolls right, rear minus front lowers the nose.
    motors = np.nan_to_num(flight.numbered("cmd_rotor_"))[::4]
    turning = np.gradient(rate, t, axis=0)
    kernel = np.ones(5) / 5
    smooth = lambda x: np.convolve(x, kernel, "same")  # noqa: E731
    left = smooth(motors[:, 2] + motors[:, 3] - motors[:, 0] - motors[:, 1])
    rear = smooth(motors[:, 0] + motors[:, 2] - motors[:, 1] - motors[:, 3])
    assert np.corrcoef(left[:-3], smooth(turning[:, 0])[3:])[0, 1] > 0.3
    assert np.corrcoef(rear[:-3], smooth(turning[:, 1])[3:])[0, 1] > 0.15
    assert np.median(force[:, 2]) == pytest.approx(9.8, abs=1.0)
    assert 0.0 <= motors.min() <= motors.max() <= 1.0


def test_a_file_of_several_logs_is_refused_with_their_names_and_each_has_an_address(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"holds 2 logs.*btfl_001.bbl#2 \(50.0 s\), btfl_001.bbl#1 \(0.2 s\)"):
        import_log(_log("btfl_001.bbl"))
    call = [str(_log("btfl_001.bbl")) + number for number in ("#1", "#2")]
    found = CliRunner().invoke(cli, ["import", *call, "-o", str(tmp_path)])
    assert found.exit_code == 0, found.output
    assert sorted(p.name for p in tmp_path.iterdir()) == ["btfl_001.bbl#1.parquet", "btfl_001.bbl#2.parquet"]
    assert CliRunner().invoke(cli, ["import", call[0][:-1] + "3", "-o", str(tmp_path)]).exit_code == 3
    assert CliRunner().invoke(cli, ["check", *call]).exit_code in (0, 3)


def test_damaged_stretches_are_left_out_and_counted(tmp_path: Path) -> None:
    whole = BlackboxLog(_log("LOG00037.BFL"))
    data = bytearray(_log("LOG00037.BFL").read_bytes())
    generator = np.random.default_rng(3)
    for place in generator.integers(20_000, len(data), 40):
        data[place : place + 3] = b""  # bytes that a slow flash lost
    path = tmp_path / "lost.bfl"
    path.write_bytes(data)
    log = BlackboxLog(path)
    assert "damaged stretches" in log.notes[0]
    kept, times = np.isin(log._main["time"], whole._main["time"]), whole._main["time"]
    assert 0.8 * len(times) < kept.sum() <= len(kept) < len(times)
    # What is kept is what the whole log has, but for the frames that hide the loss by chance.
    same = [np.searchsorted(times, t) for t in log._main["time"][kept]]
    for name in ("gyroADC[0]", "motor[2]", "accSmooth[1]"):
        assert np.mean(log._main[name][kept] == whole._main[name][same]) > 0.99


def test_units_come_from_the_header(tmp_path: Path) -> None:
    data = _log("LOG00037.BFL").read_bytes()
    plain = import_log(_log("LOG00037.BFL"))

    def imported(**changed: bytes) -> Any:
        text = data
        for old, new in changed.items():
            text = re.sub(rb"\nH " + old.encode() + rb":[^\n]*", b"\nH " + new, text)
        path = tmp_path / "changed.bfl"
        path.write_bytes(text)
        return import_log(path)

    fine = imported(gyro_scale=b"gyro_scale:0x3f000000", acc_1G=b"acc_1G:4096")
    np.testing.assert_allclose(fine.get("wx"), plain.get("wx") / 2)
    np.testing.assert_allclose(fine.get("az"), plain.get("az") / 2)
    tenth = imported(gyro_scale=b"gyro_scale:0x3f800000\nH blackbox_high_resolution:1")
    np.testing.assert_allclose(tenth.get("wy"), plain.get("wy") / 10)
    pulses = imported(motorOutput=b"motorOutput:1000,2000")
    motors = (
        BlackboxLog(_log("LOG00037.BFL"))._main["motor[1]"] - BlackboxLog(tmp_path / "changed.bfl")._main["motor[1]"]
    )
    # The least output is what the file's differences count from; a stopped motor (0) is no negative throttle.
    assert np.median(motors) == 158 - 1000
    assert pulses.numbered("cmd_rotor_").min() >= 0.0
    unknown = imported(acc_1G=b"acc_2G:4096")
    assert not unknown.has("az")
    assert any("accSmooth left out" in note for note in unknown.meta["notes"])


def test_a_written_log_comes_back_through_every_encoding(tmp_path: Path) -> None:
    flight = made_flight(3.0)
    names = [c for c in flight.table if c.startswith("cmd_rotor_")]
    flight = Flight(flight.table.assign(**{c: flight.table[c] / 1000.0 for c in names}), {})
    path = tmp_path / "quad.bbl"
    path.write_bytes(blackbox_bytes(flight))
    found = import_log(path)
    np.testing.assert_allclose(found.t, flight.t + 3.0, atol=1e-9)
    np.testing.assert_allclose(found.get("wx", "wy", "wz"), flight.get("wx", "wy", "wz"), atol=np.radians(0.5001))
    np.testing.assert_allclose(found.get("ax", "ay", "az"), flight.get("ax", "ay", "az"), atol=0.5001 * 9.80665 / 2048)
    np.testing.assert_allclose(found.numbered("cmd_rotor_"), flight.numbered("cmd_rotor_"), atol=0.5001 / 1999)
    turns = flight.numbered("cmd_rotor_") * 10_000 * np.pi / 30
    np.testing.assert_allclose(found.numbered("rotor_"), turns, atol=0.5001 * 100 / 7 * np.pi / 30)
    np.testing.assert_allclose(found.get("battery"), flight.get("battery"), atol=0.005001)
    assert found.meta["notes"] == []
