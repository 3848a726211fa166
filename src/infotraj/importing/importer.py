"""From a log to a flight table: its streams on one clock, what follows from them derived, and how it was done said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from infotraj.arguments import AnyPath, as_path, require_part
from infotraj.errors import InputError, problem
from infotraj.flight import Flight
from infotraj.importing import clock, derive, resample, row_rate
from infotraj.importing.again import leave_derived, own_metadata, with_own_metadata
from infotraj.importing.channels import CHANNELS, Resample
from infotraj.importing.flags import in_the_air
from infotraj.importing.mapping import Mapping
from infotraj.importing.metadata import channel_origin, content_hash, table_metadata
from infotraj.importing.plausible import require_plausible
from infotraj.importing.reading import Stream, Streams, leading_feed, read_streams
from infotraj.importing.settings import Settings
from infotraj.progress import reached
from infotraj.rotations import Array


def import_log(
    path: AnyPath,
    mapping: Mapping | AnyPath | None = None,
    *,
    start: float | None = None,
    stop: float | None = None,
    definitions: tuple[Path, ...] = (),
    allow_damaged: bool = False,
    rows: str | None = None,
    settings: Settings | None = None,
    beside: tuple[Path, ...] = (),
) -> Flight:
    """A log as a flight table (SI, world z up, body x forward y left z up).

    mapping: a Mapping, the name of a shipped one, the path of a mapping file, or None to choose by looking at the log.
    start, stop: s, on the table's t; start <= t < stop. definitions: message definitions that a bag lacks.
    rows: a channel whose samples make the rows, or a rate in Hz; default: as the mapping says.
    settings: {channel: {key: value}}, replaced in the mapping (`parse_settings` reads them from text).
    beside: further tables of the same flight whose times count from the same zero.
    InputError where the log cannot be used, UsageError where the mapping is wrong.
    """
    path = as_path("a log", path)
    require_part(start, stop)
    read = read_streams(
        path, mapping, definitions=definitions, allow_damaged=allow_damaged, settings=settings, beside=beside
    )
    return to_flight(read, start=start, stop=stop, rows=rows)


def to_flight(
    read: Streams, *, start: float | None = None, stop: float | None = None, rows: str | None = None
) -> Flight:
    """The streams on one clock as a flight table. InputError where time runs back or values are impossible."""
    own = own_metadata(read)
    leave_derived(read, own)
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
    for k, channel_name in enumerate(CHANNELS):
        reached("rows", k, len(CHANNELS))
        feed = read.plan.feed_of(channel_name)
        if feed is None or not read.streams[feed.stream.name].resolved.get(channel_name, True):
            continue
        stream = tidied[feed.stream.name]
        data, how = _on_rows(channel_name, stream, t)
        if channel_name == "airborne":
            feeds = [f for f in read.plan.feeds if channel_name in f.used]
            flags = [tidied[f.stream.name] for f in feeds]
            knows = [1 in (f.channels[channel_name].states or {1: 1}).values() for f in feeds]
            data = in_the_air([_on_rows(channel_name, s, t)[0] for s in flags], knows)
            how |= {"rows_without": int(np.isnan(data).sum()), "flags": [s.topic for s in flags]}
        if not np.isfinite(data).any():
            notes.append(
                f"{channel_name} left out: {feed.topic.name} has no number in it between the first and last row"
            )
            continue
        values[channel_name] = data
        names[channel_name] = CHANNELS[channel_name].names(data.shape[1])
        said[channel_name] = {**channel_origin(channel_name, feed, read.mapping), **how}
        remark = feed.channels[channel_name].remark
        if remark is not None:
            notes.append(f"{channel_name}: {remark}")
    reached("checks")
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
    lost = row_rate.denser({"channels": said}, t)
    if lost:
        notes.append(f"{row_rate.in_words(lost, t)}: rows are {rule}; {row_rate.rows_option(lost)} keeps the rest")
    for name, step in row_rate.held({"channels": said}, t).items():
        notes.append(f"{name} comes every {1000 * step:.3g} ms only, and is held over the rows between")
    meta = table_metadata(read.path, read.kind, read.mapping, read.zero, t, rule, said, derived, notes)
    if read.beside:
        meta["with"] = [{"source_file": p.name, "source_sha256": content_hash(p)} for p in read.beside]
    return with_own_metadata(Flight(pd.DataFrame(columns), meta), own)


def _tidied(read: Streams, stream: Stream, start: float | None, stop: float | None, notes: list[str]) -> Stream:
    t, may_reorder = stream.t, read.kind in ("rosbag", "ulog")
    keep = clock.within(t, start, stop, may_reorder)
    order = keep[clock.tidy(t[keep], stream.topic, read.path, may_reorder, notes)]
    channels = {name: data[order] for name, data in stream.channels.items()}
    return Stream(
        stream.name, stream.topic, t[order], channels, stream.time_source, stream.delay, stream.feed, stream.resolved
    )


def _rows(read: Streams, tidied: dict[str, Stream], asked: str | None) -> tuple[Array, str, str]:
    rate = read.mapping.clock.rate_hz
    leader = tidied[leading_feed(read.plan).stream.name]
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
