"""A log as `check` wants it: the flight table, the streams beside it, and what the raw time stamps say."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from infotraj.arguments import AnyPath
from infotraj.checking.beside import Beside
from infotraj.checking.finding import Finding
from infotraj.checking.questions import incomplete
from infotraj.checking.timing import order
from infotraj.errors import InputError
from infotraj.flight import COMMANDED_WRENCH, Flight, read_flight
from infotraj.importing import Mapping, Plan, Settings, Streams, read_streams, to_flight

# Transports deliver out of order by milliseconds; a clock that was set back jumps further.
REORDERED = 0.05


@dataclass(frozen=True)
class Loaded:
    """The flight, the streams that its table leaves out, and findings about the time stamps as they were logged.

    `plan`: the mapping that it was read with, and what came from where.
    """

    flight: Flight
    beside: list[Beside] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
    plan: Plan | None = None


def load(
    path: AnyPath,
    mapping: Mapping | AnyPath | None = None,
    start: float | None = None,
    stop: float | None = None,
    settings: Settings | None = None,
) -> Loaded:
    """Any log that can be imported, or a flight table. InputError where it cannot be read at all.

    Time that runs back or repeats is put in order here and reported, where `import` would refuse the log: `check` is to
    say all that is wrong with it, not only the first thing.
    """
    read = read_streams(path, mapping, every=True, settings=settings)
    findings = _put_in_order(read)
    flight = to_flight(read, start=start, stop=stop)
    if read.mapping.name == "flight_table":
        flight = _with_own_metadata(flight, Path(path))
    findings = [f for f in findings if not f.spans or _within(f, flight)]
    return Loaded(flight, list(_beside(read)), findings, read.plan)


def _put_in_order(read: Streams) -> list[Finding]:
    findings: list[Finding] = []
    seen: set[str] = set()
    for stream in read.streams.values():
        table = pd.DataFrame({"t": stream.t, "row": np.arange(stream.t.size)})
        if read.kind in ("rosbag", "ulog") and _worst_step_back(stream.t) <= REORDERED:
            table = table.sort_values("t", kind="stable")
        kept, found = order(table)
        rows = kept["row"].to_numpy()
        if len(rows) < 2:
            continue
        if len(rows) < stream.t.size or np.any(np.diff(rows) != 1):
            stream.t = stream.t[rows]
            stream.channels = {name: values[rows] for name, values in stream.channels.items()}
        if stream.topic not in seen:
            findings += found
        seen.add(stream.topic)
    return findings


def _worst_step_back(t: np.ndarray) -> float:
    good = t[np.isfinite(t)]
    return float((np.maximum.accumulate(good) - good).max()) if good.size else 0.0


def _with_own_metadata(flight: Flight, path: Path) -> Flight:
    # a table that was imported before says what is derived and where it came from
    try:
        own = read_flight(path)
    except InputError:
        return flight
    # An import takes a vector whole, and derives what it can in its place. A command takes the table as it is: of a
    # commanded wrench one component may be all of it, and what is incomplete is to be said.
    parts = [c for columns in incomplete(own).values() for c in columns]
    table = flight.table.drop(columns=parts, errors="ignore")
    alone = [c for c in (*COMMANDED_WRENCH, *parts) if own.has(c) and c not in table]
    table = table.merge(own.table[["t", *alone]], on="t", how="left") if alone else table
    return Flight(table, {**flight.meta, **own.meta})


def _within(finding: Finding, flight: Flight) -> bool:
    return any(b >= flight.t[0] and a <= flight.t[-1] for a, b in finding.spans)


def _beside(read: Streams) -> list[Beside]:
    return [
        Beside(stream.name, channel, stream.t, values)
        for stream in read.streams.values()
        for channel, values in stream.channels.items()
        if channel not in stream.feed.used and stream.resolved.get(channel, True)
    ]
