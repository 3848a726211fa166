"""What a mapping names and the log has not: a channel is left out for it, and the notes say what was looked for."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from itertools import count, takewhile

from infotraj.importing.channel_map import ChannelMap
from infotraj.importing.channels import CHANNELS
from infotraj.importing.log import Log, Topic
from infotraj.importing.mapping import Mapping, StreamMap
from infotraj.importing.mapping_files import shipped
from infotraj.importing.streams import Plan, fits_stream

_SHOWN = 200  # characters of a list of names


def note_unfound(log: Log, found: Plan) -> None:
    """Notes each channel of the mapping that has no field in the log, in place.

    Of what a shipped mapping names, which asks for more than any log has, only numbers that count from 1 are noted.
    """
    usual = _of_shipped(found.mapping)
    carried = {c for f in found.feeds for c in f.channels}
    said = {note.split(" left out: ")[0] for note in found.notes}
    for channel in CHANNELS:
        offers = [(s, s.channels[channel]) for s in found.mapping.streams if channel in s.channels]
        if channel in carried or channel in said:
            continue
        from_one = next((n for s, m in offers if (n := _from_one(log, s, m))), None)
        own = [(s, m) for s, m in offers if (s.topic, s.type, m.fields) not in usual]
        if from_one is not None:
            found.notes.append(f"{channel} left out: {from_one}")
        elif own:
            found.notes.append(f"{channel} left out: {'; '.join(_lacking(log, s, m) for s, m in own)}")


def _of_shipped(mapping: Mapping) -> set[tuple[object, ...]]:
    alike = [m for m in shipped().values() if set(m.reads) & set(mapping.reads)]
    return {(s.topic, s.type, mapped.fields) for m in alike for s in m.streams for mapped in s.channels.values()}


def _topics(log: Log, stream: StreamMap) -> Iterator[Topic]:
    return (t for t in log.topics if t.messages != 0 and fits_stream(stream, t))


def _from_one(log: Log, stream: StreamMap, mapped: ChannelMap) -> str | None:
    """What to do about `m*` where a log of named columns has m1, m2, .. and no m0."""
    name, fields = mapped.fields[0], getattr(log, "fields", None)
    if "*" not in name or fields is None:
        return None
    for topic in _topics(log, stream):
        known = set(fields(topic))
        counted = (name.replace("*", str(k)) for k in count(1))
        there = list(takewhile(known.__contains__, counted))
        if there and not log.has(topic, name):
            return f"{name} counts from 0, and the log has {_list(there)}; name them: fields: [{', '.join(there)}]"
    return None


def _lacking(log: Log, stream: StreamMap, mapped: ChannelMap) -> str:
    topics = list(_topics(log, stream))
    fields = getattr(log, "fields", None)
    if not topics:
        wanted = tuple(stream.topic or stream.type or ())
        return f"no topic {_list(wanted)}" + _nearest(wanted, [t.name for t in log.topics])
    known = list(dict.fromkeys(name for t in topics for name in fields(t))) if fields is not None else []
    return f"no {_list(mapped.fields)}" + _nearest(mapped.fields, known)


def _nearest(wanted: tuple[str, ...], known: list[str]) -> str:
    """The nearest names, capitals apart; else all that are there."""
    lower = {name.lower(): name for name in known}
    near = [lower[n] for w in wanted for n in get_close_matches(w.lower(), list(lower), 1)]
    return f"; nearest: {_list(near)}" if near else f"; the log has {_list(known)}" if known else ""


def _list(names: tuple[str, ...] | list[str]) -> str:
    text = ", ".join(dict.fromkeys(names))
    return text if len(text) <= _SHOWN else text[:_SHOWN] + ".."
