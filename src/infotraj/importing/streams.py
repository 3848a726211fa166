"""From a mapping to the topics of this log: which topic feeds which channel, by rules that are stated and noted.

Of several topics that fit a stream, in this order: the mapping's own order of names, its `prefer` list, for motors
those of which most fields change, most messages, first in the alphabet. A channel comes from the first stream, in the
mapping's order, that carries all of its fields.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from infotraj.errors import InputError, UsageError, problem
from infotraj.importing.channel_map import ChannelMap
from infotraj.importing.channels import CHANNELS
from infotraj.importing.log import Log, Topic
from infotraj.importing.mapping import Mapping, StreamMap, TimeMap
from infotraj.importing.moving import moving_count, numbered_fields

_DEFAULT_TIME = {
    "rosbag": TimeMap(fields=("header.stamp", "record")),
    "ulog": TimeMap(fields=("timestamp_sample", "timestamp"), unit="us"),
    "crazyflie": TimeMap(fields=("timestamp",), unit="ns"),
}
_INSTANCE = ".instance="


@dataclass(eq=False)
class Feed:
    """One stream of the mapping that this log has: its topic, the channels present, and those used for the table."""

    stream: StreamMap
    topic: Topic
    time: TimeMap
    channels: dict[str, ChannelMap]
    used: list[str] = field(default_factory=list)

    @property
    def shift(self) -> float:
        """Time (s) that is added to its stamps; the channels of a feed share one."""
        return self.stream.shift + next(iter(self.channels.values())).shift


@dataclass
class Plan:
    """What a mapping finds in a log. `spares`: other topics that fit a stream, for where the chosen one is silent."""

    mapping: Mapping
    feeds: list[Feed]
    notes: list[str]
    spares: list[Feed] = field(default_factory=list)

    def feed_of(self, channel: str) -> Feed | None:
        """The feed that the channel comes from."""
        return next((f for f in self.feeds if channel in f.used), None)

    @property
    def channels(self) -> list[str]:
        """The channels that the table will hold, in the table's order."""
        return [c for c in CHANNELS if self.feed_of(c) is not None]


def plan(log: Log, mapping: Mapping) -> Plan:
    """Finds the mapping's streams in the log. UsageError where the mapping is for another kind of log."""
    if log.kind not in mapping.reads:
        raise UsageError(
            problem(
                f"mapping {mapping.name} reads {', '.join(mapping.reads)}, but {log.path} is a {log.kind}",
                "a mapping for this kind of log",
                "Choose another --mapping.",
            )
        )
    notes: list[str] = []
    feeds: list[Feed] = []
    spares: list[Feed] = []
    taken: set[str] = set()
    for stream in mapping.streams:
        for part in _apart(stream):
            found = _find(log, mapping, part, taken, notes)
            for feed in found[:1]:
                # every flag counts: the vehicle flies where none of them says that it does not
                feed.used = [c for c in feed.channels if c not in taken or c == "airborne"]
                taken.update(feed.used)
                feeds.append(feed)
            spares += found[1:]
    return Plan(mapping, feeds, notes, spares)


def require_channels(found: Plan, log: Log) -> None:
    """InputError, saying what the log has, where the mapping finds nothing in it."""
    if found.channels:
        return
    topics = [*log.topics, *getattr(log, "others", ())]
    has = ", ".join(t.name for t in topics if t.messages != 0) or "no topic with messages"
    asked = sorted({name for s in found.mapping.streams for name in (s.topic or s.type or ("its columns",))})
    hint = f" ({found.notes[0]})" if found.notes else ""
    raise InputError(
        problem(
            f"{log.path}: nothing that mapping {found.mapping.name} asks for{hint}; it has {has[:300]}",
            ", ".join(asked)[:300],
            "Write a mapping (docs/import.md) and give it with --mapping.",
        )
    )


def _apart(stream: StreamMap) -> list[StreamMap]:
    """The stream as one part for each time shift among its channels: a shifted channel has a clock of its own."""
    shifts = dict.fromkeys(mapped.shift for mapped in stream.channels.values())
    if len(shifts) == 1:
        return [stream]
    parts = []
    for shift in shifts:
        channels = {name: mapped for name, mapped in stream.channels.items() if mapped.shift == shift}
        name = stream.name if shift == 0.0 else f"{stream.name} shifted by {shift:g} s"
        parts.append(stream.model_copy(update={"name": name, "channels": channels}))
    return parts


def _find(log: Log, mapping: Mapping, stream: StreamMap, taken: Collection[str], notes: list[str]) -> list[Feed]:
    """The feeds that fit a stream, the best first. taken: channels that an earlier stream gives."""
    fitting: list[tuple[Any, Topic, dict[str, ChannelMap]]] = []
    for topic in log.topics:
        rank = _rank(stream, topic)
        if rank is None:
            continue
        if topic.messages == 0:
            # A stream that names no topic asks every topic; only what it was to get from this one is missed.
            fields = [name for mapped in stream.channels.values() for name in mapped.fields]
            if stream.topic or stream.type or any(log.has(topic, name) for name in fields):
                notes.append(f"{stream.name}: topic {topic.name} is empty")
            continue
        channels = _present(log, stream, topic, taken, notes)
        if channels and unmet(log, stream, topic) is None:
            fitting.append((rank, topic, channels))
    if not fitting:
        return []
    fitting.sort(key=lambda entry: entry[0])
    _most_moving_first(log, stream, fitting, notes)
    if len(fitting) > 1:
        others = ", ".join(label(t) for _, t, _ in fitting[1:])
        chosen = label(fitting[0][1])
        notes.append(f"{stream.name}: {chosen} was chosen; {others} would fit too ({_override(stream, fitting)})")
    feeds = []
    for k, (_, topic, channels) in enumerate(fitting):
        own = stream if k == 0 else stream.model_copy(update={"name": f"{stream.name} of {label(topic)}"})
        feeds.append(Feed(own, topic, _time(log, mapping, stream, topic), channels))
    return feeds


