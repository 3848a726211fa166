"""The streams of a log: read in one pass, in SI and the table's axes, timed as logged. What `check` looks at."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from infotraj.arguments import AnyPath
from infotraj.errors import InputError, UsageError, problem
from infotraj.importing import clock, convert, resample
from infotraj.importing.channels import CHANNELS
from infotraj.importing.joined import JoinedTables, require_overlap
from infotraj.importing.log import Log, Request
from infotraj.importing.mapping import Mapping
from infotraj.importing.mapping_files import load_mapping, shipped
from infotraj.importing.opening import kind_of, open_log
from infotraj.importing.recognise import choose
from infotraj.importing.settings import Settings, with_settings
from infotraj.importing.silent import pass_over_silent
from infotraj.importing.streams import Feed, Plan, label, plan, require_channels
from infotraj.importing.table import TableFile
from infotraj.importing.table_format import TableFormat
from infotraj.importing.unfound import note_unfound
from infotraj.importing.unit_ranges import outside_unit
from infotraj.progress import reached
from infotraj.rotations import Array

_FAR = 0.2  # s between clocks: `check` compares streams up to there


@dataclass
class Stream:
    """One stream as read: `t` (n,) s on the log's common clock, channels (n, k) in SI and in the table's axes.

    Not yet tidied: time may repeat, go back or have gaps, exactly as logged. `resolved` is False where a channel is
    not to be used: a vector still in its logged axes because the log has no attitude to turn it with, or numbers that
    are not of their unit.
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
    beside: tuple[Path, ...] = ()


def read_streams(
    path: AnyPath,
    mapping: Mapping | AnyPath | None = None,
    *,
    definitions: tuple[Path, ...] = (),
    allow_damaged: bool = False,
    every: bool = False,
    settings: Settings | None = None,
    beside: tuple[Path, ...] = (),
) -> Streams:
    """The streams of a log in SI and table axes, timed as logged. `every`: also channels that the table leaves out.

    `settings` replace keys of the mapping's channels. Where a channel's feed holds nothing but zeros, and another one
    of the log carries the channel, that one is taken. `beside`: further tables of the same flight on the same clock.
    """
    path = Path(path)
    with opened(path, mapping, definitions, allow_damaged, settings, beside) as (log, chosen):
        require_channels(chosen, log)
        read = _read(log, chosen, every)
        passed: dict[str, list[Feed]] = {}
        while pass_over_silent(chosen, {s.name: s.channels for s in read.streams.values()}, passed, read.notes):
            read = _read(log, chosen, every)
        read.beside = beside
        if beside:
            _require_used(log, chosen, beside)
            spans = {s.name: (float(s.t.min()), float(s.t.max())) for s in read.streams.values() if s.t.size}
            require_overlap(path, spans)
        return read


@contextmanager
def opened(
    path: Path,
    mapping: Mapping | AnyPath | None,
    definitions: tuple[Path, ...] = (),
    allow_damaged: bool = False,
    settings: Settings | None = None,
    beside: tuple[Path, ...] = (),
) -> Iterator[tuple[Log, Plan]]:
    """The open log with the plan of the given mapping, or of the shipped one that fits best, with these settings."""
    given = mapping if isinstance(mapping, Mapping) or mapping is None else load_mapping(mapping)
    kind = kind_of(path)
    candidates = [given] if given is not None else [m for m in shipped().values() if kind in m.reads and m.automatic]
    layout = table_layout(path, candidates) if kind == "table" else None
    names = frozenset(topic for m in candidates for s in m.streams for topic in (s.topic or ()))
    folders = (*definitions, *(Path(d) for d in given.definitions)) if given is not None else definitions
    log = open_log(path, kind, names, folders, allow_damaged, layout)
    if beside:
        log = _joined(log, beside, layout, allow_damaged)
    try:
        alike = [m for m in candidates if m.table == layout]
        chosen = plan(log, given) if given is not None else choose(log, alike)
        chosen = plan(log, with_settings(chosen.mapping, settings)) if settings else chosen
        note_unfound(log, chosen)
        yield log, chosen
    finally:
        log.close()


def table_layout(path: Path, candidates: list[Mapping]) -> TableFormat | None:
    """The layout of a table: that of the only mapping, else that of the first whose line prefix the text has."""
    if len(candidates) == 1:
        return candidates[0].table if path.suffix.lower() != ".parquet" else None
    layouts = [m.table for m in candidates if m.table is not None and path.suffix.lower() != ".parquet"]
    return next((layout for layout in layouts if layout.recognises(path)), None)


def _joined(log: Log, beside: tuple[Path, ...], layout: TableFormat | None, allow_damaged: bool) -> Log:
    further = []
    for path in beside:
        if not isinstance(log, TableFile) or kind_of(path) != "table":
            raise UsageError(problem(f"--with {path}: not all are tables", "tables (CSV, text, Parquet)", "Join them."))
        own = layout if path.suffix.lower() != ".parquet" else None
        further.append(TableFile(path, allow_damaged, own))
    assert isinstance(log, TableFile)
    return JoinedTables([log, *further])


