"""From a log to a flight table: read what a mapping names, put it on one clock, derive what follows, say how."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from infotraj.errors import InputError, problem
from infotraj.flight import Flight
from infotraj.importing import clock, convert, derive, resample
from infotraj.importing.channels import CHANNELS, Resample
from infotraj.importing.log import Log, Request
from infotraj.importing.mapping import Mapping, load_mapping, shipped
from infotraj.importing.metadata import channel_origin, table_metadata
from infotraj.importing.opening import kind_of, open_log
from infotraj.importing.plausible import require_plausible
from infotraj.importing.recognise import choose
from infotraj.importing.streams import Feed, Plan, plan, require_channels
from infotraj.rotations import Array


@dataclass
class Stream:
    """One stream as read: `t` (n,) s on the log's common clock, channels (n, k) in SI and in the table's axes.

    Not yet tidied: time may repeat, go back or have gaps, exactly as logged. `resolved` is False where a vector is
    still in its logged axes because the log has no attitude to turn it with.
    """

    name: str
    topic: str
    t: Array
    channels: dict[str, Array]
    time_source: str
    delay: float | None
    feed: Feed
    resolved: dict[str, bool] = field(default_factory=dict)

    @property
    def limit(self) -> float:
        """Longest step (s) that is no gap."""
        return self.feed.stream.max_gap or resample.gap_limit(np.unique(self.t[np.isfinite(self.t)]))


@dataclass
class Streams:
    """Everything that a mapping finds in a log, before it is put on one clock."""

    path: Path
    kind: str
    mapping: Mapping
    plan: Plan
    streams: dict[str, Stream]
    zero: float
    notes: list[str]


def import_log(
    path: str | Path,
    mapping: Mapping | str | Path | None = None,
    *,
    start: float | None = None,
    stop: float | None = None,
    definitions: tuple[Path, ...] = (),
    allow_damaged: bool = False,
    rows: str | None = None,
) -> Flight:
    """A log as a flight table (SI, world z up, body x forward y left z up).

    mapping: a Mapping, the name of a shipped one, the path of a mapping file, or None to choose by looking at the log.
    start, stop: s, on the table's t; start <= t < stop. definitions: message definitions that a bag lacks.
    rows: a channel whose samples make the rows, or a rate in Hz; default: as the mapping says.
    InputError where the log cannot be used, UsageError where the mapping is wrong.
    """
    path = Path(path)
    read = read_streams(path, mapping, definitions=definitions, allow_damaged=allow_damaged)
    return to_flight(read, start=start, stop=stop, rows=rows)


def read_streams(
    path: str | Path,
    mapping: Mapping | str | Path | None = None,
    *,
    definitions: tuple[Path, ...] = (),
    allow_damaged: bool = False,
    every: bool = False,
) -> Streams:
    """The streams of a log in SI and table axes, timed as logged. `every`: also channels that the table leaves out."""
    path = Path(path)
    with opened(path, mapping, definitions, allow_damaged) as (log, chosen):
        require_channels(chosen, log)
        return _read(log, chosen, every)


@contextmanager
def opened(
    path: Path, mapping: Mapping | str | Path | None, definitions: tuple[Path, ...] = (), allow_damaged: bool = False
) -> Iterator[tuple[Log, Plan]]:
    """The open log with the plan of the given mapping, or of the shipped one that fits best."""
    given = mapping if isinstance(mapping, Mapping) or mapping is None else load_mapping(mapping)
    kind = kind_of(path)
    candidates = [given] if given is not None else [m for m in shipped().values() if kind in m.reads and m.automatic]
    names = frozenset(topic for m in candidates for s in m.streams for topic in (s.topic or ()))
    folders = (*definitions, *(Path(d) for d in given.definitions)) if given is not None else definitions
    log = open_log(path, kind, names, folders, allow_damaged)
    try:
        yield log, (plan(log, given) if given is not None else choose(log, candidates))
    finally:
        log.close()


def _read(log: Log, chosen: Plan, every: bool) -> Streams:
    notes = [*log.notes, *chosen.notes]
    feeds = [f for f in chosen.feeds if every or f.used]
    wanted = {f.stream.name: _wanted(f, every) for f in feeds}
    requests = []
    for feed in feeds:
        mapped = [feed.channels[c] for c in wanted[feed.stream.name]]
        numbers = dict.fromkeys(n for m in mapped for n in (*m.fields, *((m.count,) if m.count else ())))
        times = tuple(t for t in feed.time.fields if t != "record")
        requests.append(Request(feed.topic, tuple(numbers), times))
    samples = log.read(requests)
    all_ticks = {f.stream.name: clock.ticks(s, f.time) for f, s in zip(feeds, samples, strict=True)}
    leader = _leading(chosen)
    delays = {
        name: float(np.median((tick.record - tick.values).astype(float))) / 1e9
        if tick.record is not None and tick.values.size
        else None
        for name, tick in all_ticks.items()
    }
    clock.align(all_ticks[leader.stream.name], all_ticks, notes)
    zero = clock.origin(all_ticks[leader.stream.name])
    streams = {}
    for feed, sample in zip(feeds, samples, strict=True):
        name = feed.stream.name
        channels = {
            c: convert.channel_values(c, feed.channels[c], feed.stream, chosen.mapping, sample) for c in wanted[name]
        }
        tick = all_ticks[name]
        streams[name] = Stream(
            name, feed.topic.name, clock.seconds(tick, zero), channels, tick.source, delays[name], feed
        )
    _turn_vectors(chosen, streams, notes)
    ticks = all_ticks[leader.stream.name]
    start = float(zero) / 1e9 if ticks.nanoseconds else float(zero)
    return Streams(log.path, log.kind, chosen.mapping, chosen, streams, start, notes)


def _wanted(feed: Feed, every: bool) -> list[str]:
    names = list(feed.channels) if every else list(feed.used)
    turned = any(convert.needs_attitude(c, feed.channels[c]) for c in names)
    # A body velocity is turned by the attitude of its own message, whoever gives the table's attitude.
    return [*names, "attitude"] if turned and "attitude" in feed.channels and "attitude" not in names else names


def _leading(chosen: Plan) -> Feed:
    for channel in (*chosen.mapping.clock.channel, *CHANNELS):
        feed = chosen.feed_of(channel)
        if feed is not None:
            return feed
    raise AssertionError("a plan without channels was let through")


def _turn_vectors(chosen: Plan, streams: dict[str, Stream], notes: list[str]) -> None:
    source = chosen.feed_of("attitude")
    for stream in streams.values():
        for name in stream.channels:
            mapped = stream.feed.channels[name]
            if not convert.needs_attitude(name, mapped):
                continue
            q = stream.channels.get("attitude")
            if q is None and source is not None:
                q = _attitude_at(streams[source.stream.name], stream.t)
            stream.resolved[name] = q is not None
            if q is None:
                notes.append(
                    f"{name} left out: it is in {convert.expressed_in(name, mapped)} axes, and the log has no attitude"
                )
            else:
                stream.channels[name] = convert.turn(name, mapped, stream.channels[name], q)


def _attitude_at(stream: Stream, t: Array) -> Array:
    good = np.isfinite(stream.t) & np.isfinite(stream.channels["attitude"]).all(axis=1)
    known, first = np.unique(stream.t[good], return_index=True)
    return resample.put(t, known, stream.channels["attitude"][good][first], "slerp", resample.gap_limit(known))


def to_flight(
    read: Streams, *, start: float | None = None, stop: float | None = None, rows: str | None = None
) -> Flight:
    """The streams on one clock as a flight table. InputError where time runs back or values are impossible."""
    notes = list(read.notes)
    tidied = {name: _tidied(read, stream, start, stop, notes) for name, stream in read.streams.items()}
    t, rule, leader = _rows(read, tidied, rows)
    t = t[(t >= (start if start is not None else -np.inf)) & (t < (stop if stop is not None else np.inf))]
    if t.size < 2:
        raise InputError(
            problem(
                f"{read.path}: {t.size} samples of {leader}" + (" between --from and --to" if start or stop else ""),
                "at least 2",
                "Use a longer log, or another --mapping.",
            )
        )
    values: dict[str, Array] = {}
    names: dict[str, tuple[str, ...]] = {}
    said: dict[str, Any] = {}
    for channel_name in CHANNELS:
        feed = read.plan.feed_of(channel_name)
        if feed is None or not read.streams[feed.stream.name].resolved.get(channel_name, True):
            continue
        stream = tidied[feed.stream.name]
        data, how = _on_rows(channel_name, stream, t)
        if not np.isfinite(data).any():
            notes.append(
                f"{channel_name} left out: {feed.topic.name} has no number in it between the first and last row"
            )
            continue
        values[channel_name] = data
        names[channel_name] = CHANNELS[channel_name].names(data.shape[1])
        said[channel_name] = {**channel_origin(channel_name, feed, read.mapping), **how}
    require_plausible(values, names, t, read.path)
    if not set(values) - {"battery", "airborne"}:
        raise InputError(
            problem(f"{read.path}: no channel holds a number", "pose, rates or commands", "Check the mapping.")
        )
    derived = _derive(t, values, names)
    columns = {"t": t}
    for channel_name in CHANNELS:
        if channel_name in values:
            columns.update(dict(zip(names[channel_name], values[channel_name].T, strict=True)))
    meta = table_metadata(read.path, read.kind, read.mapping, read.zero, t, rule, said, derived, notes)
    return Flight(pd.DataFrame(columns), meta)


def _tidied(read: Streams, stream: Stream, start: float | None, stop: float | None, notes: list[str]) -> Stream:
    t = stream.t
    keep = np.arange(t.size)
    if stop is not None and (t > stop + 1.0).any():
        keep = keep[: int(np.argmax(t > stop + 1.0))]
    if start is not None:
        keep = keep[~(t[keep] < start - 1.0)]
    order = keep[clock.tidy(t[keep], stream.topic, read.path, read.kind in ("rosbag", "ulog"), notes)]
    channels = {name: data[order] for name, data in stream.channels.items()}
    return Stream(
        stream.name, stream.topic, t[order], channels, stream.time_source, stream.delay, stream.feed, stream.resolved
    )


def _rows(read: Streams, tidied: dict[str, Stream], asked: str | None) -> tuple[Array, str, str]:
    rate = read.mapping.clock.rate_hz
    leader = tidied[_leading(read.plan).stream.name]
    if asked is not None:
        if asked in CHANNELS:
            feed = read.plan.feed_of(asked)
            if feed is None:
                raise InputError(
                    problem(f"{read.path}: no channel {asked}", ", ".join(read.plan.channels), "Choose another --rows.")
                )
            leader, rate = tidied[feed.stream.name], None
        else:
            rate = float(asked)
    if rate is None:
        return leader.t, f"the samples of {leader.topic}", leader.topic
    if leader.t.size < 2:
        return leader.t, "", leader.topic
    count = int(np.floor((leader.t[-1] - leader.t[0]) * rate + 1e-6)) + 1
    return leader.t[0] + np.arange(count) / rate, f"an even grid of {rate:g} Hz", leader.topic


def _on_rows(name: str, stream: Stream, t: Array) -> tuple[Array, dict[str, Any]]:
    rule: Resample = stream.feed.channels[name].resample or CHANNELS[name].resample
    limit = stream.limit
    if rule == "hold" and stream.feed.stream.max_gap is None and not _periodic(stream.t):
        limit = float("inf")
    data = resample.put(t, stream.t, stream.channels[name], rule, limit)
    found = resample.gaps(stream.t, stream.limit) if rule != "sample" else []
    how: dict[str, Any] = {"rule": rule, "samples": int(stream.t.size), "time": stream.time_source}
    if stream.t.size > 1:
        how["rate_hz"] = round(float(1.0 / np.median(np.diff(stream.t))), 3)
    how["rows_without"] = int((~np.isfinite(data).all(axis=1)).sum())
    if found:
        longest = max(found, key=lambda g: g[1] - g[0])
        how["gaps"] = {
            "count": len(found),
            "longer_than_s": round(stream.limit, 6),
            "longest_s": round(longest[1] - longest[0], 6),
            "longest_at_s": round(longest[0], 6),
        }
    return data, how


def _periodic(t: Array) -> bool:
    """True for a stream of even steps; one that is sent when something changes holds until the next."""
    if t.size < 3:
        return False
    step = np.diff(t)
    median = float(np.median(step))
    return float(np.median(np.abs(step - median))) <= 0.25 * median


def _derive(t: Array, values: dict[str, Array], names: dict[str, tuple[str, ...]]) -> dict[str, str]:
    derived: dict[str, str] = {}
    limit = resample.gap_limit(t)
    for name, source, rule, said in (
        ("velocity", "position", derive.velocity, derive.VELOCITY_RULE),
        ("rate", "attitude", derive.rate, derive.RATE_RULE),
    ):
        if name not in values and source in values:
            values[name] = rule(t, values[source], limit)
            names[name] = CHANNELS[name].columns
            derived.update(dict.fromkeys(names[name], said))
    return derived
