"""Writes a flight as an ArduPilot DataFlash log, binary or as text, from the format's specification."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Any

import numpy as np

from infotraj.flight import Flight

_CODES = {"Q": "Q", "B": "B", "f": "f", "c": "h", "C": "H", "H": "H", "n": "4s", "N": "16s", "Z": "64s", "d": "d"}
_FORMATS = {
    128: ("FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
    129: ("PARM", "QNf", "TimeUS,Name,Value"),
    130: ("IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
    131: ("ATT", "QccccCC", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
    132: ("XKF1", "QBffffff", "TimeUS,C,VN,VE,VD,PN,PE,PD"),
    133: ("RCOU", "QHHHH", "TimeUS,C1,C2,C3,C4"),
    134: ("ESC", "QBf", "TimeUS,Instance,RPM"),
    135: ("BAT", "QBf", "TimeUS,Inst,Volt"),
    136: ("EV", "QB", "TimeUS,Id"),
    137: ("ARM", "QB", "TimeUS,ArmState"),
    138: ("FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds"),
}


def messages(
    flight: Flight,
    functions: tuple[int, ...] = (36, 33, 34, 35),
    events: tuple[tuple[float, int, int], ...] = (),
    second_imu_off: float | None = None,
    pulses: dict[str, float] | None = None,
    every_esc: bool = False,
) -> Iterator[tuple[int, list[Any]]]:
    """(kind, values) of every message; `functions` are the outputs', `events` (s, kind, value).

    every_esc: telemetry of all four outputs, whether a motor's or not.
    """
    for kind, (name, letters, columns) in _FORMATS.items():
        yield 128, [kind, length(letters), name, letters, columns]
    yield 138, [1, 130, "s#EEEooo", "F-000000"]
    for k, function in enumerate(functions):
        yield 129, [1, f"SERVO{k + 1}_FUNCTION", float(function)]
    for name, value in (pulses or {"MOT_PWM_MIN": 1100.0, "MOT_PWM_MAX": 1900.0}).items():
        yield 129, [1, name, value]
    ned = lambda v: [v[1], v[0], -v[2]]  # noqa: E731
    frd = lambda v: [v[0], -v[1], -v[2]]  # noqa: E731
    position, velocity = flight.get("px", "py", "pz"), flight.get("vx", "vy", "vz")
    rate, force = flight.get("wx", "wy", "wz"), flight.get("ax", "ay", "az")
    angles = np.degrees(_euler_ned(flight.get("qw", "qx", "qy", "qz")))
    motors = np.nan_to_num(flight.numbered("cmd_rotor_"))[:, :4]
    waiting = list(events)
    for k, t in enumerate(flight.t):
        us = round((t + 60.0) * 1e6)
        while waiting and waiting[0][0] <= t:
            _, kind, value = waiting.pop(0)
            yield kind, [us, value]
        yield 130, [us, 0, *frd(rate[k]), *frd(force[k])]
        if second_imu_off is not None:
            yield 130, [us, 1, *(frd(rate[k]) + np.array(second_imu_off)), *frd(force[k])]
        roll, pitch, yaw = angles[k]
        yield 131, [us, 0.0, roll, 0.0, pitch, 0.0, yaw % 360.0]
        yield 132, [us, 0, *ned(velocity[k]), *ned(position[k])]
        yield 132, [us, 1, *ned(velocity[k]), *(np.array(ned(position[k])) + 1.0)]
        widths = [1500] * 4
        for output, function in enumerate(functions):
            motor = function - 33
            if 0 <= motor < motors.shape[1]:
                widths[output] = round(1100 + 800 * motors[k, motor])
                yield 134, [us, output, 10_000 * motors[k, motor]]
            elif every_esc:
                yield 134, [us, output, 5_000.0]
        yield 133, [us, *widths]
        if k % 10 == 0:
            yield 135, [us, 0, 16.0 - 0.001 * k]


def length(letters: str) -> int:
    """Bytes of a message with its head."""
    return 3 + struct.calcsize("<" + "".join(_CODES[c] for c in letters))


def dataflash_bytes(flight: Flight, **options: Any) -> bytes:
    """The log as ArduPilot writes it."""
    out = bytearray()
    for kind, values in messages(flight, **options):
        letters = _FORMATS[kind][1]
        packed = []
        for letter, value in zip(letters, values, strict=True):
            if letter in "nNZ":
                packed.append(value.encode())
            else:
                packed.append(round(value * 100) if letter in "cC" else value if letter in "fd" else int(value))
        out += b"\xa3\x95" + bytes([kind]) + struct.pack("<" + "".join(_CODES[c] for c in letters), *packed)
    return bytes(out)


def dataflash_text(flight: Flight, **options: Any) -> bytes:
    """The same as ground stations convert it."""
    lines = []
    for kind, values in messages(flight, **options):
        name, letters, _ = _FORMATS[kind]
        cells = [
            v if isinstance(v, str) else f"{v:.2f}" if c in "cC" else f"{v:.7g}" if c in "fd" else str(int(v))
            for c, v in zip(letters, values, strict=True)
        ]
        lines.append(", ".join([name, *cells]))
    return ("\n".join(lines) + "\n").encode()


def _euler_ned(q: np.ndarray) -> np.ndarray:
    """Roll, pitch, yaw (rad) of the attitude from forward-right-down axes to north-east-down ones."""
    w, x, y, z = q.T
    matrix = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
    world, body = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]]), np.diag([1, -1, -1])
    turned = world @ matrix @ body
    roll = np.arctan2(turned[:, 2, 1], turned[:, 2, 2])
    pitch = -np.arcsin(np.clip(turned[:, 2, 0], -1, 1))
    return np.stack([roll, pitch, np.arctan2(turned[:, 1, 0], turned[:, 0, 0])], axis=-1)
