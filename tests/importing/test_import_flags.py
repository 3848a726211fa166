"""Which topic holds the motors, and what a log's own flags say about being in the air."""

from __future__ import annotations

import struct
import textwrap
from pathlib import Path

import numpy as np
import pytest
import writers_ulog
from flights_made import made_flight
from writers_dataflash import dataflash_bytes

from infotraj.errors import UsageError
from infotraj.flight import Flight
from infotraj.importing import import_log, parse_mapping
from infotraj.importing.flags import as_flags, in_the_air
from infotraj.importing.settings import parse_settings

OUTPUTS = "actuator_outputs:uint64_t timestamp;uint32_t noutputs;float[16] output;uint8_t[4] _padding0;"


def _throttled(seconds: float = 4.0) -> Flight:
    flight = made_flight(seconds)
    names = [c for c in flight.table if c.startswith("cmd_rotor_")]
    return Flight(flight.table.assign(**{c: flight.table[c] / 1000.0 for c in names}), {})


def _ulog(flight: Flight, formats: list[str], topics: list[tuple[str, int]], data: list[tuple[int, bytes]]) -> bytes:
    """A ULog with more topics: formats, (name, instance) with identities from 100 on, and (identity, message)."""
    whole = writers_ulog.ulog_bytes(flight)
    place = whole.index(b"A", whole.index(b"sys_name")) - 2
    added = b"".join(writers_ulog._message("F", f.encode()) for f in formats)
    out = bytearray(whole[:place] + added + whole[place:])
    for k, (name, instance) in enumerate(topics):
        out += writers_ulog._message("A", struct.pack("<BH", instance, 100 + k) + name.encode())
    for identity, body in data:
        out += writers_ulog._message("D", struct.pack("<H", identity) + body)
    return bytes(out)


def test_of_two_instances_of_outputs_the_one_that_moves_is_taken(tmp_path: Path) -> None:
    flight = _throttled(2.0)
    data = []
    for k, t in enumerate(flight.t):
        us = 5_000_000 + round(t * 1e6)
        moving = [1000.0 + 800.0 * v for v in flight.numbered("cmd_rotor_")[k]]
        data.append((100, struct.pack("<QI16f", us, 8, *[0.0] * 16)))
        data.append((101, struct.pack("<QI16f", us, 4, *moving, *[0.0] * 12)))
    path = tmp_path / "two.ulg"
    # Without actuator_motors, as PX4 before 1.13 logs.
    text = _ulog(flight, [OUTPUTS], [("actuator_outputs", 0), ("actuator_outputs", 1)], data)
    path.write_bytes(text.replace(b"actuator_motors", b"actuator_xotors"))
    found = import_log(path)
    assert found.meta["channels"]["rotor_command"]["instance"] == 1
    wanted = 0.8 * flight.numbered("cmd_rotor_")
    np.testing.assert_allclose(found.numbered("cmd_rotor_"), wanted, atol=1e-4)
    assert "outputs: of actuator_outputs 0 fields change, of actuator_outputs[1] 4" in found.meta["notes"]


def test_the_instance_with_a_gimbal_does_not_hide_the_motors_and_can_be_asked_for(tmp_path: Path) -> None:
    flight = _throttled(2.0)
    data = []
    for k, t in enumerate(flight.t):
        us = 5_000_000 + round(t * 1e6)
        gimbal = [900.0] * 5 + [1500.0 + 100.0 * np.sin(t)] + [900.0] * 2
        data.append((100, struct.pack("<QI16f", us, 8, *gimbal, *[0.0] * 8)))
        moving = 1000.0 + 1000.0 * flight.numbered("cmd_rotor_")[k]
        data.append((101, struct.pack("<QI16f", us, 4, *moving, *[0.0] * 12)))
    path = tmp_path / "two.ulg"
    text = _ulog(flight, [OUTPUTS], [("actuator_outputs", 0), ("actuator_outputs", 1)], data)
    path.write_bytes(text.replace(b"actuator_motors", b"actuator_xotors"))
    found = import_log(path)
    np.testing.assert_allclose(found.numbered("cmd_rotor_"), flight.numbered("cmd_rotor_"), atol=1e-4)
    assert any("--set rotor_command.instance=0" in note for note in found.meta["notes"])
    other = import_log(path, settings=parse_settings(["rotor_command.instance=0"]))
    assert other.numbered("cmd_rotor_").shape[1] == 8
    assert other.meta["settings"] == ["rotor_command.instance=0"]


