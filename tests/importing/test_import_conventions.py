"""Units, frames, quaternion order, velocity axes, clocks and choices: each against what it must give by definition."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from flights_made import made_flight
from hypothesis import given, settings
from hypothesis import strategies as st
from writers_bag import ACTUATORS, Writer1, Writer2, messages, typestore, write_bag1

from infotraj import rotations
from infotraj.flight import Flight
from infotraj.importing import import_log, parse_mapping, read_streams, recognise, shipped
from infotraj.importing.frames import axes_matrix, rotate_attitudes, rotate_vectors
from infotraj.importing.resample import gap_limit, put
from infotraj.importing.units import UNITS

GOOD = made_flight(3.0)


def table_mapping(channels: dict[str, Any], **stream: Any) -> Any:
    return parse_mapping(
        {
            "name": "m",
            "reads": ["table"],
            "time": {"fields": "t"},
            "streams": [{"name": "s", "channels": channels, **stream}],
        }
    )


def imported(tmp_path: Path, columns: dict[str, Any], channels: dict[str, Any], **stream: Any) -> Flight:
    pd.DataFrame(columns).to_csv(tmp_path / "log.csv", index=False, float_format="%.17g")
    return import_log(tmp_path / "log.csv", table_mapping(channels, **stream))


@pytest.mark.parametrize(
    ("channel", "column", "unit", "logged", "si"),
    [
        ("battery", "battery", "mV", 15_900.0, 15.9),
        ("rotor_command", "cmd_rotor_0", "rpm", 6000.0, 628.3185307179587),
        ("rotor_command", "cmd_rotor_0", "pwm16", 65535.0, 1.0),
        ("rotor_command", "cmd_rotor_0", "pwm_us", 1500.0, 0.5),
        ("rotor_command", "cmd_rotor_0", "dshot", 2047.0, 1.0),
        ("rotor", "rotor_0", "rev/s", 10.0, 62.83185307179586),
        ("tilt", "tilt_0", "deg", 180.0, np.pi),
    ],
)
def test_units(channel: str, column: str, unit: str, logged: float, si: float, tmp_path: Path) -> None:
    columns = {"t": [0.0, 0.1, 0.2], "x": [logged] * 3, "qw": [1.0] * 3, "qx": [0.0] * 3}
    attitude = {"fields": ["qw", "qx", "qx", "qx"]}
    found = imported(tmp_path, columns, {channel: {"fields": ["x"], "unit": unit}, "attitude": attitude})
    np.testing.assert_allclose(found.table[column], si, rtol=1e-15)


def test_every_unit_is_its_si_unit_at_one() -> None:
    for dimension, units in UNITS.items():
        factor, offset = next(iter(units.values()))
        assert (factor, offset) == (1.0, 0.0), dimension


def test_ned_and_frd_by_their_definition() -> None:
    # A vehicle that points north, level, in NED/FRD points along +y in ENU: yaw 90 degrees.
    level = np.array([[1.0, 0.0, 0.0, 0.0]])
    q = rotate_attitudes(axes_matrix(("y", "x", "-z")), axes_matrix(("x", "-y", "-z")), level)
    np.testing.assert_allclose(rotations.to_euler(q)[0], [0.0, 0.0, np.pi / 2], atol=1e-15)
    np.testing.assert_array_equal(
        rotate_vectors(axes_matrix(("y", "x", "-z")), np.array([[1.0, 2.0, 3.0]])), [[2.0, 1.0, -3.0]]
    )


@given(st.tuples(*[st.floats(-3, 3)] * 6), st.permutations(["x", "y", "z"]), st.tuples(*[st.booleans()] * 3))
@settings(max_examples=60, deadline=None)
def test_attitudes_and_vectors_turn_alike(numbers: tuple[float, ...], order: list[str], signs: Any) -> None:
    """R' (B v) = W (R v) for every right-handed choice of world axes W, with body axes FRD."""
    axes = [f"-{a}" if s else a for a, s in zip(order, signs, strict=True)]
    try:
        world = axes_matrix(axes)
    except ValueError:
        return
    body = axes_matrix(("x", "-y", "-z"))
    q, v = rotations.exp(np.array([numbers[:3]])), np.array([numbers[3:]])
    turned = rotations.to_world(rotate_attitudes(world, body, q), rotate_vectors(body, v))
    np.testing.assert_allclose(turned, rotate_vectors(world, rotations.to_world(q, v)), atol=1e-12)


