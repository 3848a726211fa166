"""ArduPilot DataFlash logs: equal to what pymavlink dumped of a real one, and back from a written one."""

from __future__ import annotations

import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flights_made import made_flight
from writers_dataflash import dataflash_bytes, dataflash_text

from infotraj import rotations
from infotraj.datasets.location import find_dataset
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.importing import import_log
from infotraj.importing.dataflash_messages import read_binary


def _folder() -> Path:
    folder = find_dataset("dataflash")
    if folder is None:
        pytest.skip("no DataFlash log under $INFOTRAJ_DATA")
    return folder / "tests"


def _dumped() -> dict[str, list[dict[str, str]]]:
    found: dict[str, list[dict[str, str]]] = {}
    text = (_folder() / "test.BIN.py3.dumped").read_text()
    for name, body in re.findall(r"^\d{4}-\S+ \S+: (\w+) \{(.*)\}$", text, re.M):
        fields = re.findall(r"(\w+) : (.*?)(?=, \w+ : |$)", body)
        found.setdefault(name, []).append(dict(fields))
    return found


def test_whole_numbers_beyond_those_of_a_float_are_read_exactly() -> None:
    value = 2**53 + 1
    head = bytes([0xA3, 0x95])
    form = struct.pack("<BB4s16s64s", 7, 3 + 16, b"BIG", b"Qq", b"Up,Down")
    log = read_binary(head + bytes([128]) + form + head + bytes([7]) + struct.pack("<Qq", value, -value))
    assert [int(log.columns["BIG"][c][0]) for c in ("Up", "Down")] == [value, -value]


def test_every_number_of_a_real_log_is_what_pymavlink_dumped() -> None:
    log = read_binary((_folder() / "test.BIN").read_bytes())
    compared = 0
    dumped = _dumped()
    assert len(dumped) > 45
    for name, messages in dumped.items():
        if name == "FMT":
            continue
        columns = log.columns[name]
        for field in messages[0]:
            ours, theirs = columns[field], [m[field] for m in messages]
            if ours.dtype.kind == "S":
                assert log.text(name, field) == theirs
            else:
                np.testing.assert_allclose(
                    np.asarray(ours, dtype=float),
                    [float(v) for v in theirs],
                    rtol=1e-12,
                    atol=0,
                    err_msg=f"{name}.{field}",
                )
            assert len(ours) == len(messages)
            compared += len(messages)
    assert compared > 10_000
    assert {name for name, c in log.columns.items() if len(next(iter(c.values())))} - {"FMT"} == set(dumped) - {"FMT"}


def test_a_real_log_becomes_a_flight_table() -> None:
    flight = import_log(_folder() / "test.BIN")
    assert flight.meta["mapping"] == "ardupilot"
    # A plane at rest on the runway, simulated: the accelerometer measures one g upwards, and the attitudes agree.
    assert np.median(flight.get("az")) == pytest.approx(9.8, abs=0.1)
    up = rotations.to_world(flight.get("qw", "qx", "qy", "qz"), flight.get("ax", "ay", "az"))
    good = np.isfinite(up).all(axis=1)
    assert np.median(up[good, 2]) == pytest.approx(9.8, abs=0.15)


def _throttled(seconds: float = 3.0) -> Flight:
    flight = made_flight(seconds)
    names = [c for c in flight.table if c.startswith("cmd_rotor_")]
    return Flight(flight.table.assign(**{c: flight.table[c] / 1000.0 for c in names}), {})


@pytest.mark.parametrize("text", [False, True])
def test_a_written_copter_log_comes_back(tmp_path: Path, text: bool) -> None:
    flight = _throttled()
    path = tmp_path / ("flight.log" if text else "flight.BIN")
    path.write_bytes(dataflash_text(flight) if text else dataflash_bytes(flight))
    found = import_log(path)
    np.testing.assert_allclose(found.t, flight.t + 60.0, atol=1e-9)
    for name, tolerance in (("px", 1e-5), ("vy", 1e-5), ("wx", 1e-5), ("az", 1e-5)):
        np.testing.assert_allclose(found.table[name], flight.table[name], atol=tolerance, err_msg=name)
    apart = rotations.angle_between(found.get("qw", "qx", "qy", "qz"), flight.get("qw", "qx", "qy", "qz"))
    assert apart.max() < np.radians(0.01)
    # The outputs stand in another order than the motors, at 1100 to 1900 us, in whole us.
    motors = found.numbered("cmd_rotor_")
    np.testing.assert_allclose(motors, flight.numbered("cmd_rotor_"), atol=0.51 / 800)
    np.testing.assert_allclose(found.numbered("rotor_") * 30 / np.pi, 10_000 * motors, rtol=0.01, atol=10)
    assert found.table["battery"].dropna().between(10, 20).all()


