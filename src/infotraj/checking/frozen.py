"""Streams that died and were filled in: straight lines where a sensor should be, and values that stand still.

A logger that puts streams on one clock interpolates over what it did not receive; after the last sample it
extrapolates. No sensor and no controller in flight draws a straight line to the last bit for half a second.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from infotraj.checking.finding import Finding, Span, spans_text
from infotraj.checking.held import Held, measured_groups, repeat_chance
from infotraj.checking.streams import runs
from infotraj.flight import COMMANDED_WRENCH, POSITION, VELOCITY, Flight
from infotraj.rotations import Array, Mask

SHORTEST = 0.5
# A stream that arrives slower than the rows is interpolated in between by design; a death is far longer than that.
TIMES_USUAL = 10
# Losing less than this share of the flight leaves the log as good as it was, apart from the rows themselves.
SMALL_SHARE = 0.15
# Straight within the rounding of single precision, in which most loggers store.
ROUNDING = 1e-6
# Times the rounding that a whole stretch may be off its chord: both ends are rounded, too.
_ENDS = 4.0
# Odds (natural logarithm) against equal samples by chance; a channel that repeats so often by itself is coarse, and a
# change by so many of its smallest steps is a jump.
SURE = 16.0
COARSE = 0.2
JUMP = 3.0


@dataclass(frozen=True)
class Dead:
    """Rows (n,) in which a group of columns (one stream) is a straight line or stands still."""

    columns: tuple[str, ...]
    rows: Mask


def stream_groups(flight: Flight) -> list[tuple[str, ...]]:
    """Columns that come from one stream, by name; references and the battery are left out: they may well be
    straight."""
    found = measured_groups(flight)
    if flight.has(*COMMANDED_WRENCH):
        found.append(COMMANDED_WRENCH)
    for prefix in ("cmd_rotor_", "cmd_tilt_"):
        count = flight.numbered(prefix).shape[1]
        if count:
            found.append(tuple(f"{prefix}{k}" for k in range(count)))
    return found


def straight_streams(flight: Flight) -> list[Dead]:
    """Streams whose columns all run straight (and not all level) for longer than SHORTEST, stream by stream."""
    found = []
    for columns in stream_groups(flight):
        x = flight.get(*columns)
        good = np.isfinite(x).all(axis=1)
        if good.sum() < 20:
            continue
        t = flight.t[good]
        rows = np.zeros(len(flight.table), dtype=bool)
        straight, level = _straight(t, x[good])
        where = np.flatnonzero(good)
        for a, b in _long(t, straight & ~level):
            if columns == POSITION and _moves_so(flight, where[a], where[b - 1]):
                continue
            if not _one_line(t[a - 1 : b + 1], x[good][a - 1 : b + 1]):
                continue
            # the last sample has no neighbour to be measured by: it belongs to the line that leads to it
            last = len(where) - 1 if b == len(where) - 1 else b - 1
            rows[where[a] : where[last] + 1] = True
        if rows.any():
            found.append(Dead(columns, rows))
    return found


def still_streams(flight: Flight, airborne: Mask, held: Sequence[Held] = ()) -> list[Dead]:
    """Measured streams that stand still in flight, to the last bit, while they move in the rest of it.

    A held stream stands still between its samples by design: for it the time counts in its own samples. A coarse
    channel may rest on one value for long: there the value must also have moved on by several of its steps afterwards.
    """
    period = {h.columns: h.period for h in held if h.always}
    found = []
    groups = stream_groups(flight)
    for columns in measured_groups(flight):
        x = flight.get(*columns)
        good = np.isfinite(x).all(axis=1)
        if good.sum() < 20:
            continue
        t, where, x = flight.t[good], np.flatnonzero(good), x[good]
        same = (np.diff(x, axis=0) == 0).all(axis=1)
        if same.all():
            continue
        shortest = max(SHORTEST, TIMES_USUAL * period.get(columns, 0.0))
        chance = repeat_chance(x)
        rows = np.zeros(len(flight.table), dtype=bool)
        for a, b in runs(same & airborne[good][1:]):
            # steps a..b-1 are equal: samples a..b
            if t[b] - t[a] >= shortest and _beyond_rest(x, chance, a, b):
                rows[where[a] : where[b] + 1] = True
        if rows.any() and not _all_still(flight, rows, columns, groups):
            found.append(Dead(columns, rows))
    return found


def beyond_still(held: Sequence[Held], still: Sequence[Dead]) -> list[Held]:
    """The held streams without the rows in which the stream stands still altogether: those are named by that."""
    frozen = {d.columns: d.rows for d in still}
    return [replace(h, rows=h.rows & ~frozen[h.columns]) if h.columns in frozen else h for h in held]


def dead_findings(flight: Flight, dead: list[Dead], airborne: Mask, kind: str) -> list[Finding]:
    """One finding for all streams that died together; a cut where it costs more than SMALL_SHARE of the flight."""
    if not dead:
        return []
    t = flight.t
    rows = np.any([d.rows for d in dead], axis=0)
    spans: tuple[Span, ...] = tuple((float(t[a]), float(t[b - 1])) for a, b in runs(rows))
    hit = rows & airborne if airborne.any() else rows
    share = float(hit.sum() / max(airborne.sum(), 1))
    columns = tuple(c for d in dead for c in d.columns)
    many = share > SMALL_SHARE
    seconds = sum(b - a for a, b in spans)
    how = "run on straight lines" if kind == "straight" else "stand still"
    return [
        Finding(
            "dead_stream" if kind == "straight" else "stuck",
            "cut" if many else "note",
            f"{_brief(columns)} {how} to the last bit for {seconds:.1f} s ({spans_text(spans)})",
            "the values there were never measured: they were "
            + ("interpolated or extrapolated by the logger" if kind == "straight" else "repeated"),
            "use the rows outside these times" if many else "leave these rows out",
            spans=spans,
            channels=columns,
            values={"share_of_flight": share, "seconds": seconds},
            drop=True,
        )
    ]


def _straight(t: Array, x: Array) -> tuple[Mask, Mask]:
    # a row is straight when every column lies on the chord of its two neighbours
    left, right = np.diff(t)[:-1, None], np.diff(t)[1:, None]
    chord = (x[:-2] * right + x[2:] * left) / (left + right)
    size = np.maximum.reduce([np.abs(x[:-2]), np.abs(x[1:-1]), np.abs(x[2:])])
    tolerance = _tolerance(size)
    on = np.zeros(len(x), dtype=bool)
    on[1:-1] = (np.abs(x[1:-1] - chord) <= tolerance).all(axis=1)
    level = np.zeros(len(x), dtype=bool)
    level[1:-1] = (np.abs(x[2:] - x[:-2]) <= tolerance).all(axis=1)
    return on, level


def _one_line(t: Array, x: Array) -> bool:
    """Whether a stretch is one straight line from end to end: one that bends by less than the rounding from row to row,
    as smooth commands of a controller without noise do, is far off its chord in the middle."""
    chord = x[0] + np.outer((t - t[0]) / (t[-1] - t[0]), x[-1] - x[0])
    return bool((np.abs(x - chord) <= _ENDS * _tolerance(np.abs(x).max(axis=0))).all())


def _tolerance(size: Array) -> Array:
    return ROUNDING * size + 1e-9


def _long(t: Array, mask: Mask) -> list[tuple[int, int]]:
    found = runs(mask)
    if not found:
        return []
    length = np.array([t[b - 1] - t[a] for a, b in found])
    usual = np.median(length) if len(found) > 20 else 0.0
    limit = max(SHORTEST, TIMES_USUAL * usual)
    return [run for run, seconds in zip(found, length, strict=True) if seconds >= limit]


def _beyond_rest(x: Array, chance: float, a: int, b: int) -> bool:
    """Whether equal samples a..b are more than a coarse channel at rest: chance does not repeat so often, or the next
    sample is several of the channel's own steps away."""
    if np.isnan(chance) or (b - a) * np.log(1 / chance) < SURE:
        return bool(np.isnan(chance))
    if chance < COARSE or b + 1 >= len(x):
        return True
    size = np.abs(np.diff(x, axis=0))
    smallest = np.array([s[s > 0].min() if (s > 0).any() else np.inf for s in size.T])
    return bool((np.abs(x[b + 1] - x[b]) > JUMP * smallest).any())


def _moves_so(flight: Flight, first: int, last: int) -> bool:
    # a vehicle that truly flies straight at constant speed has a velocity that says so
    if not flight.has(*VELOCITY):
        return False
    t, p, v = flight.t, flight.get(*POSITION), flight.get(*VELOCITY)[first : last + 1]
    slope = (p[last] - p[first]) / (t[last] - t[first])
    return bool(np.nanmax(np.abs(v - slope)) < 0.02 * np.linalg.norm(slope) + 1e-6)


def _all_still(flight: Flight, rows: Mask, columns: tuple[str, ...], groups: list[tuple[str, ...]]) -> bool:
    # a simulation without noise may truly stand still: then nothing else moves either
    rest = [g for g in groups if g != columns]
    if not rest:
        return False
    sampled = [x[np.isfinite(x).all(axis=1)] for x in (flight.get(*g)[rows] for g in rest)]
    spread = [float(np.ptp(x, axis=0).max()) for x in sampled if len(x)]
    return bool(spread) and max(spread) < 1e-6


def _brief(columns: tuple[str, ...]) -> str:
    shown = ", ".join(columns[:6])
    return shown if len(columns) <= 6 else f"{shown} and {len(columns) - 6} more"
