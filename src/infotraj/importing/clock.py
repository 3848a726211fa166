"""One clock for all streams.

Rules. A stream's time is the first of its time fields that is not 0 throughout (a header stamp before the time at which
the logger wrote the message). Streams whose stamps do not overlap with those of the row stream, or that have none, are
put on its clock through the recording times, shifted by the row stream's median delay (and scaled where that clock
runs at another speed, as in simulation). Times are kept as logged while the log starts within 1e8 s of its zero
(boot or simulation time); a clock that counts since 1970 is moved so that the first row is 0.
"""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from infotraj.errors import InputError, problem
from infotraj.importing.log import Samples
from infotraj.importing.mapping import TimeMap
from infotraj.importing.units import UNITS
from infotraj.rotations import Array

_EPOCH_S = 1e8
_LONGEST_STEP_S = 3600.0
# Transports deliver out of order by milliseconds; a clock that was set back jumps further.
_REORDER_S = 0.05
# More repeated stamps than this are no repeated messages but a clock that was set back, or one of too few digits.
_REPEATED_SHARE = 0.2


@dataclass
class Ticks:
    """A stream's raw clock: int64 ns or float64 s, which field it came from, and when the messages were recorded."""

    values: Any
    source: str
    record: Any = None

    @property
    def nanoseconds(self) -> bool:
        """True for whole ns."""
        return bool(np.issubdtype(self.values.dtype, np.integer))


def ticks(samples: Samples, declared: TimeMap) -> Ticks:
    """The stream's clock by the first rule."""
    for name in declared.fields:
        if name == "record":
            return Ticks(samples.record, "record", samples.record)
        raw = samples.times[name]
        if raw.size and not (raw == 0).all():
            if np.issubdtype(raw.dtype, np.integer):
                whole = {"s": 1_000_000_000, "ms": 1_000_000, "us": 1_000, "ns": 1}[declared.unit]
                return Ticks(raw * (1 if name.endswith(".stamp") else whole), name, samples.record)
            with np.errstate(invalid="ignore"):  # a damaged number may be a signalling NaN
                return Ticks(raw * UNITS["time"][declared.unit][0], name, samples.record)
    if samples.record is not None:
        return Ticks(samples.record, "record", samples.record)
    name = declared.fields[0]
    return Ticks(samples.times[name], name, None)


def align(rows: Ticks, others: dict[str, Ticks], notes: list[str]) -> None:
    """Puts every stream of a bag on the clock of `rows`, by the second rule; in place, noting what was moved."""
    for name, other in others.items():
        if other is rows or other.record is None or rows.record is None:
            continue
        if other.source != rows.source and "record" in (other.source, rows.source):
            if rows.source == "record":
                other.values, other.source = other.record, "record"
                notes.append(f"{name}: recording times are used, because the row stream has no stamps")
            else:
                line = _Line(rows.record, rows.values)
                _move(other, line, other.record)
                notes.append(f"{name}: it has no stamps; recording times less {line.delay:.4f} s are used")
        elif other.source != "record" and not _overlap(rows.values, other.values):
            line = _Line(rows.record, rows.values)
            own = _Line(other.record, other.values)
            _move(other, line, other.values + np.int64(round(own.delay * 1e9)))
            notes.append(
                f"{name}: its stamps are of another clock ({own.delay - line.delay:.3f} s apart); "
                "it was moved by the recording times"
            )


class _Line:
    """Stamp as a function of recording time: less the median delay, and scaled where the clocks' speeds differ."""

    def __init__(self, record: Any, stamp: Any) -> None:
        self._record, self._stamp = record, stamp
        self.delay = float(np.median((record - stamp).astype(float))) / 1e9 if record.size else 0.0
        self._slope = 1.0
        if record.size >= 10 and record[-1] > record[0]:
            x = (record - record[0]).astype(float)
            y = (stamp - stamp[0]).astype(float)
            slope, _ = np.polyfit(x, y, 1)
            self._slope = float(slope) if abs(slope - 1.0) > 1e-3 else 1.0

    def __call__(self, record: Any) -> Any:
        if self._slope == 1.0:
            return record - np.int64(round(self.delay * 1e9))
        middle = self._record.size // 2
        return self._stamp[middle] + ((record - self._record[middle]) * self._slope).astype(np.int64)