@pytest.mark.parametrize(
    ("pulses", "low", "high"),
    [
        ({"MOT_PWM_MIN": 0.0, "MOT_PWM_MAX": 0.0, "RC3_MIN": 1100.0, "RC3_MAX": 1900.0}, 1100.0, 1900.0),
        ({"MOT_PWM_MIN": 0.0, "MOT_PWM_MAX": 0.0}, 1000.0, 2000.0),
        ({"Q_M_PWM_MIN": 1000.0, "Q_M_PWM_MAX": 1900.0}, 1000.0, 1900.0),
    ],
)
def test_pulses_are_scaled_by_the_parameters_that_count(
    tmp_path: Path, pulses: dict[str, float], low: float, high: float
) -> None:
    flight = _throttled(1.0)
    path = tmp_path / "flight.BIN"
    path.write_bytes(dataflash_bytes(flight, pulses=pulses))
    wanted = (1100 + 800 * flight.numbered("cmd_rotor_") - low) / (high - low)
    np.testing.assert_allclose(import_log(path).numbered("cmd_rotor_"), wanted, atol=0.51 / (high - low))


def test_outputs_that_no_parameter_calls_motors_are_left_out_with_a_note(tmp_path: Path) -> None:
    path = tmp_path / "flight.BIN"
    path.write_bytes(dataflash_bytes(_throttled(1.0), functions=(33, 34, 70, 71)))
    found = import_log(path)
    assert found.numbered("cmd_rotor_").shape[1] == 2
    path.write_bytes(dataflash_bytes(_throttled(1.0), functions=(4, 19, 70, 71)))
    found = import_log(path)
    assert found.numbered("cmd_rotor_").shape[1] == 0
    assert any("SERVOn_FUNCTION" in note for note in found.meta["notes"])


@pytest.mark.parametrize("tilt", [75, 39])
def test_a_tricopters_motors_are_1_2_and_4_and_what_tilts_is_said(tmp_path: Path, tilt: int) -> None:
    flight = _throttled(1.0)
    path = tmp_path / "flight.BIN"
    frame = {"MOT_PWM_MIN": 1100.0, "MOT_PWM_MAX": 1900.0, "FRAME_CLASS": 7.0}
    path.write_bytes(dataflash_bytes(flight, functions=(33, 34, 36, tilt), pulses=frame))
    found = import_log(path)
    motors = flight.numbered("cmd_rotor_")
    np.testing.assert_allclose(found.numbered("cmd_rotor_"), motors[:, [0, 1, 3]], atol=0.51 / 800)
    assert found.numbered("rotor_").shape[1] == 3
    assert "motors 1, 2 and 4 of a tricopter are read as rotors 0, 1 and 2" in found.meta["notes"]
    assert any(note.startswith("outputs 4 tilt rotors (SERVOn_FUNCTION)") for note in found.meta["notes"])


@pytest.mark.parametrize(
    ("functions", "why"),
    [
        ((4, 33, 19, 20), None),
        ((4, 19, 70, 71), "no parameters SERVOn_FUNCTION in the log that say which outputs are motors"),
        ((33, 34, 36, 1), "SERVOn_FUNCTION gives outputs to motors 1, 2, 4, but none to motor 3"),
        ((33, 34, 35, 37), "SERVOn_FUNCTION gives outputs to motors 1, 2, 3, 5, but none to motor 4"),
        ((33, 34, 35, 39), "SERVOn_FUNCTION gives outputs to motors 1, 2, 3, 7, but none to motor 4, 5, 6"),
        ((35, 36, 1, 1), "SERVOn_FUNCTION gives outputs to motors 3, 4, but none to motor 1, 2"),
    ],
)
def test_esc_telemetry_is_refused_where_the_outputs_are(
    tmp_path: Path, functions: tuple[int, ...], why: str | None
) -> None:
    """An ESC's number is its output's: without the motor's number its speed is of no rotor that is known."""
    path = tmp_path / "flight.BIN"
    path.write_bytes(dataflash_bytes(_throttled(1.0), functions=functions, every_esc=True))
    found = import_log(path)
    numbers = 1 if why is None else 0
    assert found.numbered("rotor_").shape[1] == found.numbered("cmd_rotor_").shape[1] == numbers
    for name in ("RCOU", "ESC"):
        assert (f"{name} not used: {why}" in found.meta["notes"]) == (why is not None)


def test_bytes_between_messages_are_skipped_and_counted(tmp_path: Path) -> None:
    flight = _throttled(2.0)
    data = dataflash_bytes(flight)
    place = data.rindex(b"\xa3\x95", 0, len(data) // 2)
    path = tmp_path / "flight.bin"
    path.write_bytes(data[:place] + b"\x00\xa3\x95\x01garbage" + data[place:-5])
    found = import_log(path)
    assert "11 bytes belong to no message and are left out" in found.meta["notes"]
    assert len(found.t) >= len(flight.t) - 1
    path.write_bytes(data[:3] + bytes(200))
    with pytest.raises(InputError):
        import_log(path)


def test_a_stranger_among_the_units_changes_nothing(tmp_path: Path) -> None:
    """Two IMUs and two estimator cores are topics a number; the first is taken."""
    flight = _throttled(1.0)
    path = tmp_path / "flight.bin"
    path.write_bytes(dataflash_bytes(flight, second_imu_off=5.0))
    found: Any = import_log(path)
    np.testing.assert_allclose(found.table["wx"], flight.table["wx"], atol=1e-5)
    assert any("IMU[1] would fit too" in note for note in found.meta["notes"])