def test_body_velocity_and_world_rate_are_turned(tmp_path: Path) -> None:
    q = GOOD.get("qw", "qx", "qy", "qz")
    body_v = rotations.to_body(q, GOOD.get("vx", "vy", "vz"))
    world_w = rotations.to_world(q, GOOD.get("wx", "wy", "wz"))
    columns = {"t": GOOD.t, **{f"q{k}": q[:, k] for k in range(4)}}
    columns |= {f"v{k}": body_v[:, k] for k in range(3)} | {f"w{k}": world_w[:, k] for k in range(3)}
    found = imported(
        tmp_path,
        columns,
        {
            "attitude": {"fields": ["q1", "q2", "q3", "q0"], "order": "xyzw"},
            "velocity": {"fields": ["v0", "v1", "v2"], "expressed_in": "body"},
            "rate": {"fields": ["w0", "w1", "w2"], "expressed_in": "world"},
        },
    )
    for names in (("vx", "vy", "vz"), ("wx", "wy", "wz"), ("qw", "qx", "qy", "qz")):
        np.testing.assert_allclose(found.get(*names), GOOD.get(*names), atol=1e-14)


def test_inverted_quaternion_and_removed_gravity(tmp_path: Path) -> None:
    q = GOOD.get("qw", "qx", "qy", "qz")
    linear = GOOD.get("ax", "ay", "az") - rotations.to_body(q, np.broadcast_to([0, 0, 9.80665], (len(q), 3)))
    inverse = rotations.conjugate(q)
    columns = {"t": GOOD.t, **{f"q{k}": inverse[:, k] for k in range(4)}, **{f"a{k}": linear[:, k] for k in range(3)}}
    found = imported(
        tmp_path,
        columns,
        {
            "attitude": {"fields": ["q0", "q1", "q2", "q3"], "rotates": "world_to_body"},
            "specific_force": {"fields": ["a0", "a1", "a2"], "gravity_removed": True},
        },
    )
    np.testing.assert_allclose(found.get("qw", "qx", "qy", "qz"), q, atol=1e-15)
    np.testing.assert_allclose(found.get("ax", "ay", "az"), GOOD.get("ax", "ay", "az"), atol=1e-13)


def test_body_velocity_without_attitude_is_left_out_and_said(tmp_path: Path) -> None:
    columns = {"t": GOOD.t, "v": GOOD.table["vx"], "p": GOOD.table["px"]}
    channels = {
        "velocity": {"fields": ["v", "v", "v"], "expressed_in": "body"},
        "rate": {"fields": ["p", "p", "p"]},
    }
    found = imported(tmp_path, columns, channels)
    assert "vx" not in found.table
    assert any("velocity left out: it is in body axes" in note for note in found.meta["notes"])


def test_derived_rate_is_of_second_order() -> None:
    errors = []
    for rate in (50.0, 100.0, 200.0):
        from infotraj.importing import derive

        flight = made_flight(3.0, rate)
        found = derive.rate(flight.t, flight.get("qw", "qx", "qy", "qz"), 1.0)
        errors.append(np.abs(found - flight.get("wx", "wy", "wz"))[1:-1].max())
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (orders > 1.9).all()


def test_nothing_is_derived_across_a_gap() -> None:
    from infotraj.importing import derive

    t = np.concatenate([np.arange(0, 1, 0.01), np.arange(2, 3, 0.01)])
    position = np.stack([np.where(t < 1.5, t, 100.0 - t), t, t], axis=-1)
    found = derive.velocity(t, position, gap_limit(t))
    np.testing.assert_allclose(found[:, 0], np.where(t < 1.5, 1.0, -1.0), atol=1e-9)


