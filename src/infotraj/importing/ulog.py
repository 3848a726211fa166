"""PX4 ULog files, read through pyulog; only the named topics are kept in memory.

Format: PX4 developer guide, "ULog File Format". Times are microseconds since boot.
"""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

import numpy as np

from infotraj.errors import InputError, problem
from infotraj.importing.log import Request, Samples, Topic, reading, what_is_left
from infotraj.progress import reached
from infotraj.rotations import Array

_EXPECTED = "a ULog file"
_REMEDY = "Copy it again from the vehicle."
_COMMANDS = ("actuator_motors", "actuator_outputs")
# Speeds follow their commands within 20 to 50 ms; commands held for longer than that do not tell the thrust.
_ROTOR_S = 0.025
_EVERY = 1000  # reads, of which who waits is told


class ULogFile:
    """One ULog. `names` are the topics that may be asked for; pyulog reads a file once, from end to end.

    `others`: the log's topics beside those that were read, with None or (where none was logged) 0 messages.
    """

    kind = "ulog"

    def __init__(self, path: Path, names: frozenset[str], allow_damaged: bool = False) -> None:
        self.path = path
        self.notes: list[str] = []
        asked = _Asked(names)
        with reading(path, _EXPECTED, _REMEDY):
            from pyulog import ULog

            with _Watched(path) as file, contextlib.redirect_stdout(io.StringIO()):
                log = ULog(file, message_name_filter_list=asked)
            short = file.short
        self._data = {(d.name, d.multi_id): d.data for d in log.data_list}
        self.topics = [
            Topic(name, name, instance, len(data["timestamp"]))
            for (name, instance), data in sorted(self._data.items())
            if "timestamp" in data
        ]
        read = {topic.name for topic in self.topics}
        self.others = [Topic(n, n, 0, 0 if n in names else None) for n in sorted(asked.subscribed - read)]
        if log.file_corruption or short:
            what = "is damaged" if log.file_corruption else f"ends inside a message (at byte {path.stat().st_size})"
            if not allow_damaged:
                raise InputError(
                    problem(
                        f"{path}: {what}",
                        "a complete ULog file",
                        what_is_left(path),
                    )
                )
            self.notes.append(f"the file {what}; what is left was imported")
        self.notes += [note for topic in self.topics for note in _slow(topic, self._data[topic.name, topic.instance])]
        if log.dropouts:
            lost = sum(d.duration for d in log.dropouts) / 1000.0
            self.notes.append(f"{len(log.dropouts)} logging dropouts, {lost:.2f} s in all")

    def close(self) -> None:
        """Nothing is open: pyulog closed the file."""

    def has(self, topic: Topic, name: str) -> bool:
        """True where the topic has the field."""
        return name.replace("*", "0") in self._data[topic.name, topic.instance]

    def first(self, topic: Topic, name: str) -> Any:
        """The field in the topic's first message."""
        data = self._data[topic.name, topic.instance]
        return data[name][0].item() if name in data and len(data[name]) else None

    @np.errstate(invalid="ignore")  # damaged bytes may spell a signalling NaN
    def read(self, requests: list[Request]) -> list[Samples]:
        """The asked fields as doubles."""
        found = []
        for request in requests:
            data = self._data[request.topic.name, request.topic.instance]
            numbers: dict[str, Array] = {}
            for name in request.numbers:
                numbers[name] = _starred(data, name) if "*" in name else data[name].astype(float)
            times = {t: data[t].astype(np.int64) for t in request.times}
            found.append(Samples(None, times, numbers))
        return found


def _slow(topic: Topic, data: dict[str, Any]) -> list[str]:
    """A note where commands are logged more slowly than rotors answer them."""
    if topic.name not in _COMMANDS or topic.instance or len(data["timestamp"]) < 3:
        return []
    period = float(np.median(np.diff(data["timestamp"].astype(np.int64)))) / 1e6
    if period <= _ROTOR_S:
        return []
    return [
        f"{topic.name} is logged every {period * 1e3:.0f} ms, more slowly than rotors answer: questions of force and "
        "torque stay open; set bit 4 of SDLOG_PROFILE (high rate)"
    ]


def _starred(data: dict[str, Any], name: str) -> Array:
    count = 0
    while name.replace("*", str(count)) in data:
        count += 1
    return np.stack([data[name.replace("*", str(k))].astype(float) for k in range(count)], axis=-1)


class _Asked(list[str]):
    """The topics that pyulog is to read. It looks every topic of the log up in them: `subscribed` holds their names."""

    def __init__(self, names: frozenset[str]) -> None:
        super().__init__(sorted(names))
        self.subscribed: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.subscribed.add(str(name))
        return super().__contains__(name)


class _Watched(io.BufferedReader):
    """A file that remembers whether a read came back short: pyulog stops there without a word.

    It steps back by what it asked for, not by what it got: from where a short read left off it would go back to bytes
    that it has read, for ever. So a step counts from where the file would be were it long enough.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path), buffer_size=1 << 20)
        self.short = False
        self._missing = self._reads = 0
        self._size = path.stat().st_size

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        beyond, self._missing = self._missing, 0
        return super().seek(offset + beyond if whence == io.SEEK_CUR else offset, whence)

    def read(self, size: int | None = -1) -> bytes:
        data = super().read(size)
        self._missing = max(0, (size or 0) - len(data))
        self._reads += 1
        if self._reads % _EVERY == 0:
            reached("reading", self.tell(), self._size)
        if (size is not None and size > 0 and 0 < len(data) < size) or (size and size > 3 and not data):
            self.short = True
        return data
