"""Writes a flight as a Betaflight blackbox log, I and P frames, from the format's documentation."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

from infotraj.flight import Flight

NAMES = [
    "loopIteration", "time", "vbatLatest", "gyroADC[0]", "gyroADC[1]", "gyroADC[2]", "accSmooth[0]", "accSmooth[1]",
    "accSmooth[2]", "motor[0]", "motor[1]", "motor[2]", "motor[3]", "eRPM[0]", "eRPM[1]", "eRPM[2]", "eRPM[3]",
]  # fmt: skip
SIGNED = [0, 0, 0, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0]
I_PREDICTOR = [0, 0, 9, 0, 0, 0, 0, 0, 0, 11, 5, 5, 5, 0, 0, 0, 0]
I_ENCODING = [1, 1, 3, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1]
P_PREDICTOR = [6, 2, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 1, 1, 1, 1]
P_ENCODING = [9, 0, 6, 7, 7, 7, 10, 10, 10, 8, 8, 8, 8, 6, 6, 6, 6]
REFERENCE, LOW = 1600, 158


def blackbox_bytes(flight: Flight, poles: int = 14, interval: int = 32, every: int = 4) -> bytes:
    """The file. Rotor commands are throttles; deg/s, 1/2048 g, DShot, 0.01 V, 100 electrical rpm are whole."""
    rate = np.degrees(flight.get("wx", "wy", "wz"))
    force = flight.get("ax", "ay", "az") / 9.80665 * 2048
    motors = 48 + 1999 * np.nan_to_num(flight.numbered("cmd_rotor_"))[:, :4]
    turns = 10_000 * np.nan_to_num(flight.numbered("cmd_rotor_"))[:, :4] * poles / 2 / 100
    volts = np.nan_to_num(flight.get("battery"), nan=16.0) * 100
    time = flight.t[:, None] * 1e6 + 3_000_000
    rows = np.round(np.column_stack([np.arange(len(time)) * every, time, volts, rate, force, motors, turns])).astype(
        int
    )
    lists: dict[str, Sequence[object]] = {
        "I name": NAMES, "I signed": SIGNED, "I predictor": I_PREDICTOR, "I encoding": I_ENCODING,
        "P predictor": P_PREDICTOR, "P encoding": P_ENCODING, "S name": ["flightModeFlags", "stateFlags"],
        "S signed": [0, 0], "S predictor": [0, 0], "S encoding": [1, 1],
    }  # fmt: skip
    head = ["Product:Blackbox flight data recorder by Nicholas Sherlock", "Data version:2", f"I interval:{interval}"]
    head += [f"P interval:1/{every}", "Firmware type:Cleanflight", "Firmware revision:Betaflight 4.5.1 (77d01ba3b) X"]
    head += [f"Field {name}:{','.join(map(str, values))}" for name, values in lists.items()]
    head += [
        "minthrottle:1070",
        "gyro_scale:0x3f800000",
        f"motorOutput:{LOW},2047",
        "acc_1G:2048",
        f"vbatref:{REFERENCE}",
    ]
    head += [f"motor_poles:{poles}"]
    out = bytearray("".join(f"H {line}\n" for line in head).encode())
    out += b"S" + unsigned(1) + unsigned(0)
    last = before = rows[0]
    for row in rows:
        if row[0] % interval == 0:
            expected = [0, 0, REFERENCE, *[0] * 6, LOW, *[row[9]] * 3, *[0] * 4]
            out += b"I" + coded(row - expected, I_ENCODING)
            last = before = row
        else:
            average = np.trunc((last + before) / 2).astype(int)
            expected = [row[0], 2 * last[1] - before[1], last[2], *average[3:13], *last[13:]]
            out += b"P" + coded(row - expected, P_ENCODING)
            last, before = row, last
    return bytes(out) + b"E\xffEnd of log\x00"


def unsigned(value: int) -> bytes:
    """Seven bits a byte, the lowest first."""
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes([*out, value])


def signed(value: int) -> bytes:
    """The same of a zigzag number."""
    return unsigned((value << 1 ^ value >> 31) & 0xFFFFFFFF)


def coded(values: np.ndarray, encoding: list[int]) -> bytes:
    """One frame's differences; groups at their widest tag but the four-bit ones of TAG8_4S16."""
    out, k = bytearray(), 0
    while k < len(encoding):
        kind, value = encoding[k], int(values[k])
        if kind == 9:
            k += 1
        elif kind in (0, 1, 3):
            out += signed(value) if kind == 0 else unsigned(value if kind == 1 else -value & 0x3FFF)
            k += 1
        elif kind == 6:
            group = [int(v) for v in values[k : k + run(encoding, k)]]
            if len(group) == 1:
                out += signed(group[0])
            else:
                out.append(sum((v != 0) << j for j, v in enumerate(group)))
                out += b"".join(signed(v) for v in group if v)
            k += len(group)
        elif kind in (7, 10):
            group = [int(v) for v in values[k : k + 3]]
            if max(map(abs, group)) < 2:
                out.append(sum((v & 3) << (4 - 2 * j) for j, v in enumerate(group)))
            else:
                out += bytes([0b11101010 if kind == 7 else 0b11010101])
                sizes = (3, 3, 3) if kind == 7 else (2, 2, 2)
                out += b"".join(struct.pack("<i", v)[:size] for v, size in zip(group, sizes, strict=True))
            k += 3
        else:
            group = [int(v) for v in values[k : k + 4]]
            tags = [0 if v == 0 else 1 if -8 <= v < 8 else 2 if -128 <= v < 128 else 3 for v in group]
            bits = "".join(format(v & (1 << 4 * 2 ** (t - 1)) - 1, f"0{4 * 2 ** (t - 1)}b") for v, t in zip(group, tags, strict=True) if t)  # fmt: skip # noqa: E501
            bits += "0" * (-len(bits) % 8)
            out.append(sum(t << 2 * j for j, t in enumerate(tags)))
            out += bytes(int(bits[j : j + 8], 2) for j in range(0, len(bits), 8))
            k += 4
    return bytes(out)


def run(encoding: list[int], start: int) -> int:
    """How many fields from `start` share their encoding, at most eight."""
    count = 1
    while count < 8 and start + count < len(encoding) and encoding[start + count] == encoding[start]:
        count += 1
    return count
