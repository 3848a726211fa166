"""One clock for all streams.

Rules. A stream's time is the first of its time fields that is not 0 throughout (a header stamp before the time at which
the logger wrote the message). Streams whose stamps do not overlap with those of the row stream, or that have none, are
put on its clock through the recording times, shifted by the row stream's median delay (and scaled where that clock
runs at another speed, as in simulation). Times are kept as logged while the log starts within 1e8 s of its zero
(boot or simulation time); a clock that counts since 1970 is moved so that the first row is 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from infotraj.errors import InputError, problem
from infotraj.importing import resample
from infotraj.importing.log import Samples
from infotraj.importing.mapping import TimeMap
from infotraj.importing.units import UNITS
from infotraj.rotations import Array
from infotraj.suggested import quoted

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
                whole = 1 if name.endswith(".stamp") else whole
                if np.abs(raw.astype(float)).max() * whole < 2.0**63:  # beyond, no clock has this unit: `tidy` says so
                    return Ticks(raw * whole, name, samples.record)
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


def late(rows: Ticks, other: Ticks) -> float:
    """s by which a stream's stamps are later than those of the rows, by the times of recording; 0 where these do not
    tell: stamps of another source, or a clock that runs at another speed."""
    if rows.record is None or other.record is None or rows.source != other.source or rows.source == "record":
        return 0.0
    own, of_rows = _Line(other.record, other.values), _Line(rows.record, rows.values)
    return of_rows.delay - own.delay if own.even and of_rows.even else 0.0


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

    @property
    def even(self) -> bool:
        """Whether both clocks run at one speed."""
        return self._slope == 1.0

    def __call__(self, record: Any) -> Any:
        if self.even:
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
    back = np.maximum.accumulate(t)[:-1] - t[1:] if t.size else np.zeros(0)
    if (back > 0).any():
        breaks = np.flatnonzero(back > (_REORDER_S if may_reorder else 0.0))
        if breaks.size:
            k = int(breaks[0])
            last = float(t[: k + 1].max())
            raise InputError(
                problem(
                    f"{log}: time goes back by {back[k]:.6g} s in sample {k + 1}, t = {last:.6g}",
                    "time that runs forward",
                    f"Cut the log there with --to {_after(last, t[: k + 1])}.",
                )
            )
        order = np.argsort(t, kind="stable")
        late = int((np.diff(t) < 0).sum())
        notes.append(f"{label}: {late} samples were out of order by up to {back.max():.3g} s; sorted")
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
    step = np.diff(ordered)
    usual = float(np.median(step)) if step.size else 0.0
    unit = next((u for u in ("us", "ns") if usual * UNITS["time"][u][0] < 1.0), None)
    if usual > _LONGEST_STEP_S and unit is not None:
        remedy = f"infotraj import {quoted(path)} --set time.unit={unit} -o NEW.parquet"
        raise InputError(problem(f"{log}: rows are {usual:.4g} s apart", "a time in s", remedy))
    jumps = np.flatnonzero(step > _LONGEST_STEP_S)
    if jumps.size:
        k = int(jumps[0])
        places = f"--to {_after(ordered[k], ordered[: k + 1])}, or behind it with --from {_digits(ordered[k + 1])}"
        raise InputError(
            problem(
                f"{log}: time jumps by {step[k]:.6g} s after t = {ordered[k]:.6g} s",
                f"steps below {_LONGEST_STEP_S:.0f} s",
                f"Cut the log there with {places}.",
            )
        )
    return order


def stamped(ticks: Ticks) -> Any:
    """(n,) False where a message of a bag has no stamp: a 0 that is not where the others put it.

    It is after later times, or further before the first one than a clock may jump.
    """
    has = np.ones(ticks.values.size, dtype=bool)
    others = ticks.values[ticks.values != 0]
    if ticks.record is None or not others.size or others.size == has.size:
        return has
    far = others.min() > _LONGEST_STEP_S * (1e9 if ticks.nanoseconds else 1.0)
    later = np.append(False, np.maximum.accumulate(ticks.values)[:-1] > 0)
    return (ticks.values != 0) | ~(far | later)


def within(t: Array, start: float | None, stop: float | None, may_reorder: bool) -> Any:
    """Indices of the samples with start <= t < stop, and of one more on each side to interpolate from.

    A clock that is set back, or jumps by more than an hour, parts the log. Of these parts only those are looked at
    that the cut reaches: the sample to interpolate from never lies beyond a break. The first of them is all that counts
    where it comes up to `stop`, or short of it by no more than a gap: the log may be cut at the break.
    """
    everything = np.arange(t.size)
    if (start is None and stop is None) or not t.size:
        return everything
    low, high = (-np.inf if start is None else start), (np.inf if stop is None else stop)
    step = np.diff(t)
    broken = (step < (-_REORDER_S if may_reorder else 0.0)) | (step > _LONGEST_STEP_S)
    parts = np.split(everything, np.flatnonzero(broken) + 1)
    first, last = ([float(reduce(t[p])) for p in parts] for reduce in (np.fmin.reduce, np.fmax.reduce))
    reached = [p for p, a, b in zip(parts, first, last, strict=True) if a < high and b >= low]
    if not reached:
        # a value that is held from before the cut still counts
        reached = [p for p, a in zip(parts, first, strict=True) if a < high][-1:] or parts[:1]
    known = np.unique(t[reached[0]][np.isfinite(t[reached[0]])])
    if known.size > 1 and known[-1] >= high - resample.gap_limit(known):
        reached = reached[:1]
    keep = np.arange(reached[0][0], reached[-1][-1] + 1)
    if len(reached) > 1:
        return keep
    if (t[keep] >= high).any():
        keep = keep[: int(np.argmax(t[keep] >= high)) + 1]
    if (t[keep] < low).any():
        keep = keep[int(np.flatnonzero(t[keep] < low)[-1]) :]
    return keep


def _after(last: float, before: Array) -> str:
    """A time just behind the last sample of what stands before a break."""
    known = np.unique(before)
    return _digits(last + (float(np.median(np.diff(known))) if known.size > 1 else 1e-3))


def _digits(t: float) -> str:
    return f"{t:.6f}".rstrip("0").rstrip(".")
