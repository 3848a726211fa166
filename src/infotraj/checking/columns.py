"""Single columns that died while their siblings go on: a rotor that reads zero in flight, an axis that never changes.

What a column that lives does by chance is known from itself: how often a change is followed by a repeat. A run of n
repeats then has the probability p^n, and a run that no chance explains, while the siblings change, is a dead sensor. A
sensor with noise on every sample never stands still; a smooth one (an estimator, a simulation) may, and is left alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from infotraj.checking.finding import Finding, spans_text
from infotraj.checking.percent import percent
from infotraj.checking.streams import runs
from infotraj.flight import POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.rotations import Array, Mask
from infotraj.vehicle import Vehicle

SHORTEST = 0.5  # s
SURE = 16.0  # natural logarithm of the odds against chance
COARSE = 0.2  # a column that repeats so often rests on its steps: it is dead only if it jumps afterwards
JUMP = 3.0  # of its usual steps
MOST = 0.9  # of its steps are usual ones
ROUGH = 0.3  # spread of second over first differences: white noise has 1.7, a smooth signal almost none
LOST_SHARE = 0.01
FEW = 0.5  # values of so many samples are different ones, or fewer: the column rests on steps
LINE = 1e-6  # of the largest value: single precision's rounding is less


@dataclass(frozen=True)
class DeadColumn:
    """Rows (n,) in which one column holds no measurement, `value` what it holds there, `share` of the flight."""

    column: str
    rows: Mask
    value: float
    share: float


def dead_columns(flight: Flight, airborne: Mask, vehicle: Vehicle | None = None) -> list[DeadColumn]:
    """Columns of measured rotors, rates, forces, velocities and positions that died while their siblings go on."""
    rotors = _rotors(flight, vehicle)
    groups = [g for g in (rotors, RATE, SPECIFIC_FORCE, VELOCITY, POSITION) if len(g) > 1 and flight.has(*g)]
    found = []
    for columns in groups:
        x = flight.get(*columns)
        good = np.flatnonzero(np.isfinite(x).all(axis=1) & airborne)
        if len(good) < 50:
            continue
        t, x = flight.t[good], x[good]
        at = _sampled(t, x)
        dead = np.stack([_dead(t[at], x[at], c, columns == rotors) for c in range(x.shape[1])], axis=1)
        place = np.arange(len(x))  # a row between two samples is dead where both are
        dead = dead[np.searchsorted(at, place)] & dead[np.searchsorted(at, place, side="right") - 1]
        if columns == rotors:
            dead |= _stopped(x)
        for c, column in enumerate(columns):
            if dead[:, c].any():
                rows = np.zeros(len(flight.table), dtype=bool)
                rows[good[dead[:, c]]] = True
                share = float(dead[:, c].sum() / len(good))
                found.append(DeadColumn(column, rows, float(np.median(x[dead[:, c], c])), share))
    return found + _never_commanded(flight, airborne, vehicle)


def _sampled(t: Array, x: Array) -> NDArray[np.intp]:
    """Rows of x (n, k) that hold samples: all, or where most lie on straight lines between others (an import that made
    the rows of a faster stream) the ends of these lines. One sample that repeats is six rows that do not change."""
    along = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
    kink = np.abs(x[1:-1] - x[:-2] - along * (x[2:] - x[:-2])) > LINE * np.abs(x).max()
    at = np.flatnonzero(np.concatenate([[True], kink.any(axis=1), [True]]))
    return at if len(at) < 0.5 * len(x) else np.arange(len(x))


def _never_commanded(flight: Flight, airborne: Mask, vehicle: Vehicle | None) -> list[DeadColumn]:
    """Commands of one rotor that read zero for SHORTEST and more while the others carry the vehicle: never logged.

    Not where another rotor is full for most of that time: a mixer without room cuts one off.
    """
    columns = _rotors(flight, vehicle, "cmd_rotor_")
    if len(columns) < 2:
        return []
    x = flight.get(*columns)
    good = np.flatnonzero(np.isfinite(x).all(axis=1) & airborne)
    if len(good) < 50:
        return []
    t, found, full = flight.t[good], [], _full(x[good])
    for c, (column, zero) in enumerate(zip(columns, _stopped(x[good]).T, strict=True)):
        rows = np.zeros(len(flight.table), dtype=bool)
        for a, b in runs(zero):
            if t[b - 1] - t[a] >= SHORTEST and np.delete(full[a:b], c, axis=1).any(axis=1).mean() <= 0.5:
                rows[good[a:b]] = True
        if rows.any():
            found.append(DeadColumn(column, rows, 0.0, float(rows.sum() / len(good))))
    return found


def _full(x: Array) -> Mask:
    """Commands (n, rotors) that are the largest that the rotor is ever given: it has no more. Not one that hardly
    changes: that it is the same all along says nothing of its range."""
    most = x == x.max(axis=0)
    return most & (most.mean(axis=0) < 0.5)


def dead_column_findings(flight: Flight, dead: list[DeadColumn]) -> list[Finding]:
    """One finding a column: what it reads, for how long, and which answers do without it."""
    found = []
    for d in dead:
        t = flight.t
        spans = tuple((float(t[a]), float(t[b - 1])) for a, b in runs(d.rows))
        much = d.share > LOST_SHARE
        found.append(
            Finding(
                "dead_column",
                "warning" if much else "note",
                f"{d.column} reads {d.value:.4g} without a change in {percent(d.share)} of the flight, while its "
                f"siblings go on ({spans_text(spans, 2)})",
                f"a dead sensor: the column is left empty there; {_without(flight, d.column)}",
                "repair the sensor, or leave the column out of the mapping" if much else "nothing",
                sure=0.99,
                spans=spans,
                channels=(d.column,),
                values={"share": d.share, "value": d.value},
            )
        )
    return found


def _rotors(flight: Flight, vehicle: Vehicle | None, prefix: str = "rotor_") -> tuple[str, ...]:
    """The vehicle's measured rotors; without a vehicle those up to the last that ever turned: more have no motor."""
    speeds = flight.numbered(prefix)
    turned = np.flatnonzero((np.nan_to_num(speeds) != 0).any(axis=0))
    count = len(vehicle.rotors) if vehicle is not None else turned[-1] + 1 if len(turned) else 0
    return tuple(f"{prefix}{k}" for k in range(min(count, speeds.shape[1])))


