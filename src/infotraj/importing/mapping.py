"""The mapping file: which topic or column is which channel, in which unit and frame. Strict: unknown keys are errors.

A mapping lists streams, best first. A stream is one topic of the log (or the columns of a table) with one clock; a
channel comes from the first stream that is in the log and carries it.
"""

from __future__ import annotations

import hashlib
from typing import Any, Literal

from pydantic import Field, model_validator

from infotraj.importing.channel_map import Axes, ChannelMap, Names, Number, Strict, check_channel, frame_matrix
from infotraj.importing.channels import CHANNELS
from infotraj.importing.table_format import TableFormat, require_pattern
from infotraj.importing.units import UNITS

Kind = Literal["rosbag", "ulog", "crazyflie", "table", "blackbox", "dataflash"]


class TimeMap(Strict):
    """Where a stream's time stands: the first of `fields` that the log has and that is not 0 throughout."""

    fields: Names = Field(description="field names; `record` is the time at which a bag recorded the message")
    unit: str = Field("s", description="s, ms, us or ns; ROS stamps carry their own unit")

    @model_validator(mode="after")
    def _known(self) -> TimeMap:
        if self.unit not in UNITS["time"]:
            raise ValueError(f"unit {self.unit!r} is no unit of time; known: {', '.join(UNITS['time'])}")
        return self


class StreamMap(Strict):
    """One topic with one clock, and the channels that it carries."""

    name: str
    topic: Names | None = Field(None, description="name(s), first present wins; a table needs none")
    type: Names | None = Field(None, description="message type(s), package/msg/Name, where topics differ in name")
    match: str | None = Field(None, description="regular expression that the topic's name must contain")
    avoid: str | None = Field(None, description="regular expression that rules topics out")
    prefer: Names = Field((), description="regular expressions; among several topics the earliest match wins")
    instance: int | None = Field(None, ge=0, description="of a ULog topic; default: the lowest with messages")
    when: dict[str, str | int | float | bool] = Field(
        default_factory=dict, description="field: value (text: regular expression) in the first message"
    )
    time: TimeMap | None = None
    world: Axes | None = None
    body: Axes | None = None
    max_gap: float | None = Field(None, gt=0, description="s; default: 1.5 median periods plus jitter")
    shift: Number = Field(0.0, description="s, added to the stream's time stamps")
    drop_repeats: bool = Field(False, description="samples that repeat the one before in every channel are no samples")
    channels: dict[str, ChannelMap] = Field(min_length=1)

    @model_validator(mode="after")
    def _consistent(self) -> StreamMap:
        for pattern in (self.match, self.avoid, *self.prefer, *self.when.values()):
            if isinstance(pattern, str):
                require_pattern(pattern)
        for name, channel in self.channels.items():
            check_channel(name, channel)
        return self


class Clock(Strict):
    """Which samples make the rows."""

    channel: Names = Field(
        ("position", "attitude", "velocity", "rate", "specific_force", "rotor_command", "commanded_force"),
        description="the rows are the samples of the stream of the first of these channels that the log has",
    )
    rate_hz: float | None = Field(None, gt=0, le=1e5, description="instead: an even grid")

    @model_validator(mode="after")
    def _known(self) -> Clock:
        unknown = [c for c in self.channel if c not in CHANNELS]
        if unknown:
            raise ValueError(f"clock: unknown channel {unknown[0]!r}; known: {', '.join(CHANNELS)}")
        return self


class Requires(Strict):
    """What a log must have for the mapping to be chosen by itself: every entry (a regular expression) of each list."""

    topics: Names = ()
    types: Names = ()
    fields: Names = ()

    @model_validator(mode="after")
    def _patterns(self) -> Requires:
        for pattern in (*self.topics, *self.types):
            require_pattern(pattern)
        return self


class Mapping(Strict):
    """A mapping file."""

    name: str
    description: str = ""
    reads: Names = Field(description="kinds of log: rosbag, ulog, crazyflie, blackbox, dataflash, table")
    automatic: bool = Field(True, description="may be chosen by looking at the log")
    requires: Requires = Requires()
    world: Axes = "ENU"
    body: Axes = "FLU"
    time: TimeMap | None = None
    clock: Clock = Clock()
    definitions: Names = Field((), description="files or folders with message definitions that the bag lacks")
    table: TableFormat | None = Field(None, description="how a text file is laid out that is no plain CSV")
    set: dict[str, dict[str, Any]] = Field(
        default_factory=dict, description="channel: {key: value}, already replaced in every stream with the channel"
    )
    streams: tuple[StreamMap, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _consistent(self) -> Mapping:
        unknown = [kind for kind in self.reads if kind not in Kind.__args__]  # type: ignore[attr-defined]
        if unknown:
            raise ValueError(f"reads: {unknown[0]!r} is none of {', '.join(Kind.__args__)}")  # type: ignore[attr-defined]
        owners: tuple[Mapping | StreamMap, ...] = (self, *self.streams)
        for owner in owners:
            frame_matrix(owner.world, "world")
            frame_matrix(owner.body, "body")
        names = [s.name for s in self.streams]
        twice = sorted({n for n in names if names.count(n) > 1})
        if twice:
            raise ValueError(f"streams: the name {twice[0]!r} appears twice")
        return self

    def digest(self) -> str:
        """sha256 of the content, so that a table says which version of a mapping made it."""
        return hashlib.sha256(self.model_dump_json().encode()).hexdigest()
