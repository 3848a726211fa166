"""Logs that no writer in tests/ made: bytes set down from the formats' specifications, and other tools' files."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from flights_made import made_flight
from writers_ulog import ulog_bytes

from infotraj import rotations
from infotraj.flight import Flight
from infotraj.importing import import_log, parse_mapping

POSE_TEXT = """std_msgs/Header header
geometry_msgs/Pose pose
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
"""

RIGID = {
    "name": "rigid",
    "reads": ["rosbag"],
    "time": {"fields": "micros", "unit": "us"},
    "streams": [
        {
            "name": "rigid",
            "topic": "/rigid",
            "channels": {
                "position": {"fields": ["xyz[0]", "xyz[1]", "xyz[2]"]},
                "attitude": {"fields": ["xyzw[0]", "xyzw[1]", "xyzw[2]", "xyzw[3]"], "order": "xyzw"},
            },
        }
    ],
}


def _fields(**fields: bytes) -> bytes:
    out = b"".join(struct.pack("<I", len(k) + 1 + len(v)) + k.encode() + b"=" + v for k, v in fields.items())
    return struct.pack("<I", len(out)) + out


def _record(data: bytes, **fields: bytes) -> bytes:
    return _fields(**fields) + struct.pack("<I", len(data)) + data


def bag1_bytes(poses: list[tuple[int, list[float]]]) -> bytes:
    """A ROS 1 bag, version 2.0 (wiki.ros.org/Bags/Format/2.0), of (stamp in ns, x y z qx qy qz qw) as PoseStamped."""
    u32, u64 = (lambda v: struct.pack("<I", v)), (lambda v: struct.pack("<Q", v))
    time = lambda ns: struct.pack("<II", ns // 10**9, ns % 10**9)  # noqa: E731
    connection = _record(
        _fields(
            topic=b"/vrpn_client_node/drone/pose",
            type=b"geometry_msgs/PoseStamped",
            md5sum=b"d3812c3cbc69362b77dc0b19b345f8f5",
            message_definition=POSE_TEXT.encode(),
        )[4:],
        op=b"\x07",
        conn=u32(0),
        topic=b"/vrpn_client_node/drone/pose",
    )
    body, index = bytearray(connection), bytearray()
    for k, (ns, values) in enumerate(poses):
        index += time(ns + 5_000_000) + u32(len(body))
        message = u32(k) + time(ns) + u32(5) + b"world" + struct.pack("<7d", *values)
        body += _record(message, op=b"\x02", conn=u32(0), time=time(ns + 5_000_000))
    start = 13 + 4096
    chunk = _record(bytes(body), op=b"\x05", compression=b"none", size=u32(len(body)))
    indexed = _record(bytes(index), op=b"\x04", ver=u32(1), conn=u32(0), count=u32(len(poses)))
    info = _record(
        u32(0) + u32(len(poses)),
        op=b"\x06",
        ver=u32(1),
        chunk_pos=u64(start),
        start_time=time(poses[0][0] + 5_000_000),
        end_time=time(poses[-1][0] + 5_000_000),
        count=u32(1),
    )
    head = _fields(op=b"\x03", index_pos=u64(start + len(chunk) + len(indexed)), conn_count=u32(1), chunk_count=u32(1))
    padding = 4096 - len(head) - 4
    return b"#ROSBAG V2.0\n" + head + u32(padding) + b" " * padding + chunk + indexed + connection + info


def mcap_bytes(poses: list[tuple[int, list[float]]], schema: str, encoding: str = "ros2msg") -> bytes:
    """An MCAP file (mcap.dev/spec) without chunks and without a summary, messages as CDR."""
    text = lambda s: struct.pack("<I", len(s)) + s.encode()  # noqa: E731
    record = lambda op, data: bytes([op]) + struct.pack("<Q", len(data)) + data  # noqa: E731
    out = bytearray(b"\x89MCAP0\r\n" + record(1, text("ros2") + text("by hand")))
    out += record(3, struct.pack("<H", 1) + text("my_msgs/msg/Rigid") + text(encoding) + text(schema))
    out += record(4, struct.pack("<HH", 0, 1) + text("/rigid") + text("cdr") + struct.pack("<I", 0))
    for k, (ns, values) in enumerate(poses):
        cdr = b"\x00\x01\x00\x00" + struct.pack("<Q3f4f", ns // 1000, *values[:3], *values[3:])
        out += record(5, struct.pack("<HIQQ", 0, k, ns, ns) + cdr)
    out += record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0))
    return bytes(out + b"\x89MCAP0\r\n")


def crazyflie_v1_bytes(fast: list[tuple[int, list[float]]], slow: list[tuple[int, float]]) -> bytes:
    """A micro-SD log of version 1 (ms stamps) with two events, interleaved by time, with its check sum."""
    head = b"\xbc" + struct.pack("<HH", 1, 2)
    head += struct.pack("<H", 3) + b"imu\0" + struct.pack("<H", 3) + b"gyro.x(f)\0gyro.y(f)\0gyro.z(f)\0"
    head += struct.pack("<H", 9) + b"power\0" + struct.pack("<H", 2) + b"pm.vbat(f)\0pm.state(b)\0"
    rows = [(ms, struct.pack("<HI3f", 3, ms, *xyz)) for ms, xyz in fast]
    rows += [(ms, struct.pack("<HIfb", 9, ms, volts, -1)) for ms, volts in slow]
    data = head + b"".join(row for _, row in sorted(rows, key=lambda r: r[0]))
    return data + struct.pack("<I", zlib.crc32(data))


def _poses(flight: Flight, zero_ns: int) -> list[tuple[int, list[float]]]:
    values = flight.get("px", "py", "pz", "qx", "qy", "qz", "qw")
    return [(zero_ns + round(t * 1e9), list(map(float, row))) for t, row in zip(flight.t, values, strict=True)]


def test_ros1_bag_by_hand(tmp_path: Path) -> None:
    flight = made_flight(2.0)
    path = tmp_path / "hand.bag"
    path.write_bytes(bag1_bytes(_poses(flight, 1_600_000_000 * 10**9)))
    found = import_log(path)
    np.testing.assert_allclose(found.t, flight.t, atol=1e-9)
    np.testing.assert_array_equal(found.get("px", "qw"), flight.get("px", "qw"))
    assert found.meta["derived"] == ["vx", "vy", "vz", "wx", "wy", "wz"]
    # Central differences are of second order: step^2/6 times the third derivative, here at most 4 m/s^3.
    inside = slice(1, -1)
    np.testing.assert_allclose(
        found.get("vx", "vy", "vz")[inside], flight.get("vx", "vy", "vz")[inside], atol=4 * 0.01**2 / 6 * 1.01
    )
    np.testing.assert_allclose(found.get("wx", "wy", "wz")[inside], flight.get("wx", "wy", "wz")[inside], atol=1e-4)


def test_mcap_by_hand_with_a_type_of_its_own(tmp_path: Path) -> None:
    flight = made_flight(2.0)
    path = tmp_path / "hand.mcap"
    path.write_bytes(mcap_bytes(_poses(flight, 7_000_000_000), "uint64 micros\nfloat32[3] xyz\nfloat32[4] xyzw"))
    mapping = parse_mapping(RIGID)
    found = import_log(path, mapping)
    np.testing.assert_allclose(found.t, flight.t + 7.0, atol=1e-9)
    np.testing.assert_allclose(found.get("px", "py", "pz"), flight.get("px", "py", "pz"), atol=2e-7)
    assert rotations.angle_between(found.get("qw", "qx", "qy", "qz"), flight.get("qw", "qx", "qy", "qz")).max() < 5e-7


def test_crazyflie_version_1_with_two_events(tmp_path: Path) -> None:
    fast = [(1000 + 2 * k, [10.0 * k, -5.0, 0.5]) for k in range(200)]
    slow = [(1000 + 100 * k, 4.0 - 0.01 * k) for k in range(4)]
    path = tmp_path / "log07"
    path.write_bytes(crazyflie_v1_bytes(fast, slow))
    found = import_log(path)
    assert found.meta["mapping"] == "crazyflie"
    np.testing.assert_allclose(found.t, [ms / 1000 for ms, _ in fast], atol=1e-12)
    np.testing.assert_allclose(found.get("wx", "wy", "wz"), np.radians([v for _, v in fast]), rtol=1e-6)
    battery = found.table["battery"]
    assert battery.notna().sum() == 4
    np.testing.assert_allclose(battery.dropna().to_numpy(), [v for _, v in slow], rtol=1e-6)
    np.testing.assert_allclose(found.t[battery.notna()], [ms / 1000 for ms, _ in slow])


def test_ulog_that_pyulog_wrote(tmp_path: Path) -> None:
    import io

    from pyulog import ULog

    flight = made_flight(2.0)
    throttle = {c: flight.table[c] / 1000.0 for c in flight.table if c.startswith("cmd_rotor_")}
    ours = Flight(flight.table.assign(**throttle), {})
    other = ULog(io.BytesIO(ulog_bytes(ours)))
    other.write_ulog(str(tmp_path / "other.ulg"))
    found = import_log(tmp_path / "other.ulg")
    np.testing.assert_allclose(found.t, flight.t + 5.0, atol=1e-9)
    for name in ("px", "py", "pz", "vx", "vy", "vz", "wx", "wy", "wz", "ax", "ay", "az", "battery"):
        np.testing.assert_allclose(found.table[name], flight.table[name], rtol=0, atol=2e-6, err_msg=name)
    np.testing.assert_allclose(found.table["cmd_rotor_2"], ours.table["cmd_rotor_2"], atol=1e-7)


@pytest.mark.parametrize("name", ["log10", "log15", "log16"])
def test_real_crazyflie_logs(name: str) -> None:
    from infotraj.datasets.location import find_dataset, how_to_get

    folder = find_dataset("arpl_crazyflie")
    if folder is None:
        pytest.skip(how_to_get("arpl_crazyflie"))
    found = import_log(folder / name)
    expected = {"log10": (50496, 26.3337), "log15": (62774, 39.2449), "log16": (47182, 16.8958)}[name]
    assert (len(found.table), round(float(found.t[0]), 4)) == expected
    assert list(found.table.columns) == [
        "t", "wx", "wy", "wz", "ax", "ay", "az", "cmd_rotor_0", "cmd_rotor_1", "cmd_rotor_2", "cmd_rotor_3",
    ]  # fmt: skip
    assert found.meta["derived"] == []
    assert 0.0 <= found.numbered("cmd_rotor_").min() < 0.01
    assert 0.5 < found.numbered("cmd_rotor_").max() <= 1.0
    # At rest before take-off the accelerometer measures one g upwards.
    assert np.median(found.get("az")[:500]) == pytest.approx(9.81, abs=0.3)
