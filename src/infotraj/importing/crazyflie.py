"""Crazyflie micro-SD logs (uSD deck, versions 1 and 2), read straight from their bytes.

Layout (Bitcraze crazyflie-firmware, usddeck): 0xBC, version, count of events; an event: id, name, count of variables,
`name(type)` each; then records: id, time stamp (ms as uint32, or us as uint64), values; CRC32 at the end.
"""

from __future__ import annotations

import zlib
from array import array
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from infotraj.errors import InputError, problem
from infotraj.importing.log import Request, Samples, Topic, reading, what_is_left
from infotraj.progress import reached
from infotraj.rotations import Array

MAGIC = 0xBC
_EVERY = 1 << 16  # bytes, of which who waits is told
_OWN = ("event id", "timestamp")
_TYPES = {c: c for c in "bBhHiIqQefd"} | {"l": "i", "L": "I"}
_EXPECTED = "a Crazyflie micro-SD log (0xBC, version 1 or 2)"
_REMEDY = "Copy it again from the card."


@dataclass
class _Event:
    name: str
    record: np.dtype[Any]  # id, stamp, and the variables, packed
    offsets: array[int] = field(default_factory=lambda: array("q"))


class CrazyflieLog:
    """One log; the file is mapped, not loaded, and a record's place is all that is kept of it (8 bytes)."""

    kind = "crazyflie"

    def __init__(self, path: Path, allow_damaged: bool = False) -> None:
        self.path = path
        self.notes: list[str] = []
        with reading(path, _EXPECTED, _REMEDY):
            self._bytes = np.memmap(path, dtype=np.uint8, mode="r")
            self._version, self._events, start = self._header()
            faults = self._index(start)
            stored = int.from_bytes(self._bytes[-4:].tobytes(), "little")
            if not faults and _crc(self._bytes[:-4]) != stored:
                faults = "its check sum does not match"
        if faults and not allow_damaged:
            raise InputError(
                problem(
                    f"{path}: {faults}",
                    "a complete log",
                    what_is_left(path),
                )
            )
        if faults:
            self.notes.append(f"{faults}; what could be read was imported")
        self.topics = [Topic(e.name, "", 0, len(e.offsets)) for e in self._events.values()]
        self._by_name = {e.name: e for e in self._events.values()}

    def close(self) -> None:
        """Lets the mapped file go."""
        del self._bytes

    def has(self, topic: Topic, name: str) -> bool:
        """True where the event has the variable, or a part of it."""
        return name == "timestamp" or name.replace("*", "0") in self.fields(topic)

    def fields(self, topic: Topic) -> list[str]:
        """The event's variables; of a compressed quaternion its four parts, too."""
        record = self._by_name[topic.name].record
        names = [n for n in record.names or () if n not in _OWN]
        return [part for n in names for part in (n, *(_parts(n) if _is_compressed(record, n) else ()))]

    def first(self, topic: Topic, name: str) -> Any:
        """The variable in the event's first record."""
        event = self._by_name[topic.name]
        if name not in self.fields(topic) or not event.offsets:
            return None
        return self._column(event, name, np.array(event.offsets[:1]))[0].item()

    @np.errstate(invalid="ignore")  # damaged bytes may spell a signalling NaN
    def read(self, requests: list[Request]) -> list[Samples]:
        """The asked variables as doubles; the record's own stamp is the field `timestamp`, in ns."""
        found = []
        for request in requests:
            event = self._by_name[request.topic.name]
            offsets = np.array(event.offsets, dtype=np.int64)
            numbers: dict[str, Array] = {}
            for name in request.numbers:
                if "*" in name:
                    count = 0
                    while self.has(request.topic, name.replace("*", str(count))):
                        count += 1
                    columns = [self._column(event, name.replace("*", str(k)), offsets) for k in range(count)]
                    stacked = np.stack(columns, axis=-1) if columns else np.zeros((len(offsets), 0))
                    numbers[name] = stacked.astype(float)
                else:
                    numbers[name] = self._column(event, name, offsets).astype(float)
            stamp = self._column(event, "timestamp", offsets).astype(np.int64)
            nanoseconds = stamp * (1_000_000 if self._version == 1 else 1_000)
            found.append(Samples(None, {t: nanoseconds for t in request.times}, numbers))
        return found

    def _header(self) -> tuple[int, dict[int, _Event], int]:
        head = self._bytes[:5].tobytes()
        version, count = int.from_bytes(head[1:3], "little"), int.from_bytes(head[3:5], "little")
        if len(head) < 5 or head[0] != MAGIC or version not in (1, 2):
            raise ValueError(f"version {version}" if head[:1] == bytes([MAGIC]) else "no 0xBC at the start")
        stamp = "<u4" if version == 1 else "<u8"
        place = 5
        events = {}
        for _ in range(count):
            identity = self._word(place)
            name, place = self._name(place + 2)
            variables, place = self._word(place), place + 2
            fields: list[tuple[str, str]] = [("event id", "<u2"), ("timestamp", stamp)]
            for _ in range(variables):
                declared, place = self._name(place)
                if len(declared) < 4 or declared[-3] != "(" or declared[-2] not in _TYPES:
                    raise ValueError(f"variable {declared!r} of event {name!r} has no known type")
                fields.append((declared[:-3], "<" + _TYPES[declared[-2]]))
            events[identity] = _Event(name, np.dtype(fields))
        return version, events, place

    def _index(self, place: int) -> str:
        """Notes where every record lies; what is wrong with them, in words, or ''."""
        end = len(self._bytes) - 4
        if len(self._events) == 1:
            ((identity, event),) = self._events.items()
            size = event.record.itemsize
            count = max(end - place, 0) // size
            event.offsets.extend(range(place, place + count * size, size))
            ids = np.ndarray((count,), "<u2", self._bytes, place, (size,)) if count else np.zeros(0)
            wrong = np.flatnonzero(ids != identity)
            if wrong.size:
                del event.offsets[int(wrong[0]) :]
                return f"record {wrong[0]} is of an unknown event"
            return "" if place + count * size == end else "it ends inside a record"
        data = self._bytes.data
        sizes = {identity: event.record.itemsize for identity, event in self._events.items()}
        told = place
        while place < end:
            if place >= told:
                reached("reading", place, end)
                told += _EVERY
            identity = data[place] | data[place + 1] << 8
            if identity not in sizes:
                return f"unknown event {identity} at byte {place}"
            if place + sizes[identity] > end:
                return "it ends inside a record"
            self._events[identity].offsets.append(place)
            place += sizes[identity]
        return ""

    def _column(self, event: _Event, name: str, offsets: Any) -> Any:
        if name not in (event.record.names or ()):
            packed, part = name.rsplit(".", 1)
            return decompressed(self._column(event, packed, offsets))[:, "xyzw".index(part)]
        assert event.record.fields is not None  # as its names
        kind, shift = event.record.fields[name][:2]
        out = np.empty(len(offsets), dtype=kind)
        step = 1 << 18
        for k in range(0, len(offsets), step):
            part = offsets[k : k + step, None] + shift + np.arange(kind.itemsize)
            out[k : k + step] = np.ascontiguousarray(self._bytes[part]).view(kind)[:, 0]
        return out

    def _word(self, place: int) -> int:
        if place + 2 > len(self._bytes):
            raise ValueError("it ends inside its header")
        return int(self._bytes[place]) | int(self._bytes[place + 1]) << 8

    def _name(self, place: int) -> tuple[str, int]:
        window = self._bytes[place : place + 256].tobytes()
        length = window.find(b"\0")
        if length < 0:
            raise ValueError("a name in its header has no end")
        return window[:length].decode(), place + length + 1


