"""Blackbox logs of Betaflight, Cleanflight and INAV (.bbl, .bfl, .txt).

A file holds one log a flight, one behind another: the path `FILE#3` means its third. Body axes are x forward, y left,
z up, as the firmware has them: roll to the right, nose down and turning left are positive rates.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from infotraj.errors import InputError, problem
from infotraj.importing.blackbox_header import MAGIC, Header, parse_header
from infotraj.importing.log import Request, Samples, Topic, reading
from infotraj.rotations import Array

_EXPECTED = "a blackbox log of Betaflight, Cleanflight or INAV"
_REMEDY = "Copy it again from the flight controller."
_SHOWN = 12


def split_number(path: Path) -> tuple[Path, int | None]:
    """`FILE#3` as (FILE, 3), where there is no file of that whole name; else (path, None)."""
    name, mark, number = path.name.rpartition("#")
    if mark and number.isascii() and number.isdigit() and not path.exists() and path.with_name(name).is_file():
        return path.with_name(name), int(number)
    return path, None


class BlackboxLog:
    """One log of a blackbox file.

    Topic `main`: time (us) and every field of the main frames as logged, but gyroADC and gyroUnfilt in deg/s, accSmooth
    in g and vbatLatest in V by the header; `throttle[k]` (0..1) is motor[k], `rpm[k]` the rotor's turns from eRPM[k]
    and the header's motor poles, `attitude[k]` the quaternion w x y z whose x y z are imuQuaternion. Topic `slow`: the
    slow frames, and `armed`, at the time of the main frame that follows.
    """

    kind = "blackbox"

    def __init__(self, path: Path, allow_damaged: bool = False) -> None:
        file, number = split_number(path)
        self.path, self.notes = path, []
        with reading(path, _EXPECTED, _REMEDY):
            data = file.read_bytes()
            starts = list(_places(data, MAGIC))
            parts = [data[a:b] for a, b in zip(starts, [*starts[1:], len(data)], strict=True)]
            if not parts:
                raise ValueError("no log header in it")
            number = _only(path, parts) if number is None else number
            if not 1 <= number <= len(parts):
                raise ValueError(f"it holds {len(parts)} log{'s' if len(parts) != 1 else ''}, no number {number}")
            header, main, slow, counts, _ = _decoded(parts[number - 1])
        from infotraj.importing.blackbox_frames import DAMAGED, ENDED, SKIPPED

        damage = int(counts[DAMAGED] + counts[SKIPPED])
        if damage and len(main) < 2 and not allow_damaged:
            raise InputError(
                problem(f"{path}: {len(main)} whole frames beside {damage} damaged stretches", _EXPECTED, _REMEDY)
            )
        if damage:
            self.notes.append(
                f"{int(counts[DAMAGED])} damaged stretches; {len(main)} main frames read, those between a stretch and "
                f"the next complete frame left out, and {int(counts[SKIPPED])} more whose count or time leapt"
            )
        if not counts[ENDED]:
            self.notes.append("no end mark: the flight controller lost power, or its memory was full")
        self.header = header
        self._main = {name: main[:, k] for k, name in enumerate(header.names["I"])}
        self._main["time"] = _running(self._main["time"])
        self._main.update(_physical(header, self._main, self.notes))
        self._slow = {name: slow[:, k] for k, name in enumerate(header.names["S"])}
        self._slow["time"] = _times_of(slow, self._main["time"])
        if "flightModeFlags" in self._slow:
            self._slow["armed"] = self._slow["flightModeFlags"] & 1
        if not len(main):
            self._slow = {name: column[:0] for name, column in self._slow.items()}
        self.topics = [Topic("main", messages=len(main)), Topic("slow", messages=len(self._slow["time"]))]

    def close(self) -> None:
        """Nothing is held open."""

    def has(self, topic: Topic, name: str) -> bool:
        """True where the frames have the field."""
        return name.replace("*", "0") in self._fields(topic)

    def first(self, topic: Topic, name: str) -> Any:
        """The field in the first frame."""
        column = self._fields(topic).get(name)
        return column[0].item() if column is not None and len(column) else None

    def read(self, requests: list[Request]) -> list[Samples]:
        """The asked fields as doubles."""
        found = []
        for request in requests:
            fields = self._fields(request.topic)
            numbers: dict[str, Array] = {}
            for name in request.numbers:
                group = [fields[n] for n in _counted(fields, name)] if "*" in name else [fields[name]]
                numbers[name] = np.stack(group, axis=-1).astype(float) if "*" in name else group[0].astype(float)
            found.append(Samples(None, {t: fields[t].astype(np.int64) for t in request.times}, numbers))
        return found

    def _fields(self, topic: Topic) -> dict[str, Any]:
        return self._main if topic.name == "main" else self._slow


def _places(data: bytes, wanted: bytes) -> Any:
    place = data.find(wanted)
    while place >= 0:
        yield place
        place = data.find(wanted, place + 1)


def _decoded(part: bytes) -> tuple[Header, Any, Any, Any, Any]:
    from infotraj.importing.blackbox_frames import decode

    header, start = parse_header(part)
    motors = [k for k, name in enumerate(header.names["I"]) if name == "motor[0]"]
    known = [header.number(n) for n in ("minthrottle", "vbatref", "motorOutput")] + [motors[0] if motors else -1, 0]
    interval = [max(header.number("I interval", 1.0), 1.0), *_every(header.values.get("P interval", "1/1"))]
    main, slow, _, events, counts = decode(
        np.frombuffer(part, dtype=np.uint8)[start:],
        header.coding["I"],
        header.coding["P"],
        header.coding["S"],
        header.coding["G"],
        header.coding["H"],
        np.array(known, dtype=np.int64),
        np.array(interval, dtype=np.int64),
        int(header.number("Data version", 2.0)),
    )
    return header, main, slow, counts, events


def _every(text: str) -> tuple[int, int]:
    """How many of how many loops are logged: `1/2`, or 16 for one of sixteen."""
    first, mark, second = text.partition("/")
    try:
        pair = (int(first), int(second)) if mark else (1, int(first))
    except ValueError:
        return 1, 1
    return pair if 0 < pair[0] <= pair[1] else (1, 1)


def _only(path: Path, parts: list[bytes]) -> int:
    """The number of the only log with frames in it. InputError, listing them, where there are several."""
    if len(parts) == 1:
        return 1
    lasting = {}
    for k, part in enumerate(parts):
        try:
            header, main, _, _, _ = _decoded(part)
        except ValueError:
            continue
        if len(main) > 1:
            time = _running(main[:, header.names["I"].index("time")])
            lasting[k + 1] = float(time[-1] - time[0]) / 1e6
    if len(lasting) == 1:
        return next(iter(lasting))
    longest = sorted(lasting, key=lambda k: -lasting[k])
    said = ", ".join(f"{path.name}#{k} ({lasting[k]:.1f} s)" for k in longest[:_SHOWN])
    raise InputError(
        problem(
            f"{path}: holds {len(parts)} logs, {len(lasting)} of them with frames; the longest: {said or 'none'}",
            "one log, named by its number",
            f"Give it as {path}#{longest[0] if longest else 1}.",
        )
    )


def _running(time: Any) -> Any:
    """us that do not start again at 2^32, as the firmware's do after 71 minutes."""
    return time + np.cumsum(np.diff(time, prepend=time[:1]) < -(2**31)) * 2**32