def test_what_is_derived_of_poses_in_every_fifth_row_stands_there(tmp_path: Path) -> None:
    """Sensors of several rates merged into one table leave cells empty, and a row is then no sample."""
    table = GOOD.table.drop(columns=["vx", "vy", "vz", "wx", "wy", "wz"])
    pose = ["px", "py", "pz", "qw", "qx", "qy", "qz"]
    empty = np.arange(len(table)) % 5 != 0
    empty[100:160] = True
    table.loc[empty, pose] = np.nan
    table.to_csv(tmp_path / "merged.csv", index=False)
    found = import_log(tmp_path / "merged.csv")
    inner = np.flatnonzero(~empty)[1:-1]
    inner = inner[(inner < 90) | (inner > 170)]
    for columns, error in ((("vx", "vy", "vz"), 0.05), (("wx", "wy", "wz"), 0.1)):
        assert set(columns) <= set(found.meta["derived"])
        np.testing.assert_array_equal(np.isfinite(found.get(*columns)).all(axis=1), ~empty)
        np.testing.assert_allclose(found.get(*columns)[inner], GOOD.get(*columns)[inner], atol=error)


@pytest.mark.parametrize("jitter", [0.03, 0.08])
@pytest.mark.parametrize("sampled", ["evenly", "when stamped"])
def test_stamps_that_jitter_do_not_make_the_motion_faster(jitter: float, sampled: str) -> None:
    from infotraj.importing import derive

    rng, step = np.random.default_rng(3), 0.005
    even = step * np.arange(8000)
    stamps = even + step * np.clip(jitter * rng.standard_normal(even.size), -0.45, 0.45)
    when = even if sampled == "evenly" else stamps
    position = np.stack([2.0 * when + np.sin(k * when) for k in (1.0, 2.0, 3.0)], axis=-1)
    position += 0.001 * rng.standard_normal(position.shape)
    position[450::900] += 0.1  # a marker swapped
    times, found = derive.on_even_grid(stamps, position, gap_limit(stamps), derive.slope_rule)
    for k in (1.0, 2.0, 3.0):
        true = 2.0 + k * np.cos(k * times)
        scale = np.linalg.lstsq(np.stack([true, np.ones_like(true)], axis=1), found[:, int(k) - 1], rcond=None)[0][0]
        assert scale == pytest.approx(1.0, abs=1e-3)


# --- one clock


def test_faster_sensor_is_interpolated_and_slower_command_held() -> None:
    rows = np.arange(0, 1, 0.01)
    fast = np.arange(0, 1, 0.0013)
    line = np.stack([3 * fast], axis=-1)
    inside = rows < fast[-1]
    np.testing.assert_allclose(put(rows, fast, line, "linear", gap_limit(fast))[inside, 0], 3 * rows[inside])
    slow = np.arange(0, 1, 0.04)
    steps = np.arange(slow.size, dtype=float)[:, None]
    held = put(rows, slow, steps, "mean", gap_limit(slow))[:, 0]
    np.testing.assert_array_equal(held, np.floor(rows / 0.04 + 1e-9))


def test_faster_command_is_averaged_over_the_row() -> None:
    rows = np.arange(0, 1, 0.02)
    fast = np.arange(0, 1, 0.005)
    u = np.random.default_rng(1).normal(size=(fast.size, 2))
    np.testing.assert_allclose(put(rows, fast, u, "mean", gap_limit(fast)), u.reshape(50, 4, 2).mean(axis=1))


