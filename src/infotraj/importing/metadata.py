"""What the table says of itself: source and hash, the mapping, where each channel came from, what is derived."""

from __future__ import annotations

import hashlib
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from infotraj.flight import sha256
from infotraj.importing import convert, resample
from infotraj.importing.blackbox import split_number
from infotraj.importing.channels import CHANNELS
from infotraj.importing.mapping import Mapping
from infotraj.importing.settings import settings_text
from infotraj.importing.streams import Feed
from infotraj.rotations import Array


def channel_origin(name: str, feed: Feed, mapping: Mapping) -> dict[str, Any]:
    """Where a channel came from: topic, fields, unit, frames."""
    mapped = feed.channels[name]
    said: dict[str, Any] = {"stream": feed.stream.name, "topic": feed.topic.name, "fields": list(mapped.fields)}
    if feed.topic.instance:
        said["instance"] = feed.topic.instance
    said["unit"] = convert.unit_of(name, mapped)
    if mapped.scale != 1.0 or mapped.offset != 0.0:
        said["scale"], said["offset"] = mapped.scale, mapped.offset
    shift = feed.stream.shift + mapped.shift
    if shift != 0.0:
        said["shift_s"] = shift
    for key in ("pick", "mix", "absolute", "clip", "axes", "angle_signs"):
        value = getattr(mapped, key)
        if value not in (None, False):
            said[key] = [list(v) if isinstance(v, tuple) else v for v in value] if isinstance(value, tuple) else value
    if CHANNELS[name].frame != "none":
        frames = (convert.frame_name(mapped, feed.stream, mapping, which) for which in ("world", "body"))
        said["frames"] = [w if isinstance(w, str) else list(w) for w in frames]
        if CHANNELS[name].frame == "attitude":
            said["order"] = "roll pitch yaw" if mapped.euler else mapped.order
        else:
            said["expressed_in"] = convert.expressed_in(name, mapped)
    return said


def table_metadata(
    path: Path,
    kind: str,
    mapping: Mapping,
    zero: float,
    t: Array,
    rule: str,
    said: dict[str, Any],
    derived: dict[str, str],
    notes: list[str],
) -> dict[str, Any]:
    """The table's metadata, in plain types (it travels as JSON or YAML)."""
    limit = resample.gap_limit(t)
    found = resample.gaps(t, limit)
    meta: dict[str, Any] = {
        "source": str(path),
        "source_file": path.name,
        "source_sha256": content_hash(path),
        "kind": kind,
        "mapping": mapping.name,
        "mapping_sha256": mapping.digest(),
        **({"settings": list(settings_text(mapping.set))} if mapping.set else {}),
        "infotraj": _version(),
        "clock": {
            "rows": rule,
            "t_zero_s": zero,
            "gaps": len(found),
            "gap_longer_than_s": round(limit, 6) if np.isfinite(limit) else None,
            "longest_gap_s": round(max((b - a for a, b in found), default=0.0), 6),
        },
        "channels": said,
        "derived": sorted(derived),
        "derived_how": derived,
        "notes": list(dict.fromkeys(notes)),
    }
    return meta


def content_hash(path: Path) -> str:
    """sha256 of a file; of a folder, over the names and hashes of its files in order."""
    path, _ = split_number(path)
    if path.is_file():
        return sha256(path)
    lines = [f"{f.relative_to(path)} {sha256(f)}" for f in sorted(path.rglob("*")) if f.is_file()]
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


def _version() -> str:
    try:
        return version("infotraj")
    except PackageNotFoundError:
        return "unknown"