def _move(other: Ticks, line: _Line, record: Any) -> None:
    other.values = line(record)
    other.source = f"{other.source} (moved)"


def _overlap(a: Any, b: Any) -> bool:
    if not a.size or not b.size:
        return True
    shared = min(int(a.max()), int(b.max())) - max(int(a.min()), int(b.min()))
    shortest = min(int(a.max()) - int(a.min()), int(b.max()) - int(b.min()))
    return shared >= 0.1 * shortest


def origin(rows: Ticks) -> Any:
    """What is subtracted from every clock by the third rule: 0, or the first row's time, in the clock's own unit."""
    if not rows.values.size:
        return rows.values.dtype.type(0)
    first = rows.values[0]
    start_s = float(first) / 1e9 if rows.nanoseconds else float(first)
    return first if np.isfinite(start_s) and abs(start_s) > _EPOCH_S else rows.values.dtype.type(0)


def seconds(clock: Ticks, zero: Any) -> Array:
    """Times (n,) in s from the origin; the subtraction is done in whole ns where the clock has them."""
    moved = clock.values - zero
    return moved.astype(float) / 1e9 if clock.nanoseconds else moved.astype(float)


def tidy(t: Array, label: str, path: Path, may_reorder: bool, notes: list[str]) -> Any:
    """Indices that make t strictly increasing: small reorderings sorted, repeated stamps dropped, both noted.

    InputError where a time is no number, goes back, or jumps by more than an hour.
    """
    log = str(path) if label == path.name else f"{path}: {label}"
    bad = np.flatnonzero(~np.isfinite(t))
    if bad.size:
        raise InputError(
            problem(f"{log}: time is not a number in sample {bad[0]}", "a finite time in all", "Remove it.")
        )
    order = np.arange(t.size)
    step = np.diff(t)
    if t.size and (step < 0).any():
        lag = np.maximum.accumulate(t)[:-1] - t[1:]
        worst = int(np.argmax(lag))
        if not may_reorder or lag[worst] > _REORDER_S:
            raise InputError(
                problem(
                    f"{log}: time goes back by {lag[worst]:.6g} s in sample {worst + 1}, t = {t[worst]:.6g}",
                    "time that runs forward",
                    "Cut the log there with --from/--to.",
                )
            )
        order = np.argsort(t, kind="stable")
        notes.append(f"{label}: {int((step < 0).sum())} samples were out of order by up to {lag[worst]:.3g} s; sorted")
    ordered = t[order]
    new = np.ones(t.size, dtype=bool)
    new[1:] = np.diff(ordered) > 0
    if (~new).sum() > _REPEATED_SHARE * t.size:
        raise InputError(
            problem(
                f"{log}: {int((~new).sum())} of {t.size} samples repeat the time of the one before",
                "time that advances",
                "The clock was set back or is too coarse: name another time field in a mapping.",
            )
        )
    if not new.all():
        notes.append(f"{label}: {int((~new).sum())} samples repeat the time of the one before and are left out")
        order = order[new]
        ordered = ordered[new]
    jump = int(np.argmax(np.diff(ordered))) if ordered.size > 1 else 0
    width = float(ordered[jump + 1] - ordered[jump]) if ordered.size > 1 else 0.0
    usual = float(np.median(np.diff(ordered))) if ordered.size > 1 else 0.0
    unit = next((u for u in ("us", "ns") if usual * UNITS["time"][u][0] < 1.0), None)
    if usual > _LONGEST_STEP_S and unit is not None:
        remedy = f"infotraj import {shlex.quote(str(path))} --set time.unit={unit} -o NEW.parquet"
        raise InputError(problem(f"{log}: rows are {usual:.4g} s apart", "a time in s", remedy))
    if width > _LONGEST_STEP_S:
        raise InputError(
            problem(
                f"{log}: time jumps by {width:.6g} s after t = {ordered[jump]:.6g} s",
                f"steps below {_LONGEST_STEP_S:.0f} s",
                "Cut the log there with --from/--to.",
            )
        )
    return order