@given(st.floats(0.02, 0.4), st.floats(0.1, 0.8))
@settings(max_examples=40, deadline=None)
def test_a_gap_stays_a_gap(width: float, start: float) -> None:
    """No row inside a hole of more than two periods gets a value by any rule, and all others keep theirs."""
    rows = np.round(np.arange(0, 1.2, 0.01), 6)
    t = rows[~((rows > start) & (rows < start + width + 0.01))]
    values = np.ones((t.size, 1))
    for rule in ("linear", "mean", "hold", "sample"):
        out = put(rows, t, values, rule, gap_limit(t))[:, 0]  # type: ignore[arg-type]
        assert np.isfinite(out[np.isin(rows, t)]).all()
        assert np.isnan(out[~np.isin(rows, t)]).all()


def test_gap_limit_bears_jitter_but_not_loss() -> None:
    rng = np.random.default_rng(3)
    even = np.arange(0, 10, 0.01)
    assert gap_limit(even) == pytest.approx(0.015)
    lossy = even[rng.random(even.size) > 0.2]
    assert gap_limit(lossy) == pytest.approx(0.015)
    jittery = np.sort(even + rng.uniform(-0.004, 0.004, even.size))
    assert np.diff(jittery).max() < gap_limit(jittery) <= 0.05


def _bag(path: Path, entries: list[tuple[str, str, int, int, Any]], store: Any) -> Path:
    with Writer1(path) as writer:
        connections: dict[str, Any] = {}
        for topic, kind, record, _, message in sorted(entries, key=lambda e: e[2]):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], record, store.serialize_ros1(message, kind))
    return path


def test_topics_without_stamps_follow_the_recording_clock(tmp_path: Path) -> None:
    """Motor speeds in a Float64MultiArray have no stamp; here the recorder's clock is 1000 s ahead, 3 ms late."""
    store = typestore(1)
    types = store.types
    late = 1_000_003_000_000
    entries = [(t, k, ns + late, ns, m) for t, k, ns, m in messages(GOOD, store, 1, 10**12) if "odometry" in t]
    layout = types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    for _, _, record, ns, _ in list(entries):
        value = np.array([(ns - 10**12) / 1e9, 2.0])
        array = types["std_msgs/msg/Float64MultiArray"](layout=layout, data=value)
        entries.append(("/motor_speed_cmd", "std_msgs/msg/Float64MultiArray", record, 0, array))
    found = import_log(_bag(tmp_path / "a.bag", entries, store))
    np.testing.assert_allclose(found.table["cmd_rotor_0"], GOOD.t, atol=1e-9)
    assert any("has no stamps" in note for note in found.meta["notes"])


def test_a_stream_on_another_clock_is_moved(tmp_path: Path) -> None:
    """Motion capture stamps since 1970, the vehicle stamps since boot: the recording times tie them together."""
    store = typestore(1)
    record = lambda ns: ns + 4_000_000  # noqa: E731
    entries = []
    for topic, kind, ns, message in messages(GOOD, store, 1, 1_700_000_000 * 10**9):
        if "imu" in topic:
            boot = ns - 1_699_999_950 * 10**9
            message.header.stamp.sec, message.header.stamp.nanosec = boot // 10**9, boot % 10**9
        entries.append((topic, kind, record(ns), ns, message))
        if "imu" in topic:
            import copy

            entries[-1] = (topic, kind, record(ns), ns, copy.deepcopy(message))
            message.header.stamp.sec, message.header.stamp.nanosec = ns // 10**9, ns % 10**9
    found = import_log(_bag(tmp_path / "a.bag", entries, store))
    np.testing.assert_allclose(found.get("ax", "az"), GOOD.get("ax", "az"), atol=1e-12)
    assert any("another clock" in note for note in found.meta["notes"])


# --- which topic


def test_ground_truth_wins_and_the_choice_is_said(tmp_path: Path) -> None:
    store = typestore(1)
    entries = []
    for topic, kind, ns, message in messages(GOOD, store, 1, 10**12):
        entries.append((topic, kind, ns, ns, message))
        if kind == "nav_msgs/msg/Odometry":
            entries += [(f"/a/{name}", kind, ns, ns, message) for name in ("vio/odometry", "ground_truth/odometry")]
    path = _bag(tmp_path / "a.bag", entries, store)
    found = import_log(path)
    assert found.meta["channels"]["position"]["topic"] == "/a/ground_truth/odometry"
    note = next(n for n in found.meta["notes"] if n.startswith("odometry:"))
    assert "/a/vio/odometry" in note
    assert "/hummingbird/odometry" in note
    chosen = recognise(path)
    assert chosen.mapping.name == "ros"
    assert chosen.channels == [
        "position", "attitude", "velocity", "rate", "specific_force", "rotor_command", "tilt_command", "battery",
    ]  # fmt: skip


