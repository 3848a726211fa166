"""ROS 1 and ROS 2 bags (.bag; folder, .db3, .mcap), read message by message through rosbags."""

from __future__ import annotations

import re
from array import array
from collections.abc import Callable
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from infotraj.errors import InputError, problem
from infotraj.importing.definitions import Definitions
from infotraj.importing.log import Request, Samples, Topic, reading
from infotraj.rotations import Array

_EXPECTED = "a complete, indexed ROS 1 or ROS 2 bag"
_REMEDY = "It may be truncated: run `rosbag reindex`, `ros2 bag reindex` or `mcap recover`, or copy it again."
_PART = re.compile(r"^(\w+)(?:\[(\d+|\*)\])?$")


class RosBag:
    """One bag. Only the asked topics are decoded, and of them only the asked fields are kept (8 bytes a number)."""

    kind = "rosbag"

    def __init__(self, path: Path, definitions: tuple[Path, ...] = ()) -> None:
        self.path = path
        self.notes: list[str] = []
        with reading(path, _EXPECTED, _REMEDY):
            from rosbags.rosbag1 import Reader as Reader1
            from rosbags.rosbag2 import Reader as Reader2

            self._ros = 1 if path.suffix == ".bag" else 2
            self._reader: Any = Reader1(path) if self._ros == 1 else Reader2(path)
            self._reader.open()
            try:
                self._definitions = Definitions(definitions, self._ros)
                self._connections: dict[str, list[Any]] = {}
                for connection in self._reader.connections:
                    self._connections.setdefault(connection.topic, []).append(connection)
                self.topics = [
                    Topic(name, group[0].msgtype, 0, sum(c.msgcount for c in group))
                    for name, group in sorted(self._connections.items())
                ]
            except BaseException:
                self._reader.close()
                raise
        self._stores: dict[str, Any] = {}

    def close(self) -> None:
        """Closes the bag."""
        self._reader.close()

    def has(self, topic: Topic, name: str) -> bool:
        """True where the topic's message type has the field, through nested types; False without a definition."""
        store = self._store(topic.type)
        if store is None:
            return False
        if name == "record" or "*" not in name:
            return name == "record" or _resolves(store, topic.type, name)
        # An array that is declared may still be empty in every message.
        return _resolves(store, topic.type, name) and _length(self.first(topic, name)) > 0

    def first(self, topic: Topic, name: str) -> Any:
        """The field's value in the topic's first message."""
        with reading(self.path, _EXPECTED, _REMEDY):
            for connection, _, raw in self._reader.messages(connections=self._connections[topic.name]):
                try:
                    return _walk(_parts(name), self._decode(raw, connection.msgtype))
                except (AttributeError, IndexError):
                    return None
        return None

    def read(self, requests: list[Request]) -> list[Samples]:
        """One pass over the bag's chunks that hold the asked topics."""
        columns = [_Columns(request) for request in requests]
        by_topic: dict[str, list[_Columns]] = {}
        for request, column in zip(requests, columns, strict=True):
            by_topic.setdefault(request.topic.name, []).append(column)
        connections = [c for name in by_topic for c in self._connections[name]]
        if connections:
            with reading(self.path, _EXPECTED, _REMEDY):
                for connection, record, raw in self._reader.messages(connections=connections):
                    message = self._decode(raw, connection.msgtype)
                    for column in by_topic[connection.topic]:
                        column.add(record, message)
        return [column.samples(self.path) for column in columns]

    def _decode(self, raw: bytes, name: str) -> Any:
        store = self._store(name)
        if store is None:
            raise InputError(
                problem(
                    f"{self.path}: no definition of {name}",
                    "one in the bag, in the mapping's `definitions` or in --definitions",
                    "Give the folder that holds its package/msg.",
                )
            )
        return store.deserialize_ros1(raw, name) if self._ros == 1 else store.deserialize_cdr(raw, name)

    def _store(self, name: str) -> Any:
        if name not in self._stores:
            embedded = next(c.msgdef for group in self._connections.values() for c in group if c.msgtype == name)
            with reading(self.path, f"a definition of {name} that can be read", "Give one with --definitions."):
                self._stores[name] = self._definitions.store(name, embedded)
            if self._stores[name] is None:
                self.notes.append(f"{name}: no definition in the bag; give one with --definitions to read its topics")
        return self._stores[name]


def _length(value: Any) -> int:
    return 0 if value is None else len(value)


