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
from infotraj.progress import reached
from infotraj.rotations import Array

_EXPECTED = "a complete, indexed ROS 1 or ROS 2 bag"
_REMEDY = "It may be truncated: run `rosbag reindex`, `ros2 bag reindex` or `mcap recover`, or copy it again."
_EVERY = 1000  # messages, of which who waits is told
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

            self._ros = 1 if path.suffix.lower() == ".bag" else 2
            # The reader knows its two formats by their suffixes in small letters.
            capitals = {suffix.upper(): plugin for suffix, plugin in Reader2.STORAGE_PLUGINS.items()}
            any_case = type("AnyCase", (Reader2,), {"STORAGE_PLUGINS": {**Reader2.STORAGE_PLUGINS, **capitals}})
            self._reader: Any = Reader1(path) if self._ros == 1 else any_case(path)
            try:
                self._reader.open()
            except KeyError as error:
                # What the reader raises, bare, for schemas other than ROS 2's.
                raise ValueError(f"schema encoding {error} is not ROS 2's") from error
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
        self._decoders: dict[str, Callable[[bytes, str], Any]] = {}

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
        columns = [_Columns(request, self._is_stamp(request)) for request in requests]
        by_topic: dict[str, list[_Columns]] = {}
        for request, column in zip(requests, columns, strict=True):
            by_topic.setdefault(request.topic.name, []).append(column)
        connections = [c for name in by_topic for c in self._connections[name]]
        if connections:
            count = sum(c.msgcount for c in connections)
            with reading(self.path, _EXPECTED, _REMEDY):
                for k, (connection, record, raw) in enumerate(self._reader.messages(connections=connections)):
                    if k % _EVERY == 0:
                        reached("reading", k, count)
                    message = self._decode(raw, connection.msgtype)
                    for column in by_topic[connection.topic]:
                        column.add(record, message)
        return [column.samples() for column in columns]

    def _is_stamp(self, request: Request) -> list[bool]:
        """For every time field, whether it is a ROS time (seconds and nanoseconds) and no plain number."""
        store = self._store(request.topic.type)
        return [store is not None and _resolves(store, request.topic.type, f"{t}.sec") for t in request.times]

    def _decode(self, raw: bytes, name: str) -> Any:
        decode = self._decoders.get(name) or self._decoder(name)
        try:
            return decode(raw, name)
        # Bytes that do not fit the definition fail in generated code, with any kind of error.
        except Exception as error:
            text = " ".join(str(error).split())[:120]
            raise InputError(
                problem(
                    f"{self.path}: a message does not fit the definition of {name} ({text})",
                    "the definition that the message was recorded with",
                    "Give it with --definitions, or copy the bag again.",
                )
            ) from error

    def _decoder(self, name: str) -> Callable[[bytes, str], Any]:
        store = self._store(name)
        if store is None:
            raise InputError(
                problem(
                    f"{self.path}: no definition of {name}",
                    "one in the bag, in the mapping's `definitions` or in --definitions",
                    "Give the folder that holds its package/msg.",
                )
            )
        self._decoders[name] = store.deserialize_ros1 if self._ros == 1 else store.deserialize_cdr
        return self._decoders[name]

    def _store(self, name: str) -> Any:
        if name not in self._stores:
            embedded = next(c.msgdef for group in self._connections.values() for c in group if c.msgtype == name)
            with reading(self.path, f"a definition of {name} that can be read", "Give one with --definitions."):
                self._stores[name] = self._definitions.store(name, embedded)
            if name.startswith("px4_msgs/") and self._stores[name] is not None and not self._fits(name):
                self._stores[name] = None
            if self._stores[name] is None:
                self.notes.append(
                    f"{name}: no definition in the bag that fits; give one with --definitions to read its topics"
                )
        return self._stores[name]

    def _fits(self, name: str) -> bool:
        """True where the first message can be read: px4_msgs differ between releases, and those shipped are of one."""
        own = [c for group in self._connections.values() for c in group if c.msgtype == name]
        for connection, _, raw in self._reader.messages(connections=own):
            try:
                self._decode(raw, connection.msgtype)
            except InputError:
                return False
            return True
        return True


