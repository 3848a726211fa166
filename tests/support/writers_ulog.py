"""Flight tables written as PX4 ULog files, byte by byte as PX4's developer guide describes them. For tests only."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np

from infotraj import rotations
from infotraj.flight import Flight

FORMATS = {
    "vehicle_attitude": "uint64_t timestamp;uint64_t timestamp_sample;float[4] q;uint8_t quat_reset_counter;"
    "uint8_t[7] _padding0",
    "vehicle_local_position": "uint64_t timestamp;uint64_t timestamp_sample;float x;float y;float z;float vx;float vy;"
    "float vz",
    "sensor_combined": "uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2",
    "actuator_motors": "uint64_t timestamp;uint64_t timestamp_sample;float[12] control",
    "battery_status": "uint64_t timestamp;float voltage_v;uint8_t id;uint8_t[3] _padding0",
}


def ulog_bytes(flight: Flight, boot_us: int = 5_000_000, batteries: int = 2) -> bytes:
    """The file's content. Rotor commands have to be throttles (0..1); world NED, body FRD, single precision."""
    out = bytearray(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", boot_us))
    out += _message("B", bytes(40))
    for name, fields in FORMATS.items():
        out += _message("F", f"{name}:{fields};".encode())
    out += _info("char[9]", "sys_name", b"PX4")
    names = [*FORMATS, *["battery_status"] * (batteries - 1)]
    for identity, name in enumerate(names):
        out += _message("A", struct.pack("<BH", names[:identity].count(name), identity) + name.encode())
    out += _data_section(flight, boot_us, names)
    return bytes(out)


def write_ulog(flight: Flight, path: Path, **options: Any) -> Path:
    """As ulog_bytes, into a file."""
    path.write_bytes(ulog_bytes(flight, **options))
    return path


def _data_section(flight: Flight, boot_us: int, names: list[str]) -> bytes:
    to_ned = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    to_frd = np.diag([1.0, -1.0, -1.0])
    half = np.sqrt(0.5)
    # q_NED_FRD = q(ENU to NED) q(FLU to ENU) q(FRD to FLU): half turns about (1, 1, 0)/sqrt 2 and about x.
    q = rotations.multiply(
        rotations.multiply(np.array([0.0, half, half, 0.0]), flight.get("qw", "qx", "qy", "qz")),
        np.array([0.0, 1.0, 0.0, 0.0]),
    )
    position = flight.get("px", "py", "pz") @ to_ned.T
    velocity = flight.get("vx", "vy", "vz") @ to_ned.T
    rate = flight.get("wx", "wy", "wz") @ to_frd.T
    force = flight.get("ax", "ay", "az") @ to_frd.T
    rotors = flight.numbered("cmd_rotor_")
    battery = flight.get("battery")[:, 0]
    out = bytearray()
    for k, t in enumerate(flight.t):
        us = boot_us + round(t * 1e6)
        control = np.full(12, np.nan)
        control[: rotors.shape[1]] = rotors[k]
        bodies = {
            "vehicle_attitude": struct.pack("<QQ4fB", us + 900, us, *q[k], 0),
            "vehicle_local_position": struct.pack("<QQ6f", us + 1100, us, *position[k], *velocity[k]),
            "sensor_combined": struct.pack("<Q6f", us, *rate[k], *force[k]),
            "actuator_motors": struct.pack("<QQ12f", us, us - 500, *control),
        }
        for identity, name in enumerate(names):
            if name == "battery_status":
                if not np.isfinite(battery[k]):
                    continue
                volts = battery[k] if identity == names.index(name) else 5.0
                body = struct.pack("<QfB", us, volts, identity)
            else:
                body = bodies[name]
            out += _message("D", struct.pack("<H", identity) + body)
    return bytes(out)


def _message(kind: str, body: bytes) -> bytes:
    return struct.pack("<HB", len(body), ord(kind)) + body


def _info(kind: str, key: str, value: bytes) -> bytes:
    name = f"{kind} {key}".encode()
    return _message("I", struct.pack("<B", len(name)) + name + value)
