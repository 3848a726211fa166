"""Flights whose accelerometer shows vibration and little else: their forces are told from the velocity."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from infotraj.checking.acceptance import accepted_codes
from infotraj.comparing.shaken import CODE, said, shaken, told_by_velocity
from infotraj.diagnosis.gates.doubt import Doubt
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.rotations import Array

_NAMED = 3  # flights that a note names


def unshaken(
    model: Model,
    flights: Sequence[Flight],
    start: float | None = None,
    stop: float | None = None,
    together: bool = False,
) -> tuple[list[Flight], tuple[Doubt, ...]]:
    """The flights, each marked whose accelerometer is shaken and whose user does not accept that; and the notes that
    say so, which refuse nothing.

    Where more than half of them are, all are marked: it is the mount that vibrates. together: they are held against one
    another, and all are read as one of them has to be.
    """
    found = [shaken(model, f, start, stop) for f in flights]
    accepted = [e is not None and CODE in accepted_codes(f) for e, f in zip(found, flights, strict=True)]
    marked = [e is not None and not a for e, a in zip(found, accepted, strict=True)]
    every = any(marked) if together else 2 * sum(marked) > len(flights)
    told = [m or (every and not a) for m, a in zip(marked, accepted, strict=True)]
    kinds = ((told, marked, "velocity"), (accepted, accepted, "accelerometer"))
    notes = tuple(_note(found, own, whose, flights, side) for own, whose, side in kinds if any(own))
    return [told_by_velocity(f) if m else f for f, m in zip(flights, told, strict=True)], notes


def _note(
    found: Sequence[tuple[Array, Array] | None],
    chosen: Sequence[bool],
    shaken_ones: Sequence[bool],
    flights: Sequence[Flight],
    side: str,
) -> Doubt:
    names = [Path(str(f.meta.get("source", f"flight {k}"))).name for k, f in enumerate(flights) if chosen[k]]
    which = "" if len(names) == len(flights) else f" of {', '.join(names)}"
    if which and len(names) > _NAMED:
        which = f" of {len(names)} of {len(flights)} flights"
    first = next(e for e, own in zip(found, shaken_ones, strict=True) if own and e is not None)
    reason = f"forces{which} are told from the {side}: {said(first)}"
    return Doubt(CODE, "accelerometer", (), reason, refuses=False, accepted=side == "accelerometer")