def _length(value: Any) -> int:
    return 0 if value is None else len(value)


class _Columns:
    """Collects a request's numbers as flat arrays of doubles.

    This runs once a message and decides how fast a bag is read: one attrgetter, which runs in C, takes all plain
    fields and the stamps' two parts (both exact as doubles).
    """

    def __init__(self, request: Request, stamps: list[bool]) -> None:
        self._request = request
        self._plain = [n for n in request.numbers if "*" not in n]
        self._stars = [n for n in request.numbers if "*" in n]
        self._stamps = [t for t, is_stamp in zip(request.times, stamps, strict=True) if is_stamp]
        self._counters = [t for t, is_stamp in zip(request.times, stamps, strict=True) if not is_stamp]
        self._flat_names = [*self._plain, *(f"{t}.{part}" for t in self._stamps for part in ("sec", "nanosec"))]
        self._get = _getter(self._flat_names)
        self._record = array("q")
        self._flat = array("d")
        self._arrays = [(_array_getter(n), array("d"), array("q")) for n in self._stars]
        self._counts = [(attrgetter(t), array("q")) for t in self._counters]

    def add(self, record: int, message: Any) -> None:
        try:
            self._flat.extend(self._get(message))
            for get, flat, count in self._arrays:
                values = get(message)
                flat.extend(values)
                count.append(len(values))
            for get, column in self._counts:
                column.append(get(message))
        except (TypeError, ValueError, IndexError, AttributeError, OverflowError) as error:
            raise InputError(
                problem(
                    f"topic {self._request.topic.name}, message {len(self._record)}: {error}",
                    f"numbers in {', '.join(self._request.numbers)}",
                    "Correct the mapping, or leave the topic out.",
                )
            ) from error
        self._record.append(record)

    def samples(self) -> Samples:
        record = _as_array(self._record, np.int64)
        flat = _as_array(self._flat, float).reshape(len(record), len(self._flat_names))
        numbers: dict[str, Array] = {name: flat[:, k] for k, name in enumerate(self._plain)}
        for name, (_, values, count) in zip(self._stars, self._arrays, strict=True):
            numbers[name] = _ragged(_as_array(values, float), _as_array(count, np.int64))
        times = {t: _as_array(values, np.int64) for t, (_, values) in zip(self._counters, self._counts, strict=True)}
        for k, name in enumerate(self._stamps):
            parts = flat[:, len(self._plain) + 2 * k :][:, :2].astype(np.int64)
            times[name] = parts[:, 0] * 1_000_000_000 + parts[:, 1]
        return Samples(record, times, numbers)


def _as_array(values: Any, kind: Any) -> Any:
    return np.frombuffer(values, dtype=kind) if len(values) else np.zeros(0, dtype=kind)


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
    """One call that gives all the named fields."""
    if not names:
        return lambda message: ()
    if any("[" in name for name in names):
        paths = [_parts(name) for name in names]
        return lambda message: [_walk(path, message) for path in paths]
    if len(names) == 1:
        get = attrgetter(names[0])
        return lambda message: (get(message),)
    return attrgetter(*names)


def _array_getter(name: str) -> Callable[[Any], Any]:
    if name.endswith("[*]") and "[" not in name[:-3]:
        return attrgetter(name[:-3])
    parts = _parts(name)
    return lambda message: _walk(parts, message)


def _resolves(store: Any, type_name: str, name: str) -> bool:
    from rosbags.interfaces import Nodetype

    current: tuple[Any, Any] = (Nodetype.NAME, type_name)
    for part, index in _parts(name):
        # A damaged definition may name a type that the file does not define.
        if current[0] != Nodetype.NAME or current[1] not in store.fielddefs:
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
