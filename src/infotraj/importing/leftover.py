"""What a log holds that its table does not use, and why; and what a missing channel would need."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from infotraj.errors import InfotrajError
from infotraj.importing.log import Log, Request, Topic
from infotraj.importing.mapping import Mapping, StreamMap
from infotraj.importing.reading import Streams, opened
from infotraj.importing.streams import Feed, Plan, label, unmet

_SHOWN = 3


def unused(read: Streams, definitions: tuple[Path, ...] = (), allow_damaged: bool = False) -> dict[str, str]:
    """Column, variable or topic: the reason why the table has nothing of it."""
    with opened(read.path, read.mapping, definitions, allow_damaged, beside=read.beside) as (log, _):
        fields = getattr(log, "fields", None)
        if fields is None:
            topics = [*log.topics, *getattr(log, "others", ())]
            return {label(t): why for t in topics if (why := _topic_reason(log, t, read.plan)) is not None}
        out: dict[str, str] = {}
        for topic in log.topics:
            left = [name for name in fields(topic) if name not in _taken(read.plan, topic)]
            content = _content(log, topic, left)
            for name in left:
                out[name] = "; ".join(filter(None, (_field_reason(name, log, topic, read.plan), content.get(name))))
        return out


def wanting(read: Streams, channel: str, definitions: tuple[Path, ...] = (), allow_damaged: bool = False) -> str:
    """What a channel that the table lacks would need: the fields that the mapping would take it from."""
    offers = [(s, s.channels[channel]) for s in read.mapping.streams if channel in s.channels]
    if not offers:
        return f"mapping {read.mapping.name} names no stream for it"
    partly, others = [], []
    with opened(read.path, read.mapping, definitions, allow_damaged, beside=read.beside) as (log, _):
        for stream, mapped in offers:
            topics = [t for t in log.topics if t.messages != 0 and _names_topic(stream, t)]
            best = max((sum(log.has(t, f) for f in mapped.fields) for t in topics), default=0)
            source = f"{' or '.join(stream.topic or stream.type or ())} ".lstrip()
            wanted = f"{source}{', '.join(mapped.fields)}"
            if 0 < best < len(mapped.fields):
                lacking = min(([f for f in mapped.fields if not log.has(t, f)] for t in topics), key=len, default=[])
                partly.append(f"{wanted} (lacking {', '.join(lacking)})")
            elif best == len(mapped.fields):
                why = _unmet(log, stream, topics) or "without a number or an attitude to turn it with"
                partly.append(f"{wanted} (there, but {why})")
            else:
                others.append(wanted)
    shown = [*partly, *others][:_SHOWN]
    more = len(offers) - len(shown)
    return "it would come from " + "; or ".join(shown) + (f"; or {more} more" if more > 0 else "")


def grouped(reasons: dict[str, str], most: int = 12) -> list[str]:
    """A line a reason: the names it holds for, then the reason."""
    by_reason: dict[str, list[str]] = {}
    for name, why in reasons.items():
        by_reason.setdefault(why, []).append(name)
    return [
        f"{', '.join(names[:most])}{f' and {len(names) - most} more' if len(names) > most else ''}: {why}"
        for why, names in by_reason.items()
    ]


def _taken(found: Plan, topic: Topic) -> set[str]:
    taken: set[str] = set()
    for feed in found.feeds:
        if feed.topic == topic and feed.used:
            taken.update(feed.time.fields)
            for channel in feed.used:
                mapped = feed.channels[channel]
                taken.update(_expanded(mapped.fields), *([{mapped.count}] if mapped.count else []))
    return taken


def _expanded(names: tuple[str, ...]) -> set[str]:
    return {n.replace("*", str(k)) for n in names for k in (range(64) if "*" in n else range(1))}


def _field_reason(name: str, log: Log, topic: Topic, found: Plan) -> str:
    if topic.messages == 0:
        return f"{label(topic)} is empty"
    for stream in found.mapping.streams:
        for channel, mapped in stream.channels.items():
            if name not in _expanded(mapped.fields):
                continue
            lacking = [f for f in mapped.fields if not log.has(topic, f)]
            feed = found.feed_of(channel)
            if lacking:
                return f"for {channel}, {', '.join(lacking)} is lacking"
            if feed is not None:
                return f"{channel} comes from {feed.stream.name} ({', '.join(feed.channels[channel].fields)})"
            return f"{channel} could not be made of it"
    return f"no channel of mapping {found.mapping.name} asks for it"


def _topic_reason(log: Log, topic: Topic, found: Plan) -> str | None:
    if any(f.topic == topic and f.used for f in found.feeds):
        return None
    if topic.messages == 0:
        return "empty"
    asked = [f for f in (*found.feeds, *found.spares) if f.topic == topic]
    for feed in asked:
        for channel in feed.channels:
            source = found.feed_of(channel)
            if source is not None:
                return f"{channel} comes from {_of(source)}"
    naming = [stream for stream in found.mapping.streams if _names_topic(stream, topic)]
    if naming:
        why = next(filter(None, (_unmet(log, stream, [topic]) for stream in naming)), None)
        if why is not None:
            return why
        return f"mapping {found.mapping.name} asks for it, but finds none of its fields there"
    return f"no stream of mapping {found.mapping.name} asks for it"


def _unmet(log: Log, stream: StreamMap, topics: list[Topic]) -> str | None:
    """The condition that keeps the stream from all of the topics that have its fields; None where one meets all."""
    fields = [f for mapped in stream.channels.values() for f in mapped.fields]
    reasons = [unmet(log, stream, t) for t in topics if any(log.has(t, f) for f in fields)]
    return reasons[0] if reasons and all(reasons) else None


def _of(feed: Feed) -> str:
    return f"{label(feed.topic)} (stream {feed.stream.name})"


def _names_topic(stream: StreamMap, topic: Topic) -> bool:
    if stream.topic is not None and topic.name not in stream.topic:
        return False
    return stream.type is None or topic.type in stream.type


def _content(log: Log, topic: Topic, names: list[str]) -> dict[str, str]:
    """What is worth saying of these fields' content: text, empty, constant."""
    said: dict[str, str] = {}
    numbers = []
    for name in names:
        if isinstance(_first(log, topic, name), str):
            said[name] = "text"
        else:
            numbers.append(name)
    try:
        values = log.read([Request(topic, tuple(numbers))])[0].numbers if numbers and topic.messages != 0 else {}
    except InfotrajError:
        return said  # a cell that is no number: its content cannot be judged
    for name, column in values.items():
        finite = column[np.isfinite(column)]
        if not finite.size:
            said[name] = "empty"
        elif np.ptp(finite) == 0.0:
            said[name] = f"constant {finite[0]:g}"
    return said


def _first(log: Log, topic: Topic, name: str) -> Any:
    try:
        return log.first(topic, name)
    except InfotrajError:
        return None


def described(mapping: Mapping) -> str:
    """What a mapping requires of a log, to be chosen by itself."""
    needs = mapping.requires
    prefix = (
        (f"lines that start with {mapping.table.line_prefix}",) if mapping.table and mapping.table.line_prefix else ()
    )
    return ", ".join((*prefix, *needs.topics, *needs.types, *needs.fields)) or "nothing"
