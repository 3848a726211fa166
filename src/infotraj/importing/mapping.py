"""The mapping file: which topic or column is which channel, in which unit and frame. Strict: unknown keys are errors.

A mapping lists streams, best first. A stream is one topic of the log (or the columns of a table) with one clock; a
channel comes from the first stream that is in the log and carries it.
"""

from __future__ import annotations

import hashlib
import re
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from infotraj.errors import UsageError, problem
from infotraj.importing.channels import CHANNELS, Resample
from infotraj.importing.frames import BODY_FRAMES, WORLD_FRAMES, axes_matrix
from infotraj.importing.units import SI, UNITS, conversion
from infotraj.rotations import Array
from infotraj.vehicle import validation_line

Kind = Literal["rosbag", "ulog", "crazyflie", "table"]


def _as_tuple(value: Any) -> Any:
    return (value,) if isinstance(value, str) else value


Names = Annotated[tuple[str, ...], BeforeValidator(_as_tuple)]
Axes = str | tuple[str, str, str]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class TimeMap(_Strict):
    """Where a stream's time stands: the first of `fields` that the log has and that is not 0 throughout."""

    fields: Names = Field(description="field names; `record` is the time at which a bag recorded the message")
    unit: str = Field("s", description="s, ms, us or ns; ROS stamps carry their own unit")

    @model_validator(mode="after")
    def _known(self) -> TimeMap:
        if self.unit not in UNITS["time"]:
            raise ValueError(f"unit {self.unit!r} is no unit of time; known: {', '.join(UNITS['time'])}")
        return self


class ChannelMap(_Strict):
    """One channel in a stream: its fields, and everything that must be known to turn them into the table's columns."""

    fields: Names = Field(
        min_length=1, description="in the table's order; `*` counts 0, 1, 2, .. as far as the log goes"
    )
    unit: str | None = Field(None, description="default SI; see `infotraj.importing.units`")
    scale: float = Field(1.0, description="multiplies the value in SI, for what no unit covers (-1: inverted)")
    offset: float = Field(0.0, description="added after the scale, in SI")
    order: Literal["wxyz", "xyzw"] = Field("wxyz", description="of a quaternion's fields")
    euler: bool = Field(False, description="attitude only: the fields are roll, pitch, yaw; R = Rz(yaw) Ry(pitch) Rx")
    rotates: Literal["body_to_world", "world_to_body"] = Field("body_to_world", description="attitude only")
    expressed_in: Literal["world", "body"] | None = Field(None, description="axes of a vector; default: the table's")
    gravity_removed: bool = Field(False, description="specific_force only: the log holds acceleration without gravity")
    count: str | None = Field(None, description="field that says how many of the `*` are in use")
    resample: Resample | None = Field(None, description="default: the channel's rule")


class StreamMap(_Strict):
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
    channels: dict[str, ChannelMap] = Field(min_length=1)

    @model_validator(mode="after")
    def _consistent(self) -> StreamMap:
        for pattern in (self.match, self.avoid, *self.prefer):
            if pattern is not None:
                try:
                    re.compile(pattern)
                except re.error as error:
                    raise ValueError(f"{pattern!r} is no regular expression ({error})") from error
        for name, channel in self.channels.items():
            _check_channel(name, channel)
        return self


class Clock(_Strict):
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


class Requires(_Strict):
    """What a log must have for the mapping to be chosen by itself: every entry (a regular expression) of each list."""

    topics: Names = ()
    types: Names = ()
    fields: Names = ()