class _Columns:
    """Collects a request's numbers as flat arrays of doubles."""

    def __init__(self, request: Request) -> None:
        self._request = request
        self._plain = [n for n in request.numbers if "*" not in n]
        self._stars = [n for n in request.numbers if "*" in n]
        self._get = _getter(self._plain)
        self._star_parts = [_parts(n) for n in self._stars]
        self._times = [_time_getter(t) for t in request.times]
        self._record = array("q")
        self._flat = array("d")
        self._star_flat = [array("d") for _ in self._stars]
        self._star_count = [array("q") for _ in self._stars]
        self._time_values = [array("q") for _ in request.times]

    def add(self, record: int, message: Any) -> None:
        try:
            self._flat.extend(self._get(message))
            for flat, count, parts in zip(self._star_flat, self._star_count, self._star_parts, strict=True):
                values = _walk(parts, message)
                flat.extend(values)
                count.append(len(values))
            for column, get in zip(self._time_values, self._times, strict=True):
                column.append(get(message))
        except (TypeError, ValueError, IndexError, AttributeError) as error:
            raise InputError(
                problem(
                    f"topic {self._request.topic.name}, message {len(self._record)}: {error}",
                    f"numbers in {', '.join(self._request.numbers)}",
                    "Correct the mapping, or leave the topic out.",
                )
            ) from error
        self._record.append(record)

    def samples(self, path: Path) -> Samples:
        record = np.frombuffer(self._record, dtype=np.int64) if self._record else np.zeros(0, dtype=np.int64)
        n = len(record)
        flat = (np.frombuffer(self._flat) if self._flat else np.zeros(0)).reshape(n, len(self._plain))
        numbers: dict[str, Array] = {name: flat[:, k] for k, name in enumerate(self._plain)}
        for name, values, count in zip(self._stars, self._star_flat, self._star_count, strict=True):
            numbers[name] = _ragged(np.array(values), np.array(count, dtype=np.int64))
        times = {
            name: np.frombuffer(values, dtype=np.int64) if values else np.zeros(0, dtype=np.int64)
            for name, values in zip(self._request.times, self._time_values, strict=True)
        }
        return Samples(record, times, numbers)


def _ragged(values: Array, count: Any) -> Array:
    """(n, most) of rows that were concatenated; NaN where a row is shorter."""
    most = int(count.max()) if count.size else 0
    if values.size == count.size * most:
        return values.reshape(count.size, most)
    out = np.full((count.size, most), np.nan)
    row = np.repeat(np.arange(count.size), count)
    out[row, np.arange(values.size) - np.repeat(np.cumsum(count) - count, count)] = values
    return out


def _parts(name: str) -> list[tuple[str, int | str | None]]:
    parts: list[tuple[str, int | str | None]] = []
    for part in name.split("."):
        found = _PART.match(part)
        if found is None:
            raise InputError(
                problem(f"field {name!r}", "names joined by dots, with [0] or [*]", "Correct the mapping.")
            )
        index = found[2]
        parts.append((found[1], index if index in (None, "*") else int(index)))
    return parts


def _walk(parts: list[tuple[str, int | str | None]], value: Any) -> Any:
    for depth, (name, index) in enumerate(parts):
        value = getattr(value, name)
        if index == "*":
            rest = parts[depth + 1 :]
            return [_walk(rest, item) for item in value] if rest else value
        if index is not None:
            value = value[index]
    return value


def _getter(names: list[str]) -> Callable[[Any], Any]:
    """One call that gives all plain fields; attrgetter runs in C, which decides how fast a bag is read."""
    if not names:
        return lambda message: ()
    if any("[" in name for name in names):
        paths = [_parts(name) for name in names]
        return lambda message: [_walk(path, message) for path in paths]
    if len(names) == 1:
        get = attrgetter(names[0])
        return lambda message: (get(message),)
    return attrgetter(*names)


def _time_getter(name: str) -> Callable[[Any], int]:
    get = attrgetter(name)

    def value(message: Any) -> int:
        found = get(message)
        return int(found) if not hasattr(found, "nanosec") else found.sec * 1_000_000_000 + found.nanosec

    return value


def _resolves(store: Any, type_name: str, name: str) -> bool:
    from rosbags.interfaces import Nodetype

    current: tuple[Any, Any] = (Nodetype.NAME, type_name)
    for part, index in _parts(name):
        if current[0] != Nodetype.NAME:
            return False
        fields = dict(store.fielddefs[current[1]][1])
        if part not in fields:
            return False
        current = fields[part]
        if index is not None:
            if current[0] not in (Nodetype.ARRAY, Nodetype.SEQUENCE):
                return False
            inner, size = current[1]
            if current[0] == Nodetype.ARRAY and index != "*" and int(index) >= size:
                return False
            current = inner
    return current[0] in (Nodetype.BASE, Nodetype.NAME)