def _require_used(log: Log, chosen: Plan, beside: tuple[Path, ...]) -> None:
    """InputError where the mapping takes no channel from one of the further tables."""
    assert isinstance(log, JoinedTables)
    used = {f.topic.name for f in chosen.feeds if f.used}
    for topic, table in zip(log.topics[1:], beside, strict=True):
        if topic.name not in used:
            columns = ", ".join(log.fields(topic))
            found = f"--with {table}: {chosen.mapping.name} takes no channel from it; it has {columns}"
            remedy = "Choose or write another --mapping, or leave it out."
            raise InputError(problem(found, "a column that the mapping reads", remedy))


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
    reached("streams")
    all_ticks = {f.stream.name: clock.ticks(s, f.time) for f, s in zip(feeds, samples, strict=True)}
    has_stamp = {name: clock.stamped(tick) for name, tick in all_ticks.items()}
    for name, has in has_stamp.items():
        if not has.all():
            tick = all_ticks[name]
            tick.values, tick.record = tick.values[has], tick.record[has]
            notes.append(f"{name}: messages with the stamp 0 are left out ({int((~has).sum())})")
    leader = leading_feed(chosen)
    delays = {
        name: float(np.median((tick.record - tick.values).astype(float))) / 1e9
        if tick.record is not None and tick.values.size
        else None
        for name, tick in all_ticks.items()
    }
    clock.align(all_ticks[leader.stream.name], all_ticks, notes)
    notes += _far_clocks(feeds, leader, all_ticks)
    zero = clock.origin(all_ticks[leader.stream.name])
    streams = {}
    for feed, sample in zip(feeds, samples, strict=True):
        name = feed.stream.name
        channels = {
            c: convert.channel_values(c, feed.channels[c], feed.stream, chosen.mapping, sample)[has_stamp[name]]
            for c in wanted[name]
        }
        tick = all_ticks[name]
        if feed.stream.drop_repeats:
            channels = _without_repeats(name, tick, channels, notes)
        streams[name] = Stream(
            name, feed.topic.name, clock.seconds(tick, zero) + feed.shift, channels, tick.source, delays[name], feed
        )
    _turn_vectors(chosen, streams, notes)
    for feed, sample in zip(feeds, samples, strict=True):
        for c in wanted[feed.stream.name]:
            why = outside_unit(c, feed.channels[c], convert.logged_numbers(feed.channels[c], sample))
            if why is not None:
                streams[feed.stream.name].resolved[c] = False
                notes.append(f"{c} left out: {label(feed.topic)} {why}")
    ticks = all_ticks[leader.stream.name]
    start = float(zero) / 1e9 if ticks.nanoseconds else float(zero)
    return Streams(log.path, log.kind, chosen.mapping, chosen, streams, start, notes)


def _far_clocks(feeds: list[Feed], leader: Feed, ticks: dict[str, clock.Ticks]) -> list[str]:
    """Notes on stamps that are off from the row stream's by more than a log's streams are compared to."""
    notes = []
    for feed in feeds:
        late = clock.late(ticks[leader.stream.name], ticks[feed.stream.name]) + feed.shift - leader.shift
        if feed.used and abs(late) > _FAR:
            settings = " ".join(f"--set {c}.shift={feed.channels[c].shift - late:.3f}" for c in feed.used)
            notes.append(
                f"{feed.stream.name}: its stamps are {abs(late):.3f} s {'later' if late > 0 else 'earlier'} than those "
                f"of the rows, by the times of recording: another clock, or slow transport; {settings} takes that out"
            )
    return notes


def _without_repeats(name: str, tick: clock.Ticks, channels: dict[str, Array], notes: list[str]) -> dict[str, Array]:
    """The samples that differ from the one before, in time and channels."""
    if not channels or not tick.values.size:
        return channels
    together = np.concatenate([values.reshape(tick.values.size, -1) for values in channels.values()], axis=1)
    same = (together[1:] == together[:-1]) | (np.isnan(together[1:]) & np.isnan(together[:-1]))
    new = np.append(True, ~same.all(axis=1))
    if not new.all():
        notes.append(f"{name}: {int((~new).sum())} of {new.size} samples repeat the one before and are left out")
    tick.values = tick.values[new]
    return {channel: values[new] for channel, values in channels.items()}


def _wanted(feed: Feed, every: bool) -> list[str]:
    names = list(feed.channels) if every else list(feed.used)
    turned = any(convert.needs_attitude(c, feed.channels[c]) for c in names)
    # A body velocity is turned by the attitude of its own message, whoever gives the table's attitude.
    return [*names, "attitude"] if turned and "attitude" in feed.channels and "attitude" not in names else names


def leading_feed(chosen: Plan) -> Feed:
    """The feed whose samples make the rows."""
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