class Mapping(_Strict):
    """A mapping file."""

    name: str
    description: str = ""
    reads: Names = Field(description="kinds of log: rosbag, ulog, crazyflie, table")
    automatic: bool = Field(True, description="may be chosen by looking at the log")
    requires: Requires = Requires()
    world: Axes = "ENU"
    body: Axes = "FLU"
    time: TimeMap | None = None
    clock: Clock = Clock()
    definitions: Names = Field((), description="files or folders with message definitions that the bag lacks")
    streams: tuple[StreamMap, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _consistent(self) -> Mapping:
        unknown = [kind for kind in self.reads if kind not in Kind.__args__]  # type: ignore[attr-defined]
        if unknown:
            raise ValueError(f"reads: {unknown[0]!r} is none of {', '.join(Kind.__args__)}")  # type: ignore[attr-defined]
        for owner in (self, *self.streams):
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


def _check_channel(name: str, mapped: ChannelMap) -> None:
    if name not in CHANNELS:
        raise ValueError(f"unknown channel {name!r}; known: {', '.join(CHANNELS)}")
    channel = CHANNELS[name]
    if mapped.euler and channel.frame != "attitude":
        raise ValueError(f"{name}: `euler` is for attitudes only")
    wanted = 3 if mapped.euler else len(channel.columns)
    if channel.numbered:
        stars = [f for f in mapped.fields if "*" in f]
        if stars and len(mapped.fields) > 1:
            raise ValueError(f"{name}: either one field with `*` or a list without it")
    elif len(mapped.fields) != wanted:
        raise ValueError(f"{name}: {len(mapped.fields)} fields, expected {wanted}")
    try:
        conversion(dimension_of(name, mapped), unit_of(name, mapped))
    except KeyError as error:
        raise ValueError(f"{name}: {error.args[0]}") from error
    if mapped.gravity_removed and name != "specific_force":
        raise ValueError(f"{name}: `gravity_removed` is for specific_force only")
    if mapped.expressed_in is not None and channel.frame not in ("world", "body"):
        raise ValueError(f"{name}: `expressed_in` is for vectors only")
    if mapped.resample == "slerp" and channel.frame != "attitude":
        raise ValueError(f"{name}: slerp is for attitudes only")
    if mapped.resample in ("linear", "mean") and channel.frame == "attitude":
        raise ValueError(f"{name}: an attitude is resampled by slerp, hold or sample")


def dimension_of(name: str, mapped: ChannelMap) -> str:
    """The dimension of a mapped channel's fields."""
    return "angle" if mapped.euler else CHANNELS[name].dimension


def unit_of(name: str, mapped: ChannelMap) -> str:
    """The unit of a mapped channel's fields; SI where the mapping names none."""
    return mapped.unit if mapped.unit is not None else SI[dimension_of(name, mapped)]


def frame_matrix(frame: Axes | None, which: Literal["world", "body"]) -> Array | None:
    """(3, 3) from the log's axes to the table's, of a named frame or of written-out axes. ValueError if unknown."""
    if frame is None:
        return None
    if isinstance(frame, str):
        known = WORLD_FRAMES if which == "world" else BODY_FRAMES
        if frame not in known:
            raise ValueError(f"{which} frame {frame!r} is none of {', '.join(known)} and no list of three axes")
        return axes_matrix(known[frame])
    return axes_matrix(frame)


@cache
def shipped() -> dict[str, Mapping]:
    """The mappings that come with the tool, by name."""
    folder = files("infotraj.importing") / "mappings"
    found = sorted((f for f in folder.iterdir() if f.name.endswith(".yaml")), key=lambda f: f.name)
    return {m.name: m for m in (parse_mapping(yaml.safe_load(f.read_text()), f.name) for f in found)}


def load_mapping(name: str | Path) -> Mapping:
    """A shipped mapping by its name, or a mapping file (YAML) by its path. UsageError where it is neither."""
    if str(name) in shipped():
        return shipped()[str(name)]
    path = Path(name)
    if not path.is_file():
        raise UsageError(
            problem(
                f"mapping {str(name)!r}: no such file",
                f"a YAML file or one of {', '.join(shipped())}",
                "Check the path.",
            )
        )
    try:
        content = yaml.safe_load(path.read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise UsageError(
            problem(f"mapping {path}: cannot be read ({error})", "YAML", "See docs/import.md for an example.")
        ) from error
    return parse_mapping(content, str(path))


def parse_mapping(content: object, source: str = "mapping") -> Mapping:
    """A mapping from the content of its file. UsageError, one line, naming `source`, where it is not valid."""
    if not isinstance(content, dict):
        raise UsageError(
            problem(f"{source}: holds {type(content).__name__}", "name, reads and streams", "See docs/import.md.")
        )
    try:
        return Mapping.model_validate(content)
    except ValidationError as error:
        raise UsageError(f"{source}: {validation_line(error)}".replace("\n", " ")) from error