def _without(flight: Flight, column: str) -> str:
    if column.startswith("cmd_"):
        return "nothing is predicted there (a rotor that was truly switched off reads so, too)"
    if not column.startswith("rotor_"):
        what = {"w": "torques", "a": "the accelerometer's forces", "v": "velocities", "p": "positions"}[column[0]]
        return f"{what} are not judged in these rows"
    if flight.has(f"cmd_{column}"):
        return "predictions rest on the commands, and measured speeds are not used"
    return "without commands nothing is predicted there (a rotor that truly stopped reads so, too)"


def _dead(t: Array, x: Array, c: int, whole: bool) -> Mask:
    """Rows (n,) in which column c repeats beyond chance while others change."""
    change = np.diff(x, axis=0) != 0
    new = np.delete(change, c, axis=1).any(axis=1)
    same = ~change[:, c]
    out = np.zeros(len(x), dtype=bool)
    if new.sum() < 50 or not same.any() or not (_noisy(x) or whole):
        return out
    changes = int(change[:, c].sum())
    repeats = runs(same)
    if not changes:
        return np.ones(len(x), dtype=bool)
    # Laplace's rule of succession; a dead stretch is one run, however long
    chance = (len(repeats) + 1) / (changes + 2)
    if chance >= 1:
        return out
    step = np.abs(np.diff(x[:, c]))
    usual = np.quantile(step[step > 0], MOST)
    extremes = x[:, c].min(), x[:, c].max()
    at_end = [x[b, c] for _, b in repeats if x[b, c] in extremes]
    beyond = [(a, b) for a, b in repeats if new[a:b].sum() * np.log(1 / chance) > SURE]
    held = [x[b, c] for _, b in beyond]
    coarse = len(np.unique(x[:, c])) < FEW * len(x)
    for a, b in beyond:
        # at the end of its range a motor idles or is saturated; a sensor that is clipped comes back there
        if x[b, c] in extremes and (whole or at_end.count(x[b, c]) > 1):
            continue
        if new[a:b].sum() <= 0.5 * (b - a) or t[b] - t[a] < SHORTEST:
            continue
        after = abs(x[b + 1, c] - x[b, c]) if b + 1 < len(x) else np.inf
        # a value that is held time and again is one of the steps on which a coarse column rests
        if (chance < COARSE and not (coarse and held.count(x[b, c]) > 1)) or after > JUMP * usual:
            out[a : b + 1] = True
    return out


def _stopped(x: Array) -> Mask:
    """Readings (n, rotors) of exactly zero while most others run at half their usual speed or more."""
    size = np.abs(x)
    usual = np.array([np.median(s[s > 0]) if (s > 0).any() else 0.0 for s in size.T])
    live = usual > 0
    running = (size > 0.5 * usual) & live
    others = (running.sum(axis=1)[:, None] - running) / max(live.sum() - 1, 1)
    return (x == 0) & (others > 0.5)


def _noisy(x: Array) -> bool:
    """Whether one of the columns, where it changes, has noise on every sample."""
    for k in range(x.shape[1]):
        y = x[:, k]
        first = np.diff(y)
        moving = first[first != 0]
        if len(moving) > 20 and np.median(np.abs(np.diff(moving))) > ROUGH * np.median(np.abs(moving)):
            return True
    return False
