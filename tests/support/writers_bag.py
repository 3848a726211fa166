"""Flight tables written as ROS 1 and ROS 2 bags (nav_msgs/Odometry, sensor_msgs/Imu, mav_msgs/Actuators, BatteryState).

For tests only. Bodies are FLU and worlds ENU, as REP 103 wants; the twist of an Odometry is in the body frame.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from infotraj import rotations
from infotraj.flight import Flight

ACTUATORS = "mav_msgs/msg/Actuators"
EPOCH_NS = 1_700_000_000_000_000_000


def typestore(ros: Literal[1, 2]) -> Any:
    """The common messages, and mav_msgs/Actuators."""
    store = get_typestore(Stores.ROS1_NOETIC if ros == 1 else Stores.ROS2_HUMBLE)
    text = (files("infotraj.importing") / "definitions/mav_msgs/msg/Actuators.msg").read_text()
    store.register(get_types_from_msg(text, ACTUATORS))
    return store


def messages(
    flight: Flight, store: Any, ros: Literal[1, 2], zero_ns: int, stamped: Callable[[float], float] = float
) -> Iterator[tuple[str, str, int, Any]]:
    """(topic, type, ns, message) row by row; a message is left out where its channel has no sample.

    ns is t; the header's stamp is `stamped(t)`.
    """
    types = store.types
    table = flight.table
    q = flight.get("qw", "qx", "qy", "qz")
    v_body = rotations.to_body(q, flight.get("vx", "vy", "vz"))
    position, rate, force = flight.get("px", "py", "pz"), flight.get("wx", "wy", "wz"), flight.get("ax", "ay", "az")
    rotors, tilts = (np.ascontiguousarray(flight.numbered(p)) for p in ("cmd_rotor_", "cmd_tilt_"))
    battery = table["battery"].to_numpy() if "battery" in table else np.full(len(table), np.nan)

    def vector(kind: str, xyz: Any) -> Any:
        return types[f"geometry_msgs/msg/{kind}"](x=float(xyz[0]), y=float(xyz[1]), z=float(xyz[2]))

    for k, t in enumerate(flight.t):
        ns = zero_ns + round(t * 1e9)
        header_ns = zero_ns + round(stamped(t) * 1e9)
        stamp = types["builtin_interfaces/msg/Time"](sec=header_ns // 10**9, nanosec=header_ns % 10**9)
        sequence = {"seq": k} if ros == 1 else {}
        header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="world", **sequence)
        orientation = types["geometry_msgs/msg/Quaternion"](w=q[k, 0], x=q[k, 1], y=q[k, 2], z=q[k, 3])
        if np.isfinite(position[k]).all():
            pose = types["geometry_msgs/msg/Pose"](position=vector("Point", position[k]), orientation=orientation)
            twist = types["geometry_msgs/msg/Twist"](
                linear=vector("Vector3", v_body[k]), angular=vector("Vector3", rate[k])
            )
            zeros = np.zeros(36)
            yield (
                "/hummingbird/odometry",
                "nav_msgs/msg/Odometry",
                ns,
                types["nav_msgs/msg/Odometry"](
                    header=header,
                    child_frame_id="base_link",
                    pose=types["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=zeros),
                    twist=types["geometry_msgs/msg/TwistWithCovariance"](twist=twist, covariance=zeros),
                ),
            )
        if np.isfinite(force[k]).all():
            nine = np.zeros(9)
            yield (
                "/hummingbird/imu",
                "sensor_msgs/msg/Imu",
                ns,
                types["sensor_msgs/msg/Imu"](
                    header=header,
                    orientation=orientation,
                    orientation_covariance=nine,
                    angular_velocity=vector("Vector3", rate[k]),
                    angular_velocity_covariance=nine,
                    linear_acceleration=vector("Vector3", force[k]),
                    linear_acceleration_covariance=nine,
                ),
            )
        if np.isfinite(rotors[k]).all():
            yield (
                "/hummingbird/command/motor_speed",
                ACTUATORS,
                ns,
                types[ACTUATORS](header=header, angles=tilts[k], angular_velocities=rotors[k], normalized=np.zeros(0)),
            )
        if np.isfinite(battery[k]):
            yield "/hummingbird/battery", "sensor_msgs/msg/BatteryState", ns, _battery(types, header, battery[k], ros)


def _battery(types: Any, header: Any, volts: float, ros: int) -> Any:
    extra = {} if ros == 1 else {"temperature": 20.0, "cell_temperature": np.zeros(0, np.float32)}
    kind = types["sensor_msgs/msg/BatteryState"]
    if ros == 1 and "temperature" in kind.__dataclass_fields__:
        extra = {"temperature": 20.0, "cell_temperature": np.zeros(0, np.float32)}
    return kind(
        header=header,
        voltage=float(volts),
        current=0.0,
        charge=0.0,
        capacity=0.0,
        design_capacity=0.0,
        percentage=0.5,
        power_supply_status=0,
        power_supply_health=0,
        power_supply_technology=0,
        present=True,
        cell_voltage=np.zeros(0, np.float32),
        location="",
        serial_number="",
        **extra,
    )


def write_bag1(flight: Flight, path: Path, zero_ns: int = EPOCH_NS, stamped: Callable[[float], float] = float) -> Path:
    """A ROS 1 bag at `path` (.bag)."""
    store = typestore(1)
    with Writer1(path) as writer:
        connections: dict[str, Any] = {}
        for topic, kind, ns, message in messages(flight, store, 1, zero_ns, stamped):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], ns + 2_000_000, store.serialize_ros1(message, kind))
    return path


def write_bag2(
    flight: Flight, path: Path, storage: Literal["mcap", "sqlite3"] = "mcap", zero_ns: int = EPOCH_NS
) -> Path:
    """A ROS 2 bag, a folder at `path`."""
    store = typestore(2)
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    with Writer2(path, version=9, storage_plugin=plugin) as writer:
        connections: dict[str, Any] = {}
        for topic, kind, ns, message in messages(flight, store, 2, zero_ns):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], ns + 2_000_000, store.serialize_cdr(message, kind))
    return path
