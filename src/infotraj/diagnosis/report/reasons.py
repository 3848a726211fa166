"""Why axes were not judged, in as few words as tell it. Nothing heavy is imported here: a page is drawn from it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

_TAKES = "of the error off flights that were not fitted"


def why(refused: Mapping[str, str]) -> list[tuple[str, list[str]]]:
    """Reasons, each once, with the axes it is of. What differs between axes only before the first colon (by how much,
    about which axis) is left out: the lines of the axes have it."""
    ends: dict[str, list[str]] = {}
    for axis, reason in refused.items():
        ends.setdefault(reason.split(": ", 1)[-1], []).append(axis)
    return [(refused[axes[0]] if len({refused[a] for a in axes}) == 1 else end, axes) for end, axes in ends.items()]


def about_takes(reasons: Iterable[str | None]) -> list[str]:
    """What `change` and the share that a reason says an effect takes are of, where one says so: they are two errors."""
    said = any(_TAKES in (reason or "") for reason in reasons)
    return [
        "change is of the squared error in units of its noise; "
        "what an effect takes is of the error itself (RMS), or in these units"
    ] * said


_AGAINST = {"push": "velocity against accelerometer along", "turn": "attitude against gyro about"}


def axis_in_words(axis: str) -> str:
    """An axis of the residual as it is called in a sentence: `push y` is what the sensors say of one another there."""
    kind, _, own = axis.partition(" ")
    return f"{_AGAINST[kind]} {own}" if kind in _AGAINST else axis
