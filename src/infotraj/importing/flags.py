"""What the log's own flags say about being in the air: landed, armed, flying.

A flag that can only exclude flight (disarmed) says 0 or nothing (NaN); one that knows (landed or not) says 0 or 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from infotraj.rotations import Array


def as_flags(values: Array, states: Mapping[int, int | None]) -> Array:
    """Numbers of the log (n, 1) as 1, 0 or NaN by `states`; a number that is not listed changes nothing."""
    out = np.full(values.shape, np.nan)
    listed = np.isin(values, list(states))
    for number, said in states.items():
        out[values == number] = np.nan if said is None else float(said)
    # events among which only some speak of flight: the last one that did holds
    last = np.maximum.accumulate(np.where(listed[:, 0], np.arange(len(values)), -1))
    return np.where((last >= 0)[:, None], out[np.maximum(last, 0)], np.nan)


def in_the_air(said: list[Array], knows: Sequence[bool]) -> Array:
    """What several flags (n, 1) say together: 0 where any does, else 1 where any does, else NaN.

    knows: whether each can say "in the air". One that can, and says "on the ground" from its first message to the end,
    does not count beside one that says "in the air": a plane's events tell of arming alone. All NaN where no row is
    said to be in the air and some rows behind the first message are open: such flags cannot tell the flight, and rows
    that they leave open must not count as ground.
    """
    flies = any((flag == 1).any() for flag in said)
    counts = [not (flies and k and _always_ground(flag[:, 0])) for flag, k in zip(said, knows, strict=True)]
    stacked = np.concatenate([flag for flag, c in zip(said, counts, strict=True) if c], axis=1)
    excluded, flying = (stacked == 0).any(axis=1), (stacked == 1).any(axis=1)
    out = np.where(excluded, 0.0, np.where(flying, 1.0, np.nan))[:, None]
    known = np.isfinite(out[:, 0])
    tells = (out == 1).any() or (known.any() and known[int(np.argmax(known)) :].all())
    return out if tells else np.full_like(out, np.nan)


def _always_ground(flag: Array) -> bool:
    known = np.isfinite(flag)
    return bool(known.any() and (flag[int(np.argmax(known)) :] == 0).all())
