"""Settings: single keys of a mapping's channels, replaced for one log. What `--set`, `set:` and a finding's remedy say.

`rate.unit=deg/s` replaces the key `unit` of the channel `rate` in every stream of the mapping that has the channel,
`rotor_command.instance=1` that of these streams themselves;
`time.unit=ms` replaces it in every time of the mapping. Values are YAML.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import yaml
from pydantic import ValidationError

from infotraj.errors import UsageError, problem
from infotraj.importing.channel_map import ChannelMap, check_channel, unit_of
from infotraj.importing.channels import CHANNELS
from infotraj.importing.mapping import Mapping, StreamMap, TimeMap
from infotraj.vehicle import validation_line

Settings = dict[str, dict[str, Any]]
_OF_STREAM = ("instance",)
_EXPECTED = "CHANNEL.KEY=VALUE, for example rate.unit=deg/s"


def parse_settings(texts: Iterable[str]) -> Settings:
    """Settings from `CHANNEL.KEY=VALUE`, the later of two for one key. UsageError, one line, where one is none."""
    found: Settings = {}
    for text in texts:
        name, equals, value = text.partition("=")
        channel, dot, key = name.strip().partition(".")
        if not (equals and dot and channel and key):
            raise UsageError(problem(f"--set {text}", _EXPECTED, f"Channels: {', '.join(CHANNELS)}; or time."))
        _require_key(channel, key)
        try:
            found.setdefault(channel, {})[key] = yaml.safe_load(value)
        except (yaml.YAMLError, ValueError, RecursionError) as error:
            raise UsageError(problem(f"--set {text}: the value is no YAML", _EXPECTED, "Correct it.")) from error
    return found


def settings_text(settings: Settings) -> tuple[str, ...]:
    """The settings as `CHANNEL.KEY=VALUE`, as `parse_settings` reads them."""
    return tuple(f"{c}.{k}={_value_text(v)}" for c, keys in settings.items() for k, v in keys.items())


def merged(old: Settings, new: Settings) -> Settings:
    """Both; where both name a key, the new one."""
    return {c: {**old.get(c, {}), **new.get(c, {})} for c in dict.fromkeys([*old, *new])}


def with_settings(mapping: Mapping, settings: Settings) -> Mapping:
    """The mapping with these keys replaced, and noted in its `set`. UsageError where it has no such channel or key."""
    if not settings:
        return mapping
    carried = {c for s in mapping.streams for c in s.channels}
    for channel, keys in settings.items():
        for key in keys:
            _require_key(channel, key)
        if channel != "time" and channel not in carried:
            raise UsageError(
                problem(
                    f"set {channel}: mapping {mapping.name} has no such channel",
                    ", ".join(c for c in CHANNELS if c in carried),
                    "Map it under `streams` in a mapping file (`extends: NAME`).",
                )
            )
    time = settings.get("time", {})
    streams = tuple(_stream(s, settings, time) for s in mapping.streams)
    declared = _replaced(mapping.time, time, "time") if time and mapping.time is not None else mapping.time
    if time and declared is None and not any(s.time for s in mapping.streams):
        declared = _replaced(TimeMap(fields=("",)), time, "time") if "fields" in time else _no_time(mapping)
    changes = {"streams": streams, "time": declared, "set": merged(mapping.set, settings)}
    return mapping.model_copy(update=changes)


def same_reading(one: Mapping, other: Mapping) -> bool:
    """True where both read a log alike; a default that is written out makes no difference."""
    return one.time == other.time and [_written_out(s) for s in one.streams] == [_written_out(s) for s in other.streams]


def _written_out(stream: StreamMap) -> StreamMap:
    channels = {
        name: mapped.model_copy(
            update={
                "unit": unit_of(name, mapped),
                "expressed_in": mapped.expressed_in or CHANNELS[name].frame,
                "resample": mapped.resample or CHANNELS[name].resample,
            }
        )
        for name, mapped in stream.channels.items()
    }
    return stream.model_copy(update={"channels": channels})


def _stream(stream: StreamMap, settings: Settings, time: dict[str, Any]) -> StreamMap:
    of_channel = {
        name: {k: v for k, v in settings.get(name, {}).items() if k not in _OF_STREAM} for name in stream.channels
    }
    channels = {
        name: _channel(name, mapped, of_channel[name]) if of_channel[name] else mapped
        for name, mapped in stream.channels.items()
    }
    declared = _replaced(stream.time, time, "time") if time and stream.time is not None else stream.time
    changed = stream.model_copy(update={"channels": channels, "time": declared})
    for name in stream.channels:
        of_stream = {k: v for k, v in settings.get(name, {}).items() if k in _OF_STREAM}
        changed = _replaced(changed, of_stream, name) if of_stream else changed
    return changed


def _channel(name: str, mapped: ChannelMap, keys: dict[str, Any]) -> ChannelMap:
    # A remark is of the mapping's own fields.
    changed = _replaced(mapped, {"remark": None, **keys} if "fields" in keys else keys, name)
    try:
        check_channel(name, changed)
    except ValueError as error:
        raise UsageError(" ".join(f"set {error}".split())) from error
    return changed


def _replaced(part: Any, keys: dict[str, Any], name: str) -> Any:
    kept = {k: v for k, v in part.model_dump(exclude_defaults=True).items() if k not in keys}
    given = {k: v for k, v in keys.items() if v is not None}
    try:
        return type(part).model_validate(kept | given)
    except (ValidationError, RecursionError) as error:
        line = validation_line(error, type(part)) if isinstance(error, ValidationError) else "nested too deeply"
        raise UsageError(" ".join(f"set {name}.{line}".split())) from error


def _require_key(channel: str, key: str) -> None:
    if channel != "time" and channel not in CHANNELS:
        raise UsageError(
            problem(f"set {channel}.{key}: unknown channel", ", ".join((*CHANNELS, "time")), "Correct the name.")
        )
    known = tuple(TimeMap.model_fields) if channel == "time" else (*ChannelMap.model_fields, *_OF_STREAM)
    if key not in known:
        raise UsageError(problem(f"set {channel}.{key}: unknown key", ", ".join(known), "Correct it."))


def _no_time(mapping: Mapping) -> TimeMap:
    raise UsageError(
        problem(f"set time: mapping {mapping.name} names no time", "time.fields=NAME", "Set the fields, too.")
    )


def _value_text(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return "[" + ",".join(_value_text(v) for v in value) + "]"
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: ""}[value]
    return f"{value:.10g}" if isinstance(value, float) else str(value)
