"""The number encodings of a blackbox log, compiled.

Format: "Blackbox logging internals" (Cleanflight, Betaflight and INAV developer documentation). A reader's `place` is
(2,) int64: the next byte, and 1 once a read ran past the end; what is read there is 0.
"""

from __future__ import annotations

from typing import Any

from numba import njit

SIGNED_VB, UNSIGNED_VB, NEG_14BIT, TAG8_8SVB, TAG2_3S32, TAG8_4S16, NULL, TAG2_3SVARIABLE = 0, 1, 3, 6, 7, 8, 9, 10


@njit(cache=True)
def byte(data: Any, place: Any) -> int:
    """The next byte."""
    if place[0] >= data.size:
        place[1] = 1
        return 0
    place[0] += 1
    return int(data[place[0] - 1])


@njit(cache=True)
def unsigned(data: Any, place: Any) -> int:
    """Seven bits a byte, the lowest first; the highest bit says that another byte follows. At most 32 bits."""
    value = 0
    for shift in range(0, 35, 7):
        part = byte(data, place)
        value |= (part & 0x7F) << shift
        if part < 128:
            return value & 0xFFFFFFFF
    return 0


@njit(cache=True)
def signed(data: Any, place: Any) -> int:
    """The same, with the sign in the lowest bit (zigzag)."""
    value = unsigned(data, place)
    return (value >> 1) ^ -(value & 1)


@njit(cache=True)
def extend(value: int, bits: int) -> int:
    """The two's complement number in the lowest `bits` bits."""
    value &= (1 << bits) - 1
    return value - (1 << bits) if value >> (bits - 1) else value


@njit(cache=True)
def little_endian(data: Any, place: Any, count: int) -> int:
    """A signed number of `count` bytes, the lowest first."""
    value = 0
    for k in range(count):
        value |= byte(data, place) << (8 * k)
    return extend(value, 8 * count)


@njit(cache=True)
def three(data: Any, place: Any, out: Any, variable: bool) -> None:
    """TAG2_3S32, or TAG2_3SVARIABLE: three numbers, whose width two leading bits give."""
    lead = byte(data, place)
    width = lead >> 6
    if width == 0:
        out[0], out[1], out[2] = extend(lead >> 4, 2), extend(lead >> 2, 2), extend(lead, 2)
    elif width == 3:
        for k in range(3):
            out[k] = little_endian(data, place, ((lead >> (2 * k)) & 3) + 1)
    elif variable and width == 1:
        bits = lead << 8 | byte(data, place)
        out[0], out[1], out[2] = extend(bits >> 9, 5), extend(bits >> 4, 5), extend(bits, 4)
    elif variable:
        bits = lead << 16 | byte(data, place) << 8
        bits |= byte(data, place)
        out[0], out[1], out[2] = extend(bits >> 14, 8), extend(bits >> 7, 7), extend(bits, 7)
    elif width == 1:
        out[0] = extend(lead, 4)
        rest = byte(data, place)
        out[1], out[2] = extend(rest >> 4, 4), extend(rest, 4)
    else:
        out[0] = extend(lead, 6)
        out[1] = extend(byte(data, place), 6)
        out[2] = extend(byte(data, place), 6)


@njit(cache=True)
def four(data: Any, place: Any, out: Any, version: int) -> None:
    """TAG8_4S16: four numbers of 0, 4, 8 or 16 bits; from data version 2 packed by half bytes, high half first."""
    tag = byte(data, place)
    held, half, paired = 0, False, False
    for k in range(4):
        size = (tag >> (2 * k)) & 3
        if version < 2:
            # version 1 writes two four-bit numbers as one byte, whatever the second one's tag
            if paired:
                out[k], paired = extend(held >> 4, 4), False
            elif size == 1:
                held = byte(data, place)
                out[k], paired = extend(held, 4), True
            else:
                out[k] = little_endian(data, place, size - 1) if size else 0
        elif size == 0:
            out[k] = 0
        elif size == 1:
            if half:
                out[k] = extend(held, 4)
            else:
                held = byte(data, place)
                out[k] = extend(held >> 4, 4)
            half = not half
        else:
            bits = held & 0xF if half else byte(data, place)
            for _ in range(size - 1 if half else size - 2):
                held = byte(data, place)
                bits = bits << 8 | held
            out[k] = extend(bits >> 4 if half else bits, 8 if size == 2 else 16)


@njit(cache=True)
def coded(data: Any, place: Any, encoding: Any, version: int, out: Any) -> bool:
    """One frame's numbers before prediction, into `out` (n + 8,). False where an encoding is unknown."""
    k = 0
    while k < encoding.size:
        kind = encoding[k]
        step = 1
        if kind == UNSIGNED_VB:
            out[k] = unsigned(data, place)
        elif kind == SIGNED_VB:
            out[k] = signed(data, place)
        elif kind == NULL:
            out[k] = 0
        elif kind == NEG_14BIT:
            out[k] = -extend(unsigned(data, place), 14)
        elif kind == TAG8_8SVB:
            while step < 8 and k + step < encoding.size and encoding[k + step] == kind:
                step += 1
            if step == 1:
                out[k] = signed(data, place)
            else:
                tag = byte(data, place)
                for j in range(step):
                    out[k + j] = signed(data, place) if tag >> j & 1 else 0
        elif kind in (TAG2_3S32, TAG2_3SVARIABLE):
            three(data, place, out[k:], kind == TAG2_3SVARIABLE)
            step = 3
        elif kind == TAG8_4S16:
            four(data, place, out[k:], version)
            step = 4
        else:
            return False
        k += step
    return True
