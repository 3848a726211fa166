"""The messages of an ArduPilot DataFlash log, binary (.BIN) or as text (.log), by name and column.

Format: ArduPilot developer documentation, "Log messages" and "Binary log format": a message is 0xA3 0x95, its kind, and
packed numbers; messages of kind 128 (FMT) give the other kinds' name, length, letters and columns.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from infotraj.progress import reached

HEAD = b"\xa3\x95"
FORMAT_KIND, FORMAT_LENGTH = 128, 89
_EVERY = 1000  # lines, of which who waits is told
# Letter: numpy type, and what a count stands for.
_LETTERS: dict[str, tuple[str, float]] = {
    "a": ("S64", 1.0),
    "b": ("i1", 1.0),
    "B": ("u1", 1.0),
    "c": ("<i2", 0.01),
    "C": ("<u2", 0.01),
    "d": ("<f8", 1.0),
    "e": ("<i4", 0.01),
    "E": ("<u4", 0.01),
    "f": ("<f4", 1.0),
    "g": ("<f2", 1.0),
    "h": ("<i2", 1.0),
    "H": ("<u2", 1.0),
    "i": ("<i4", 1.0),
    "I": ("<u4", 1.0),
    "L": ("<i4", 1e-7),
    "M": ("u1", 1.0),
    "n": ("S4", 1.0),
    "N": ("S16", 1.0),
    "q": ("<i8", 1.0),
    "Q": ("<u8", 1.0),
    "Z": ("S64", 1.0),
}


@dataclass(frozen=True)
class Format:
    """One kind of message: its letters (types) and columns."""

    kind: int
    name: str
    letters: str
    columns: tuple[str, ...]

    @property
    def record(self) -> np.dtype[Any]:
        """The message's bytes behind its head."""
        return np.dtype([(c, _LETTERS[k][0]) for c, k in zip(self.columns, self.letters, strict=True)])


@dataclass
class Messages:
    """A whole log: `columns[name][column]` (n,), numbers in the unit of the column (text as bytes)."""

    columns: dict[str, dict[str, Any]]
    kinds: dict[int, str]
    skipped: int  # bytes or lines that belong to no message; the last one is often cut short, and does not count

    def text(self, name: str, column: str) -> list[str]:
        """A column of text."""
        found = self.columns.get(name, {}).get(column)
        return [] if found is None else [bytes(v).split(b"\0")[0].decode("utf-8", "replace") for v in found]


def read_binary(data: bytes) -> Messages:
    """Every message of a binary log. ValueError where it has no formats."""
    raw = np.frombuffer(data, dtype=np.uint8)
    lengths = np.zeros(256, dtype=np.int64)
    lengths[FORMAT_KIND] = FORMAT_LENGTH
    offsets, kinds, skipped = _walk(raw, lengths)
    formats: dict[int, Format] = {}
    for place in offsets[kinds == FORMAT_KIND]:
        found = _format(data[place + 3 : place + FORMAT_LENGTH])
        if found is not None:
            formats[found.kind] = found
    if not formats:
        raise ValueError("it has no message formats")
    columns: dict[str, dict[str, Any]] = {}
    for kind, form in formats.items():
        places, record = offsets[kinds == kind] + 3, form.record
        if form.name in columns and not places.size:
            continue
        packed = np.ascontiguousarray(raw[places[:, None] + np.arange(record.itemsize)]).view(record)[:, 0]
        columns[form.name] = {
            c: _scaled(packed[c], letter) for c, letter in zip(form.columns, form.letters, strict=True)
        }
    return Messages(columns, {k: f.name for k, f in formats.items()}, int(skipped))


def read_text(text: str) -> Messages:
    """Every message of a log as text: `NAME, value, value`, where FMT lines give the columns."""
    formats: dict[str, tuple[str, tuple[str, ...]]] = {}
    kinds: dict[int, str] = {}
    rows: dict[str, list[list[str]]] = {}
    skipped = 0
    lines = text.splitlines()
    for number, line in enumerate(lines):
        if number % _EVERY == 0:
            reached("reading", number, 2 * len(lines))
        parts = [p.strip() for p in line.split(",")]
        if parts[0] == "FMT" and len(parts) > 5:
            letters, columns = parts[4], tuple(parts[5:])
            if len(letters) == len(columns) and set(letters) <= set(_LETTERS) and parts[1].isdigit():
                formats[parts[3]] = (letters, columns)
                kinds[int(parts[1])] = parts[3]
        elif parts[0] in formats and len(parts) - 1 >= len(formats[parts[0]][1]):
            rows.setdefault(parts[0], []).append(parts[1 : len(formats[parts[0]][1]) + 1])
        elif line.strip():
            skipped += 1
    columns_of: dict[str, dict[str, Any]] = {}
    done = 0  # messages whose cells are numbers
    for name, (letters, columns) in formats.items():
        reached("reading", len(lines) + done, 2 * len(lines))
        kept = rows.get(name, [])
        done += len(kept)
        columns_of[name] = {}
        for k, (column, letter) in enumerate(zip(columns, letters, strict=True)):
            cells = [row[k] for row in kept]
            if letter in "anNZ":
                columns_of[name][column] = np.array([c.encode() for c in cells], dtype="S64")
            else:
                columns_of[name][column] = _parsed(cells, whole=letter in "qQ")
    if not formats:
        raise ValueError("it has no message formats")
    return Messages(columns_of, kinds, skipped)


def _parsed(cells: list[str], whole: bool) -> Any:
    values = np.full(len(cells), np.nan)
    for k, cell in enumerate(cells):
        try:
            values[k] = float(cell)
        except ValueError:
            continue
    return values if not whole or not np.isfinite(values).all() else values.astype(np.int64)


def _format(payload: bytes) -> Format | None:
    kind, length = payload[0], payload[1]
    name, letters, columns = (
        part.split(b"\0")[0].decode("ascii", "replace") for part in (payload[2:6], payload[6:22], payload[22:86])
    )
    names = tuple(c.strip() for c in columns.split(","))
    if len(names) != len(letters) or len(set(names)) != len(names) or not set(letters) <= set(_LETTERS):
        return None
    found = Format(kind, name, letters, names)
    return found if found.record.itemsize + 3 == length and "" not in names else None


def _scaled(values: Any, letter: str) -> Any:
    unit = _LETTERS[letter][1]
    if unit != 1.0:
        return values * unit
    return values.astype(np.int64) if letter in "qQ" else values


@njit(cache=True)
def _walk(data: Any, lengths: Any) -> Any:
    """(offsets, kinds, bytes skipped before the last) of all messages; FMT messages fill `lengths` as they come."""
    offsets = np.empty(1024, dtype=np.int64)
    kinds = np.empty(1024, dtype=np.uint8)
    count, place, skipped, before_last = 0, 0, 0, 0
    while place + 3 <= data.size:
        kind = data[place + 2]
        length = lengths[kind]
        if data[place] != 0xA3 or data[place + 1] != 0x95 or length < 3 or place + length > data.size:
            place += 1
            skipped += 1
            continue
        if kind == 128:
            lengths[data[place + 3]] = data[place + 4]
            lengths[128] = 89
        if count == offsets.size:
            more = np.empty(2 * count, dtype=np.int64)
            more[:count] = offsets
            offsets = more
            other = np.empty(2 * count, dtype=np.uint8)
            other[:count] = kinds
            kinds = other
        offsets[count] = place
        kinds[count] = kind
        count += 1
        before_last = skipped
        place += length
    return offsets[:count], kinds[:count], before_last