def _override(stream: StreamMap, fitting: list[Any]) -> str:
    """How to take another of the fitting topics: by its instance, where they differ in nothing else."""
    chosen, *others = [topic for _, topic, _ in fitting]
    if any(other.name != chosen.name for other in others):
        return "override with a mapping"
    return f"override with --set {next(iter(stream.channels))}{_INSTANCE}{others[0].instance}"


def noted_setting(channel: str, key: str, notes: Iterable[object]) -> str | None:
    """The setting of a channel's key (another instance of its topic, a shift of its clock) that a note of the import
    names."""
    setting = re.compile(rf"(?<=--set ){re.escape(f'{channel}.{key}=')}-?\d+(\.\d+)?")
    found = filter(None, (setting.search(str(note)) for note in notes))
    return next((f[0] for f in found), None)


def _most_moving_first(log: Log, stream: StreamMap, fitting: list[Any], notes: list[str]) -> None:
    """Puts the topic of motors of which most fields change before the others, among topics that else rank alike."""
    alike = [entry for entry in fitting if entry[0][:2] == fitting[0][0][:2]]
    if len(alike) < 2 or not numbered_fields(alike[0][2]):
        return
    counts = [moving_count(log, topic, numbered_fields(channels)) for _, topic, channels in alike]
    best = int(np.argmax(counts))
    if counts[best] > counts[0]:
        first, other = label(alike[0][1]), label(alike[best][1])
        notes.append(f"{stream.name}: of {first} {counts[0]} fields change, of {other} {counts[best]}")
        fitting.remove(alike[best])
        fitting.insert(0, alike[best])


def _rank(stream: StreamMap, topic: Topic) -> tuple[int, int, int, int, str] | None:
    """The place of a topic among those that fit; None where it does not fit."""
    names = stream.topic or ()
    if names and topic.name not in names:
        return None
    if stream.type is not None and _long(topic.type) not in map(_long, stream.type):
        return None
    if stream.match is not None and not re.search(stream.match, topic.name):
        return None
    if stream.avoid is not None and re.search(stream.avoid, topic.name):
        return None
    if stream.instance is not None and topic.instance != stream.instance:
        return None
    preference = next((k for k, p in enumerate(stream.prefer) if re.search(p, topic.name)), len(stream.prefer))
    order = names.index(topic.name) if names else 0
    return order, preference, topic.instance, -(topic.messages or 0), topic.name


def fits_stream(stream: StreamMap, topic: Topic) -> bool:
    """Whether the topic is one of those that the stream asks for, whatever it holds."""
    return _rank(stream, topic) is not None


def _present(
    log: Log, stream: StreamMap, topic: Topic, taken: Collection[str], notes: list[str]
) -> dict[str, ChannelMap]:
    channels = {}
    for name, mapped in stream.channels.items():
        fields = (*mapped.fields, *((mapped.count,) if mapped.count is not None else ()))
        there = [f for f in fields if log.has(topic, f)]
        if len(there) == len(fields):
            channels[name] = mapped
        elif there and name not in taken:
            missing = [f for f in fields if f not in there]
            notes.append(f"{name} left out: {label(topic)} has {', '.join(there)} but not {', '.join(missing)}")
    return channels


def unmet(log: Log, stream: StreamMap, topic: Topic) -> str | None:
    """Which of the stream's conditions (`when`) the topic's first message does not meet, None where it meets all."""
    for name, wanted in stream.when.items():
        found = log.first(topic, name) if log.has(topic, name) else None
        if isinstance(wanted, str):
            meets = isinstance(found, str) and re.search(wanted, found) is not None
        else:
            meets = found is not None and found == wanted
        if not meets:
            is_found = "is missing" if found is None else f"is {found}"
            return f"{name} {is_found}, and stream {stream.name} is for {name} {wanted}"
    return None


def _time(log: Log, mapping: Mapping, stream: StreamMap, topic: Topic) -> TimeMap:
    declared = stream.time or mapping.time or _DEFAULT_TIME.get(log.kind)
    if declared is None:
        raise UsageError(
            problem(f"mapping {mapping.name} names no time", "`time: {fields: t, unit: s}`", "Add it to the mapping.")
        )
    recorded = log.kind == "rosbag"  # other logs do not say when a sample was written
    fields = tuple(f for f in declared.fields if (f == "record" and recorded) or log.has(topic, f))
    if not fields and log.kind == "rosbag":
        fields = ("record",)
    if not fields:
        raise InputError(
            problem(
                f"{log.path}: {label(topic)} has no time column",
                f"one of {', '.join(declared.fields)}",
                "Name it under `time` in a mapping.",
            )
        )
    return TimeMap(fields=fields, unit=declared.unit)


def label(topic: Topic) -> str:
    """A topic's name, with its instance where there are several."""
    return f"{topic.name}[{topic.instance}]" if topic.instance else topic.name


def _long(name: str) -> str:
    parts = name.split("/")
    return f"{parts[0]}/msg/{parts[1]}" if len(parts) == 2 else name
