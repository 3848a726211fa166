"""Message types of other communities, found by type in bags; px4_msgs without definitions in the bag."""

from __future__ import annotations

import sqlite3
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import writers_ulog
from flights_made import made_flight
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import infotraj
from infotraj import rotations
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.importing import import_log, parse_mapping, read_streams, shipped
from infotraj.importing.leftover import unused, wanting


def _store(**texts: str) -> Any:
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in texts.items():
        store.register(get_types_from_msg(text, name.replace("__", "/msg/")))
    return store


def _write(
    path: Path, store: Any, sent: list[tuple[str, str, int, Any]], plugin: StoragePlugin = StoragePlugin.MCAP
) -> Path:
    with Writer(path, version=8, storage_plugin=plugin) as writer:
        connections: dict[str, Any] = {}
        for topic, kind, ns, message in sent:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], ns, store.serialize_cdr(message, kind))
    return path


def _header(store: Any, ns: int) -> Any:
    stamp = store.types["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
    return store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="world")


def test_motor_speeds_are_measured_or_commanded_by_the_topics_name(tmp_path: Path) -> None:
    store = _store(mav_msgs__MotorSpeed="std_msgs/Header header\nfloat32[] motor_speed")
    kind = "mav_msgs/msg/MotorSpeed"
    sent = []
    for k in range(100):
        ns = 10**9 + k * 10**7
        for topic, speed in (("/hummingbird/motor_speed", 500.0 + k), ("/hummingbird/command/motor_speed", 600.0 + k)):
            message = store.types[kind](header=_header(store, ns), motor_speed=np.full(4, speed, dtype=np.float32))
            sent.append((topic, kind, ns, message))
    found = import_log(_write(tmp_path / "bag", store, sent))
    assert found.meta["mapping"] == "ros"
    np.testing.assert_allclose(found.numbered("rotor_")[:, 3], 500.0 + np.arange(100))
    np.testing.assert_allclose(found.numbered("cmd_rotor_")[:, 0], 600.0 + np.arange(100))


@pytest.mark.parametrize("package", ["mav_msgs", "actuator_msgs"])
def test_a_topic_of_actuators_that_says_command_is_one_whatever_else_it_says(tmp_path: Path, package: str) -> None:
    text = (Path(infotraj.__file__).parent / f"importing/definitions/{package}/msg/Actuators.msg").read_text()
    kind = f"{package}/msg/Actuators"
    store, sent = _store(**{f"{package}__Actuators": text}), []
    for k in range(100):
        ns = 10**9 + k * 10**7
        for topic, speed in (("/motor_speed", 500.0 + k), ("/motor_speed_cmd", 600.0 + k)):
            arrays = (np.zeros(0), np.full(4, speed), np.zeros(0))  # angles, speeds, normalized
            sent.append((topic, kind, ns, store.types[kind](_header(store, ns), *arrays)))
    found = import_log(_write(tmp_path / "bag", store, sent))
    np.testing.assert_allclose(found.numbered("rotor_")[:, 3], 500.0 + np.arange(100))
    np.testing.assert_allclose(found.numbered("cmd_rotor_")[:, 0], 600.0 + np.arange(100))


