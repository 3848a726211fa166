"""What of long flights a diagnosis uses: a part of each, the one in which the vehicle moves most.

Its time and memory grow with the seconds, and what is said of an effect does not: an hour of hovering says as much of
drag as a minute of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from infotraj.flight import PART, POSITION, RATE, VELOCITY, Flight
from infotraj.rotations import Array

SECONDS = 360.0  # of all flights together


def parts(
    flights: Sequence[Flight], seconds: float, start: float | None = None, stop: float | None = None
) -> tuple[list[Flight], list[str]]:
    """The flights, or of each the part that moves most if together they last longer than `seconds`; what was cut, said.

    start, stop: s, the part of every flight that is asked about. A flight that is shorter than its share leaves the
    rest of it to the others.
    """
    first, last = (-np.inf if start is None else start), (np.inf if stop is None else stop)
    asked = [(max(f.t[0], first), min(f.t[-1], last)) for f in flights]
    spans = np.array([max(b - a, 0.0) for a, b in asked])
    if spans.sum() <= seconds:
        return list(flights), []
    share = _shares(spans, seconds)
    used, said = [], []
    for f, (a, b), own, span in zip(flights, asked, share, spans, strict=True):
        if own < span:
            begin = _liveliest(f, a, b, own)
            said.append(
                f"{Path(str(f.meta.get('source', 'flight'))).name}: {own:.0f} of {span:.0f} s are used, from "
                f"{begin:.1f} s on, where it moves most; --seconds sets how many of all flights, --from and --to where"
            )
            cut = f.between(begin, begin + own)
            f = Flight(cut.table, {**cut.meta, PART: (begin, begin + own)})
        used.append(f)
    return used, said


def _shares(spans: Array, seconds: float) -> Array:
    """How much of each flight is used, s: as much of each as of any other, or all of it."""
    share = np.zeros_like(spans)
    for k, i in enumerate(np.argsort(spans)):
        share[i] = min(spans[i], (seconds - share.sum()) / (len(spans) - k))
    return share


def _liveliest(flight: Flight, start: float, stop: float, length: float) -> float:
    """When the part of this length (s) begins in which rates, else velocities, else positions vary most."""
    names = next((n for n in (RATE, VELOCITY, POSITION) if flight.has(*n)), None)
    if names is None:
        return start
    inside = (flight.t >= start) & (flight.t <= stop)
    second = (flight.t[inside] - start).astype(int)
    x = flight.get(*names)[inside]
    told = np.isfinite(x).all(axis=1)
    count = np.maximum(np.bincount(second[told], minlength=second[-1] + 1), 1)
    varies = np.zeros(len(count))
    for column in x[told].T:
        column = column - column.mean()
        mean, square = (np.bincount(second[told], v, minlength=len(count)) / count for v in (column, column**2))
        varies += np.maximum(square - mean**2, 0.0)
    # By its root: a second of landing does not outweigh a minute of flight.
    total = np.concatenate([[0.0], np.cumsum(np.sqrt(varies))])
    width = min(max(round(length), 1), len(varies))
    begin = int(np.argmax(total[width:] - total[:-width]))
    return float(min(start + begin, stop - length))