def _times_of(rows: Any, time: Any) -> Any:
    return time[np.minimum(rows[:, -1], len(time) - 1)] if len(time) else np.zeros(len(rows), dtype=np.int64)


def _physical(header: Header, main: dict[str, Any], notes: list[str]) -> dict[str, Any]:
    """The fields whose unit the header gives, in that unit; a field without one is taken out, and noted."""
    out: dict[str, Any] = {}
    units = {"gyroADC": header.gyro_unit, "gyroUnfilt": header.gyro_unit, "vbatLatest": header.battery_unit}
    units["accSmooth"] = 1.0 / header.number("acc_1G") if header.number("acc_1G") > 0 else None
    for name, unit in units.items():
        there = [n for n in main if n == name or n.startswith(f"{name}[")]
        if unit is None:
            for n in there:
                del main[n]
            if there:
                notes.append(f"{name} left out: the header does not give its unit")
        else:
            out.update({n: main[n] * unit for n in there})
    low, high = (48.0, 2047.0) if header.digital_motors else (1000.0, 2000.0)
    for k, name in enumerate(_counted(main, "motor[*]")):
        # below the range stands 0, and what else stops a motor
        out[f"throttle[{k}]"] = np.maximum(main[name] - low, 0.0) / (high - low)
    poles = header.number("motor_poles")
    if poles >= 2:
        for k, name in enumerate(_counted(main, "eRPM[*]")):
            out[f"rpm[{k}]"] = main[name] * 100.0 * 2.0 / poles
    vector = [f"imuQuaternion[{k}]" for k in range(3)]
    if all(n in main for n in vector):
        xyz = np.stack([main[n] for n in vector], axis=-1) / 32767.0
        w = np.sqrt(np.maximum(1.0 - (xyz**2).sum(axis=-1), 0.0))
        q = np.column_stack([w, xyz])
        out.update({f"attitude[{k}]": q[:, k] for k in range(4)})
    return out


def _counted(fields: dict[str, Any], name: str) -> list[str]:
    group: list[str] = []
    while name.replace("*", str(len(group))) in fields:
        group.append(name.replace("*", str(len(group))))
    return group