def test_extended_state_says_when_it_is_in_the_air(tmp_path: Path) -> None:
    store = _store(
        mavros_msgs__ExtendedState="std_msgs/Header header\nuint8 vtol_state\nuint8 landed_state",
        mavros_msgs__State="std_msgs/Header header\nbool connected\nbool armed\nbool guided\nbool manual_input\n"
        "string mode\nuint8 system_status",
    )
    types, sent = store.types, []
    point, turn = types["geometry_msgs/msg/Point"], types["geometry_msgs/msg/Quaternion"]
    for k in range(200):
        ns = 10**9 + k * 10**7
        pose = types["geometry_msgs/msg/Pose"](point(x=0.01 * k, y=0.0, z=1.0), turn(x=0.0, y=0.0, z=0.0, w=1.0))
        kind = "geometry_msgs/msg/PoseStamped"
        sent.append(("/mavros/local_position/pose", kind, ns, types[kind](header=_header(store, ns), pose=pose)))
        if k % 50 == 0:
            kind = "mavros_msgs/msg/ExtendedState"
            state = types[kind](header=_header(store, ns), vtol_state=0, landed_state=[1, 3, 2, 1][k // 50])
            sent.append(("/mavros/extended_state", kind, ns, state))
            kind = "mavros_msgs/msg/State"
            state = types[kind](_header(store, ns), True, k >= 50, False, False, "OFFBOARD", 4)
            sent.append(("/mavros/state", kind, ns, state))
    found = import_log(_write(tmp_path / "bag", store, sent))
    np.testing.assert_array_equal(found.table["airborne"], (np.arange(200) >= 50) & (np.arange(200) < 150))


@pytest.mark.parametrize("release", ["1.14", "another"])
def test_px4_bags_without_definitions_are_read_where_the_shipped_ones_fit(tmp_path: Path, release: str) -> None:
    folder = Path(infotraj.__file__).parent / "importing/definitions/px4_msgs/msg"
    texts = {f"px4_msgs__{p.stem}": p.read_text() for p in sorted(folder.glob("*.msg"))}
    if release == "another":
        texts["px4_msgs__VehicleAngularVelocity"] = "uint64 timestamp\nuint64 timestamp_sample\nfloat32[3] xyz\n"
    store = _store(**texts)
    flight = made_flight(2.0)
    sent = []
    for t, q, rate in zip(flight.t, flight.get("qw", "qx", "qy", "qz"), flight.get("wx", "wy", "wz"), strict=True):
        us, half = 10**6 + round(t * 1e6), np.sqrt(0.5)
        ned = rotations.multiply(rotations.multiply(np.array([0, half, half, 0.0]), q), np.array([0, 1.0, 0, 0]))
        kind = "px4_msgs/msg/VehicleAttitude"
        message = store.types[kind](us, us, ned.astype(np.float32), np.zeros(4, dtype=np.float32), 0)
        sent.append(("/fmu/out/vehicle_attitude", kind, us * 1000, message))
        kind = "px4_msgs/msg/VehicleAngularVelocity"
        turn = (rate * [1, -1, -1]).astype(np.float32)
        rest = [np.zeros(3, dtype=np.float32)] if release == "1.14" else []
        sent.append(("/fmu/out/vehicle_angular_velocity", kind, us * 1000, store.types[kind](us, us, turn, *rest)))
    bag = _write(tmp_path / "bag", store, sent, StoragePlugin.SQLITE3)
    # As ROS 2 Humble and older write it: no definitions.
    with sqlite3.connect(bag / "bag.db3") as database:
        database.execute("DELETE FROM message_definitions")
    database.close()
    found = import_log(bag)
    apart = rotations.angle_between(found.get("qw", "qx", "qy", "qz"), flight.get("qw", "qx", "qy", "qz"))
    assert apart.max() < 1e-6
    if release == "1.14":
        np.testing.assert_allclose(found.get("wx", "wy", "wz"), flight.get("wx", "wy", "wz"), atol=1e-6)
        assert "wx" not in found.meta["derived"]
    else:
        assert "wx" in found.meta["derived"]
        assert any("VehicleAngularVelocity: no definition in the bag that fits" in n for n in found.meta["notes"])


def test_slow_commands_in_a_ulog_are_said_with_what_to_log(tmp_path: Path) -> None:
    flight = made_flight(4.0)
    names = [c for c in flight.table if c.startswith("cmd_rotor_")]
    table = flight.table.assign(**{c: flight.table[c] / 1000.0 for c in names})
    path = tmp_path / "slow.ulg"
    writers_ulog.write_ulog(Flight(table.iloc[::10].reset_index(drop=True), {}), path)
    assert any("every 100 ms" in note and "SDLOG_PROFILE" in note for note in import_log(path).meta["notes"])
    writers_ulog.write_ulog(Flight(table, {}), path)
    assert not any("SDLOG_PROFILE" in note for note in import_log(path).meta["notes"])


def test_dropouts_of_a_ulog_are_added_up_in_seconds(tmp_path):
    """A dropout of PX4's logger tells its length in milliseconds."""
    content = writers_ulog.ulog_bytes(made_flight(seconds=3.0))
    lost = b"".join(struct.pack("<HBH", 2, ord("O"), ms) for ms in (120, 380))
    (tmp_path / "log.ulg").write_bytes(content + lost)
    notes = import_log(tmp_path / "log.ulg").meta["notes"]
    assert "2 logging dropouts, 0.50 s in all" in notes


def test_topics_of_a_ulog_that_no_stream_asks_for_are_named(tmp_path):
    content = writers_ulog.ulog_bytes(made_flight(seconds=3.0))
    other = content.replace(b"battery_status", b"battery_xtatus")
    (tmp_path / "log.ulg").write_bytes(other)
    read = read_streams(tmp_path / "log.ulg")
    assert unused(read)["battery_xtatus"] == "no stream of mapping px4_ulog asks for it"
    for name in (b"vehicle_attitude", b"vehicle_local_position", b"sensor_combined", b"actuator_motors"):
        other = other.replace(name, b"x" + name[1:])
    (tmp_path / "log.ulg").write_bytes(other)
    with pytest.raises(InputError, match="it has battery_xtatus, xctuator_motors, xehicle_attitude"):
        import_log(tmp_path / "log.ulg")


def test_a_condition_that_a_topic_does_not_meet_is_said(tmp_path):
    stream = {
        "name": "pack",
        "topic": "battery_status",
        "when": {"id": 7},
        "channels": {"battery": {"fields": "voltage_v"}},
    }
    px4 = shipped()["px4_ulog"].model_dump(mode="json", exclude_defaults=True)
    streams = [s for s in px4["streams"] if s["name"] != "battery"]
    path = writers_ulog.write_ulog(made_flight(seconds=3.0), tmp_path / "log.ulg", batteries=1)
    read = read_streams(path, parse_mapping({**px4, "streams": [*streams, stream]}))
    said = "id is 4, and stream pack is for id 7"
    assert unused(read)["battery_status"] == said
    assert f"battery_status voltage_v (there, but {said})" in wanting(read, "battery")
