"""What a finding says of a flight as it was imported, as keys of the mapping that it was imported with.

A finding knows the table: its rates have other axes, its clock is late. The mapping may have turned and shifted on the
way there already. So a further shift or offset is added to what the mapping says, scales and signs of angles are
multiplied, axes and frames turned on top, and the order of a quaternion is that of the log's fields. What is said of
the log itself (a unit, the axes that a vector is expressed in) stays as it is. What is said of a channel that the
mapping lacks (it was derived) is left out: it follows from the channels that it comes from.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from infotraj.errors import UsageError
from infotraj.importing.channel_map import ChannelMap, frame_matrix
from infotraj.importing.channels import CHANNELS
from infotraj.importing.convert import expressed_in, frame_of
from infotraj.importing.frames import BODY_FRAMES, WORLD_FRAMES, axes_matrix
from infotraj.importing.mapping import Mapping, StreamMap
from infotraj.importing.settings import Settings, parse_settings, settings_text
from infotraj.importing.streams import Plan
from infotraj.importing.units import UNITS
from infotraj.rotations import Array

# A log's w x y z that was read as x y z w stands in the table's w x y z as z w x y.
_READ_AS = {"xyzw": "xyzw", "wxyz": "zwxy"}


def on_top(found: Plan, texts: tuple[str, ...]) -> tuple[str, ...]:
    """Settings about the imported table as `--set` takes them with this mapping; unreadable ones as they are."""
    try:
        wanted = parse_settings(texts)
    except UsageError:
        return texts
    out: Settings = {}
    if "unit" in wanted.get("time", {}):
        wanted["time"]["unit"] = _time_unit(wanted["time"]["unit"], found.mapping)
    carried = {"time", *(c for s in found.mapping.streams for c in s.channels)}
    for channel, keys in wanted.items():
        if channel not in carried:
            continue
        feed = found.feed_of(channel)
        if feed is not None:
            keys = _as_expressed(channel, keys, feed.channels[channel], wanted.get("attitude", {}))
        for key, value in keys.items():
            if feed is not None:
                value = _composed(key, value, feed.channels[channel], feed.stream, found.mapping)
            out.setdefault(channel, {})[key] = value
    return settings_text(out)


def _as_expressed(channel: str, keys: dict[str, Any], mapped: ChannelMap, attitude: dict[str, Any]) -> dict[str, Any]:
    """The keys with a turn of the table's frame as one of the frame that the log has the vector in.

    v_world = R v_body, and turning both frames makes R' = W R B^-1: so W v_world = R' (B v_body). A velocity that is
    logged in body axes takes the body's turn where the table's takes the world's; the attitude takes both.
    """
    frame, logged = CHANNELS[channel].frame, expressed_in(channel, mapped)
    if frame == logged or frame not in keys or logged not in attitude:
        return keys
    return {(logged if key == frame else key): (attitude[logged] if key == frame else v) for key, v in keys.items()}


def _composed(key: str, value: Any, mapped: ChannelMap, stream: StreamMap, mapping: Mapping) -> Any:
    try:
        if key in ("shift", "offset"):
            return round(getattr(mapped, key) + float(value), 9)
        if key == "scale":
            return float(f"{mapped.scale * float(value):.9g}")
        if key == "axes":
            old = axes_matrix(mapped.axes, mirrored=True) if mapped.axes is not None else np.eye(3)
            return _axes(axes_matrix(value, mirrored=True) @ old)
        if key == "angle_signs" and mapped.angle_signs is not None:
            return [new * old for new, old in zip(value, mapped.angle_signs, strict=True)]
        if key == "world" or key == "body":
            which: Literal["world", "body"] = "world" if key == "world" else "body"
            further = frame_matrix(tuple(value) if isinstance(value, list) else value, which)
            return value if further is None else _frame(key, further @ frame_of(mapped, stream, mapping, key))
        if key == "order":
            letters = dict(zip("wxyz", _READ_AS[value], strict=True))
            return "".join(letters[letter] for letter in mapped.order)
        if key == "rotates" and value == mapped.rotates == "world_to_body":
            return "body_to_world"
    except (TypeError, ValueError, KeyError):
        return value
    return value


def _time_unit(said: str, mapping: Mapping) -> str:
    """The unit of a log's time whose table, read as the mapping says, seemed to be in `said` instead of in s."""
    declared = mapping.time or next((s.time for s in mapping.streams if s.time is not None), None)
    size = UNITS["time"][said][0] * (UNITS["time"][declared.unit][0] if declared is not None else 1.0)
    return next((unit for unit, (factor, _) in UNITS["time"].items() if np.isclose(factor, size)), said)


def _frame(key: str, matrix: Array) -> Any:
    named = WORLD_FRAMES if key == "world" else BODY_FRAMES
    axes = tuple(_axes(matrix))
    return next((name for name, known in named.items() if known == axes), list(axes))


def _axes(matrix: Array) -> list[str]:
    columns = np.argmax(np.abs(matrix), axis=1)
    return [("-" if matrix[k, c] < 0 else "") + "xyz"[c] for k, c in enumerate(columns)]