def decompressed(packed: Any) -> Array:
    """Quaternions x, y, z, w (n, 4) of the firmware's 32 bits (n,); NaN for 0, which says "not yet".

    The two highest bits say which component is the largest; it is positive and follows from the norm. The others
    follow in order, each a sign and nine bits of its magnitude over sqrt(1/2) (J. A. Preiss, quatcompress, 2016).
    """
    packed = np.asarray(packed, dtype=np.int64)
    largest = packed >> 30
    q = np.zeros((packed.size, 4))
    left = packed.copy()
    for k in (3, 2, 1, 0):
        small = largest != k
        value = (left & 0x1FF) / 511.0 * np.sqrt(0.5)
        q[small, k] = np.where(left & 0x200, -value, value)[small]
        left = np.where(small, left >> 10, left)
    squares = (q**2).sum(axis=1)
    rows = np.arange(packed.size)
    q[rows, largest & 3] = np.sqrt(np.maximum(1.0 - squares, 0.0))
    q[(packed == 0) | (squares > 1.0 + 1e-3)] = np.nan
    return q


def _is_compressed(record: np.dtype[Any], name: str) -> bool:
    return name.endswith(".quat") and record[name] == np.dtype("<u4")


def _parts(name: str) -> tuple[str, ...]:
    return tuple(f"{name}.{part}" for part in "xyzw")


def _crc(data: Any) -> int:
    crc = 0
    for k in range(0, len(data), 1 << 22):
        crc = zlib.crc32(data[k : k + (1 << 22)], crc)
    return crc