def test_the_body_velocity_of_mavros_is_no_velocity_in_world_axes(tmp_path: Path) -> None:
    """MAVROS sends both; the stream in world axes took the one that comes first in the alphabet."""
    store, sent = typestore(1), "geometry_msgs/msg/TwistStamped"
    types, entries = store.types, []
    q = GOOD.get("qw", "qx", "qy", "qz")
    vector = lambda x: types["geometry_msgs/msg/Vector3"](*map(float, x))  # noqa: E731
    in_world = (GOOD.get("vx", "vy", "vz"), rotations.to_world(q, GOOD.get("wx", "wy", "wz")))
    in_body = (rotations.to_body(q, in_world[0]), GOOD.get("wx", "wy", "wz"))
    stamps = iter(range(len(q)))
    for _, kind, ns, message in messages(GOOD, store, 1, 10**12):
        if kind != "nav_msgs/msg/Odometry":
            continue
        k = next(stamps)
        pose = types["geometry_msgs/msg/PoseStamped"](header=message.header, pose=message.pose.pose)
        entries.append(("/mavros/local_position/pose", "geometry_msgs/msg/PoseStamped", ns, ns, pose))
        for name, frame, (v, w) in (("velocity_body", "base_link", in_body), ("velocity_local", "map", in_world)):
            header = types["std_msgs/msg/Header"](seq=k, stamp=message.header.stamp, frame_id=frame)
            twist = types[sent](header=header, twist=types["geometry_msgs/msg/Twist"](vector(v[k]), vector(w[k])))
            entries.append((f"/mavros/local_position/{name}", sent, ns, ns, twist))
    read = read_streams(_bag(tmp_path / "a.bag", entries, store), every=True)
    for stream, topic in (("twist", "velocity_local"), ("body_twist", "velocity_body")):
        found = read.streams[stream]
        assert found.topic.endswith(topic)
        np.testing.assert_allclose(found.channels["velocity"], in_world[0], atol=1e-9)
        np.testing.assert_allclose(found.channels["rate"], in_body[1], atol=1e-9)


def test_measured_and_commanded_motor_speeds_are_told_apart(tmp_path: Path) -> None:
    store = typestore(1)
    entries = []
    for topic, kind, ns, message in messages(GOOD, store, 1, 10**12):
        entries.append((topic, kind, ns, ns, message))
        if kind == ACTUATORS:
            slower = store.types[ACTUATORS](
                header=message.header,
                angles=np.zeros(0),
                angular_velocities=0.9 * message.angular_velocities,
                normalized=np.zeros(0),
            )
            entries.append(("/hummingbird/motor_speed", kind, ns, ns, slower))
    found = import_log(_bag(tmp_path / "a.bag", entries, store))
    np.testing.assert_array_equal(found.numbered("cmd_rotor_"), GOOD.numbered("cmd_rotor_"))
    np.testing.assert_array_equal(found.numbered("rotor_"), 0.9 * GOOD.numbered("cmd_rotor_"))
    assert found.numbered("tilt_").shape[1] == 0


