"""Why axes were not judged, in as few words as tell it. Nothing heavy is imported here: a page is drawn from it."""

from __future__ import annotations

from collections.abc import Mapping


def why(refused: Mapping[str, str]) -> list[tuple[str, list[str]]]:
    """Reasons, each once, with the axes it is of. What differs between axes only before the first colon (by how much,
    about which axis) is left out: the lines of the axes have it."""
    ends: dict[str, list[str]] = {}
    for axis, reason in refused.items():
        ends.setdefault(reason.split(": ", 1)[-1], []).append(axis)
    return [(refused[axes[0]] if len({refused[a] for a in axes}) == 1 else end, axes) for end, axes in ends.items()]