@pytest.mark.parametrize(
    ("low", "high", "off", "taken"),
    [(0, 1999, 0, False), (0, 1500, None, False), (1000, 2000, 0, True), (1000, 2000, 900, True)],
    ids=["dshot", "dshot in the air", "pulses", "pulses with a ramp"],
)
def test_outputs_are_microseconds_only_where_their_numbers_can_be(
    low: float, high: float, off: float | None, taken: bool, tmp_path: Path
) -> None:
    flight = _throttled(2.0)
    outputs = low + (high - low) * flight.numbered("cmd_rotor_")
    if off is not None:
        outputs[:20] = off
        led_up = np.linspace(0.0, 1.0, 20)[:, None]
        start = max(low, off)
        outputs[20:40] = start + led_up * (outputs[20:40] - start)
    data = []
    for t, row in zip(flight.t, outputs, strict=True):
        data.append((100, struct.pack("<QI16f", 5_000_000 + round(t * 1e6), 4, *row, *[0.0] * 12)))
    path = tmp_path / "outputs.ulg"
    text = _ulog(flight, [OUTPUTS], [("actuator_outputs", 0)], data)
    path.write_bytes(text.replace(b"actuator_motors", b"actuator_xotors"))
    found = import_log(path)
    assert ("rotor_command" in found.meta["channels"]) == taken
    settings = {}
    if not taken:
        (note,) = [n for n in found.meta["notes"] if n.startswith("rotor_command left out")]
        settings = parse_settings(note.split(" --set ")[1:])
    wanted = (outputs - low) / (2000.0 - low if taken else 1999.0)
    np.testing.assert_allclose(import_log(path, settings=settings).numbered("cmd_rotor_"), wanted, atol=1e-4)


def _flagged(flight: Flight, landed: list[tuple[float, int]], armed: list[tuple[float, int]]) -> bytes:
    formats = [
        "vehicle_land_detected:uint64_t timestamp;uint8_t landed;uint8_t[7] _padding0;",
        "actuator_armed:uint64_t timestamp;uint8_t armed;uint8_t[7] _padding0;",
    ]
    data = [(100, struct.pack("<QB", 5_000_000 + round(t * 1e6), v)) for t, v in landed]
    data += [(101, struct.pack("<QB", 5_000_000 + round(t * 1e6), v)) for t, v in armed]
    return _ulog(flight, formats, [("vehicle_land_detected", 0), ("actuator_armed", 0)], data)


def test_landed_or_disarmed_is_not_in_the_air(tmp_path: Path) -> None:
    flight = _throttled()
    path = tmp_path / "flags.ulg"
    path.write_bytes(_flagged(flight, [(0.0, 1), (1.0, 0), (3.5, 1)], [(0.0, 0), (0.5, 1), (3.0, 0)]))
    found = import_log(path)
    t = flight.t
    np.testing.assert_array_equal(found.table["airborne"], (t >= 1.0) & (t < 3.0))
    assert found.meta["channels"]["airborne"]["flags"] == ["vehicle_land_detected", "actuator_armed"]


def test_a_vehicle_that_is_disarmed_throughout_never_flies(tmp_path: Path) -> None:
    from infotraj.checking import examine, load

    path = tmp_path / "disarmed.ulg"
    path.write_bytes(_flagged(_throttled(), [], [(0.0, 0), (2.0, 0)]))
    assert (import_log(path).table["airborne"] == 0).all()
    assert "no_flight" in {f.code for f in examine(load(path)).findings}


def test_being_armed_alone_says_nothing_about_flight(tmp_path: Path) -> None:
    path = tmp_path / "armed.ulg"
    path.write_bytes(_flagged(_throttled(), [], [(0.0, 0), (0.5, 1)]))
    found = import_log(path)
    assert not found.has("airborne")
    assert any(note.startswith("airborne left out") for note in found.meta["notes"])