def test_definitions_from_a_file(tmp_path: Path) -> None:
    """A sqlite bag without definitions (as before ROS 2 Iron) of a type that nobody knows."""
    import sqlite3

    from rosbags.rosbag2 import StoragePlugin
    from rosbags.typesys import get_types_from_msg

    store = typestore(2)
    text = "std_msgs/Header header\nfloat64[4] speeds_rpm\n"
    store.register(get_types_from_msg(text, "acme_msgs/msg/Esc"))
    with Writer2(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections: dict[str, Any] = {}
        for topic, kind, ns, message in messages(GOOD, store, 2, 10**12):
            if "odometry" not in topic:
                continue
            esc = store.types["acme_msgs/msg/Esc"](header=message.header, speeds_rpm=np.arange(4.0) * 60)
            for name, which, content in ((topic, kind, message), ("/esc", "acme_msgs/msg/Esc", esc)):
                if name not in connections:
                    connections[name] = writer.add_connection(name, which, typestore=store)
                writer.write(connections[name], ns, store.serialize_cdr(content, which))
    database = sqlite3.connect(tmp_path / "bag/bag.db3")
    database.execute("DELETE FROM message_definitions")
    database.commit()
    database.close()
    folder = tmp_path / "acme_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Esc.msg").write_text(text)
    content = shipped()["ros"].model_dump(mode="json", exclude_defaults=True)
    content["name"] = "acme"
    content["streams"].append(
        {
            "name": "esc_rpm",
            "topic": "/esc",
            "channels": {"rotor": {"fields": [f"speeds_rpm[{k}]" for k in range(4)], "unit": "rpm"}},
        }
    )
    without = import_log(tmp_path / "bag", parse_mapping(content))
    assert "rotor_0" not in without.table
    assert any("acme_msgs/msg/Esc: no definition" in note for note in without.meta["notes"])
    for definitions in (tmp_path / "acme_msgs", folder / "Esc.msg"):
        found = import_log(tmp_path / "bag", parse_mapping(content), definitions=(definitions,))
        np.testing.assert_allclose(found.table["rotor_3"], 6 * np.pi, rtol=1e-15)


