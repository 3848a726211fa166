"""Sample-and-hold streams: a logger faster than a sensor repeats the sensor's last sample until the next one comes.

A repeated row is no sample. What tells it from a sample that happens to be equal (a quantised or a resting channel) is
the other columns of the stream: a row in which one of them changes is certainly a new sample, so the share of such
rows in which a column keeps its value is that column's chance to repeat by itself. Rows that repeat every column at
once, far more often than the least of these chances, are held. Not so a channel in coarse steps: most of its changes
are by one step, or it comes back to values that it had before, which a sensor's last bits never do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from infotraj.checking.finding import Finding
from infotraj.checking.percent import percent
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.rotations import Array, Mask

SPAN = 2.0  # s that are judged together: rest and flight have different chances
FEWEST = 40  # rows that are judged together, where SPAN has fewer
FEWEST_NEW = 8  # new samples without which nothing can be said
# Held beyond chance: this many times the chance, and by this share of the rows.
TIMES_CHANCE = 2.0
BEYOND_CHANCE = 0.03
# A stream whose new samples equal an earlier one, not the last, so often is written in coarse steps.
COMES_BACK = 0.05


@dataclass(frozen=True)
class Held:
    """One measured stream: `rows` (n,) that repeat its last sample, the rate of its samples and of its rows (Hz).

    `always`: it is held throughout, by a logger that is faster; else only now and then, where samples were lost.
    """

    columns: tuple[str, ...]
    rows: Mask
    hz: float
    row_hz: float
    always: bool

    @property
    def period(self) -> float:
        """Usual time between samples (s)."""
        return 1 / self.hz


def measured_groups(flight: Flight) -> list[tuple[str, ...]]:
    """Columns that sensors write together, by name; commands, references and the battery are none of them."""
    fixed = [g for g in (POSITION, ATTITUDE, VELOCITY, RATE, SPECIFIC_FORCE) if flight.has(*g)]
    counted = []
    for prefix in ("rotor_", "tilt_"):
        count = flight.numbered(prefix).shape[1]
        if count:
            counted.append(tuple(f"{prefix}{k}" for k in range(count)))
    return fixed + counted


def held_streams(flight: Flight, airborne: Mask) -> list[Held]:
    """Every measured stream of 20 samples or more, with the rows in which it repeats itself."""
    return [held for g in measured_groups(flight) if (held := _held(flight, g, airborne)) is not None]


def repeat_chance(x: Array) -> float:
    """The chance that a new sample repeats all columns of the last one, from the samples x (n, c); NaN if unknown.

    It is at most that of the column that repeats most rarely: where another column changed, or, for one in steps, by
    the share of its changes that are a single step (a normal change of s steps repeats half as often as it is one).
    """
    change = np.diff(x, axis=0) != 0
    count = change.sum(axis=1)
    out = np.full(x.shape[1], np.nan)
    for c in range(x.shape[1]):
        new = count - change[:, c] > 0
        if new.sum() < FEWEST_NEW:
            continue
        # Laplace's rule of succession: few samples leave much to chance.
        seen = ((~change[new, c]).sum() + 1) / (new.sum() + 2)
        step = np.abs(np.diff(x[:, c]))[change[:, c]]
        single = float((step < 1.5 * step.min()).mean()) if len(step) else 0.0
        out[c] = max(seen, 0.5 * single + 0.5 * single**8)
    return float("nan") if np.isnan(out).all() else float(np.nanmin(out))


def held_findings(held: Sequence[Held], airborne: Mask) -> list[Finding]:
    """One note about the streams that repeat their samples, throughout or now and then."""
    said, values = [], {}
    for h in held:
        share = float((h.rows & airborne).sum() / max(airborne.sum(), 1))
        if h.always:
            said.append(f"{_name(h)} at {h.hz:.3g} Hz in rows of {h.row_hz:.3g} Hz")
        elif share > 0:
            said.append(f"{_name(h)} now and then ({percent(share)} of the flight)")
        else:
            continue
        values[_name(h)] = {"hz": h.hz, "row_hz": h.row_hz, "share": share}
    if not said:
        return []
    return [
        Finding(
            "held",
            "note",
            f"samples are repeated until the next one comes: {', '.join(said)}",
            "repeated rows are no samples: they are left empty, and what is derived from them is derived anew",
            "nothing; a log at the sensors' own rates says the same in less space",
            channels=tuple(c for h in held if _name(h) in values for c in h.columns),
            values=values,
        )
    ]


def rates(held: Sequence[Held]) -> dict[str, dict[str, Any]]:
    """For each measured stream the rate of its samples, and of the rows over which they are held (else None), Hz."""
    return {_name(h): {"hz": h.hz, "held_from_hz": h.row_hz if h.always else None} for h in held}


def _name(held: Held) -> str:
    return held.columns[0] if len(held.columns) == 1 else f"{held.columns[0]}..{held.columns[-1]}"


def _held(flight: Flight, columns: tuple[str, ...], airborne: Mask) -> Held | None:
    x = flight.get(*columns)
    where = np.flatnonzero(np.isfinite(x).all(axis=1))
    if len(where) < 20:
        return None
    t, air = flight.t[where], airborne[where]
    x = x[where]
    same = (np.diff(x, axis=0) == 0).all(axis=1)
    rows = np.zeros(len(flight.table), dtype=bool)
    row_hz = _hz(t)
    said = [(part, _beyond_chance(x[part.start : part.stop + 1])) for part in _parts(t)]
    votes = [yes for _, yes in said if yes is not None]
    always = bool(votes) and np.mean(votes) > 0.5
    for part, yes in said:
        if yes or (always and yes is None):
            repeats = np.flatnonzero(same[part]) + part.start + 1
            rows[where[repeats if always else repeats[air[repeats]]]] = True
    hz = _hz(t[~rows[where]]) if always else row_hz
    return Held(columns, rows, hz, row_hz, bool(always))


def _parts(t: Array) -> list[slice]:
    """The steps between samples in parts of SPAN, each of FEWEST steps or more where the log has them."""
    size = max(FEWEST, int(SPAN / max(float(np.median(np.diff(t))), 1e-6)))
    edges = [*range(0, max(len(t) - 1 - size // 2, 1), size), len(t) - 1]
    return [slice(a, b) for a, b in pairwise(edges)]


def _beyond_chance(x: Array) -> bool | None:
    """Whether whole samples repeat more often than chance has it; None where nothing moves enough to tell."""
    chance = repeat_chance(x)
    if np.isnan(chance):
        return None
    same = (np.diff(x, axis=0) == 0).all(axis=1)
    if same.mean() <= max(TIMES_CHANCE * chance, chance + BEYOND_CHANCE):
        return False
    new = x[np.concatenate([[True], ~same])]
    return len(np.unique(new, axis=0)) > (1 - COMES_BACK) * len(new)


def _hz(t: Array) -> float:
    step = np.diff(t)
    usual = step[step < 3.5 * np.median(step)]
    return float(1 / usual.mean()) if len(usual) else float(1 / step.mean())