def test_events_of_ardupilot_say_when_it_flew(tmp_path: Path) -> None:
    events = (
        (0.1, 136, 10),
        (0.1, 137, 1),
        (0.5, 136, 15),
        (1.0, 136, 28),
        (1.5, 136, 62),
        (3.0, 136, 18),
        (3.2, 137, 0),
    )
    path = tmp_path / "copter.bin"
    path.write_bytes(dataflash_bytes(_throttled(), events=events))
    found = import_log(path)
    t = _throttled().t
    said = found.table["airborne"].to_numpy()
    assert np.isnan(said[t < 0.1]).all()
    np.testing.assert_array_equal(said[t >= 0.1], ((t >= 1.0) & (t < 3.0))[t >= 0.1])


def test_flags_together() -> None:
    column = lambda *v: np.array(v, dtype=float)[:, None]  # noqa: E731
    nan = np.nan
    np.testing.assert_array_equal(as_flags(column(7, 1, 9, 0), {0: 1, 1: 0}), column(nan, 0, 0, 1))
    np.testing.assert_array_equal(as_flags(column(0, 1), {0: 0, 1: None}), column(0, nan))
    together = in_the_air([column(1, 1, 0, nan), column(nan, 0, nan, nan)], [True, False])
    np.testing.assert_array_equal(together, column(1, 0, 0, nan))
    assert np.isnan(in_the_air([column(0, 0, nan)], [True])).all()
    np.testing.assert_array_equal(in_the_air([column(nan, 0, 0)], [True]), column(nan, 0, 0))
    # Events that arm and disarm alone say "on the ground" all along: what knows about flying counts.
    np.testing.assert_array_equal(
        in_the_air([column(nan, 0, 0, 0), column(0, 1, 1, 0)], [True, True]), column(0, 1, 1, 0)
    )
    # Never armed it does not fly, whatever another flag says.
    np.testing.assert_array_equal(
        in_the_air([column(0, 0, 0, 0), column(0, 1, 1, 0)], [False, True]), column(0, 0, 0, 0)
    )


def test_the_mapping_of_a_normalised_wrench_that_the_docs_show_is_read(tmp_path: Path) -> None:
    """Thrust and torque setpoints become N and N m by the scales of whoever knows them."""
    text = (Path(__file__).parents[2] / "docs/logging.md").read_text()
    block = text[text.rindex("\n", 0, text.index("name: px4_wrench")) + 1 : text.index("Over ROS 2, MCAP bags")]
    (tmp_path / "wrench.yaml").write_text(textwrap.dedent(block))
    flight = _throttled(2.0)
    formats = [
        f"vehicle_{n}_setpoint:uint64_t timestamp;uint64_t timestamp_sample;float[3] xyz;" for n in ("thrust", "torque")
    ]
    times = [5_000_000 + round(t * 1e6) for t in flight.t]
    data = [(100, struct.pack("<QQ3f", us, us, 0.0, 0.0, -0.5)) for us in times]
    data += [(101, struct.pack("<QQ3f", us, us, 0.1, 0.2, 0.5)) for us in times]
    topics = [("vehicle_thrust_setpoint", 0), ("vehicle_torque_setpoint", 0)]
    (tmp_path / "wrench.ulg").write_bytes(_ulog(flight, formats, topics, data))
    found = import_log(tmp_path / "wrench.ulg", tmp_path / "wrench.yaml")
    np.testing.assert_allclose(found.get("cmd_fx", "cmd_fy", "cmd_fz")[5], [0.0, 0.0, 24.0], atol=1e-6)
    # forward-right-down to forward-left-up
    np.testing.assert_allclose(found.get("cmd_tx", "cmd_ty", "cmd_tz")[5], [0.21, -0.42, -0.2], atol=1e-6)
    assert not import_log(tmp_path / "wrench.ulg").has("cmd_fx")


def test_states_are_for_airborne_alone() -> None:
    content = {"name": "m", "reads": "table", "time": {"fields": "t"}}
    for channel, said in (
        ({"battery": {"fields": "v", "states": {0: 1}}}, "`states` is for airborne only"),
        ({"airborne": {"fields": "v", "states": {0: 1}, "scale": 2.0}}, "have no place beside it"),
    ):
        with pytest.raises(UsageError, match=said):
            parse_mapping({**content, "streams": [{"name": "s", "channels": channel}]})