def test_px4_over_ros_2(tmp_path: Path) -> None:
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    odometry = (
        "uint64 timestamp\nuint64 timestamp_sample\nuint8 pose_frame\nfloat32[3] position\nfloat32[4] q\n"
        "uint8 velocity_frame\nfloat32[3] velocity\nfloat32[3] angular_velocity\n"
    )
    store.register(get_types_from_msg(odometry, "px4_msgs/msg/VehicleOdometry"))
    store.register(get_types_from_msg("uint64 timestamp\nfloat32[12] control\n", "px4_msgs/msg/ActuatorMotors"))
    with Writer2(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        a = writer.add_connection("/fmu/out/vehicle_odometry", "px4_msgs/msg/VehicleOdometry", typestore=store)
        b = writer.add_connection("/fmu/in/actuator_motors", "px4_msgs/msg/ActuatorMotors", typestore=store)
        for k in range(100):
            us = 3_000_000 + 10_000 * k
            control = np.full(12, np.nan, np.float32)
            control[:4] = 0.5
            east = 0.01 * k  # flies east at 1 m/s, pointing north
            message = store.types["px4_msgs/msg/VehicleOdometry"](
                timestamp=us + 300, timestamp_sample=us, pose_frame=1, velocity_frame=1,
                position=np.array([0, east, -2], np.float32), q=np.array([1, 0, 0, 0], np.float32),
                velocity=np.array([0, 1, 0], np.float32), angular_velocity=np.array([0.1, 0.2, 0.3], np.float32),
            )  # fmt: skip
            motors = store.types["px4_msgs/msg/ActuatorMotors"](timestamp=us, control=control)
            writer.write(a, us * 1000, store.serialize_cdr(message, "px4_msgs/msg/VehicleOdometry"))
            writer.write(b, us * 1000, store.serialize_cdr(motors, "px4_msgs/msg/ActuatorMotors"))
    found = import_log(tmp_path / "bag")
    assert found.meta["mapping"] == "px4_ros2"
    np.testing.assert_allclose(found.t[[0, -1]], [3.0, 3.99])
    np.testing.assert_allclose(found.get("px", "py", "pz")[-1], [0.99, 0.0, 2.0], atol=1e-6)
    np.testing.assert_allclose(found.get("vx", "vy", "vz"), [[1.0, 0.0, 0.0]] * 100, atol=1e-7)
    np.testing.assert_allclose(found.get("wx", "wy", "wz"), [[0.1, -0.2, -0.3]] * 100, atol=1e-7)
    assert rotations.to_euler(found.get("qw", "qx", "qy", "qz"))[0, 2] == pytest.approx(np.pi / 2)
    assert found.numbered("cmd_rotor_").shape == (100, 4)


# --- real flights


def test_nanobench_conventions() -> None:
    from infotraj.datasets.location import find_dataset, how_to_get
    from infotraj.importing import derive

    folder = find_dataset("nanobench")
    if folder is None:
        pytest.skip(how_to_get("nanobench"))
    found = import_log(folder / "B3_figure8_fast_rep1.parquet")
    assert found.meta["mapping"] == "nanobench"
    expected = derive.rate(found.t, found.get("qw", "qx", "qy", "qz"), gap_limit(found.t))
    flying = found.table["pz"].to_numpy() > 0.3
    rate, q = found.get("wx", "wy", "wz"), found.get("qw", "qx", "qy", "qz")
    as_body, as_world = (np.sqrt(np.nanmean((w - expected)[flying] ** 2)) for w in (rate, rotations.to_body(q, rate)))
    assert as_body < 0.9 * as_world
    assert np.median(np.linalg.norm(found.get("ax", "ay", "az"), axis=1)) == pytest.approx(9.81, abs=0.3)
    every = read_streams(folder / "B3_figure8_fast_rep1.parquet", every=True)
    assert set(every.streams) == {"vicon", "onboard", "vicon_angles", "estimator"}
    angle = rotations.angle_between(
        every.streams["vicon_angles"].channels["attitude"], every.streams["vicon"].channels["attitude"]
    )
    assert np.nanmax(angle) < 1e-3
    believed = read_streams(folder / "B3_figure8_fast_rep1.parquet", "nanobench_readme", every=True)
    wrong = rotations.angle_between(
        believed.streams["vicon_angles"].channels["attitude"], believed.streams["vicon"].channels["attitude"]
    )
    assert np.nanmax(wrong) > 0.1


def test_from_and_to_cut_a_broken_clock_off(tmp_path: Path) -> None:
    path = write_bag1(GOOD, tmp_path / "a.bag", 0, lambda t: t - 1.0 if t >= 2.0 else t)
    found = import_log(path, start=0.5, stop=1.5)
    np.testing.assert_allclose(found.t, GOOD.t[50:150], atol=1e-9)
    np.testing.assert_array_equal(found.table["px"], GOOD.table["px"][50:150])


def test_rows_of_another_channel_or_rate(tmp_path: Path) -> None:
    path = write_bag1(GOOD, tmp_path / "a.bag")
    even = import_log(path, rows="50")
    np.testing.assert_allclose(np.diff(even.t), 0.02)
    np.testing.assert_allclose(even.table["px"], GOOD.table["px"][::2], atol=1e-12)
    sparse = import_log(path, rows="battery")
    assert len(sparse.table) == len(GOOD.table)


def test_a_stream_that_jitters_has_no_gap_within_six_of_its_deviations():
    """1.5 of 10 ms and six times 1.4826 x 1 ms make 23.9 ms; five steps are always a gap."""
    step = np.tile([0.009, 0.010, 0.011, 0.010 - 1e-3, 0.010 + 1e-3, 0.010, 0.010], 40)
    t = np.concatenate([[0.0], np.cumsum(step)])
    assert gap_limit(t) == pytest.approx(0.015 + 6.0 * 1.4826 * 0.001, rel=1e-6)
    assert gap_limit(np.array([0.0, 0.01, 0.02, 0.03])) == pytest.approx(0.015)
    wild = np.concatenate([[0.0], np.cumsum(np.tile([0.002, 0.010, 0.018], 40))])
    assert gap_limit(wild) == pytest.approx(0.050)
