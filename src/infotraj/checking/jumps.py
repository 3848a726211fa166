"""Columns that jump and go on elsewhere: a counter or an angle that wraps round, a value that changes its sign.

A wrap leads from one end of the column's range to the other within one sample; a flip leads from x to -x. Between two
such jumps a column that is not an angle holds wrong values.
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

# A jump is so many times what 95 % of the steps stay below.
JUMP = 5.0
END = 0.1  # share of the range that counts as its end
MIDDLE = 0.3  # share of the samples away from both ends: a signal that switches between two values does not wrap
LARGE = 0.3  # of the largest usual size: smaller values may well change their sign
GAP = 3.5  # usual steps
SPIKE = 5  # samples: what comes back so soon is a spike
MODULI = ((2 * np.pi, "2 pi"), (360.0, "360"), (65536.0, "2^16"), (256.0, "2^8"))


@dataclass(frozen=True)
class Jumped:
    """A column that wraps round ("wrapped") or changes its sign ("sign_flips"): times (s) of the jumps, their size,
    and the rows (n,) between jumps that hold wrong values."""

    code: str
    column: str
    times: Array
    size: float
    rows: Mask


def jumped_columns(flight: Flight, airborne: Mask) -> list[Jumped]:
    """The measured columns, and commanded tilts, that wrap or flip in flight."""
    names = [c for g in (POSITION, VELOCITY, RATE, SPECIFIC_FORCE) if flight.has(*g) for c in g]
    for prefix in ("rotor_", "tilt_", "cmd_tilt_"):
        names += [f"{prefix}{k}" for k in range(flight.numbered(prefix).shape[1])]
    return [found for name in names if (found := _jumped(flight, name, airborne)) is not None]


def jump_findings(flight: Flight, jumped: list[Jumped]) -> list[Finding]:
    """One finding a column: a warning, for someone has to look at the logger."""
    found = []
    for j in jumped:
        when = spans_text(tuple((float(t), float(t)) for t in j.times), 3)
        angle = "tilt_" in j.column
        if j.code == "wrapped":
            name = next((f" ({text})" for m, text in MODULI if abs(j.size / m - 1) < 0.03), "")
            what = f"{j.column} wraps round {len(j.times)} times by {j.size:.4g}{name}, at {when}"
        else:
            what = f"{j.column} changes its sign {len(j.times)} times at {j.size / 2:.4g}, at {when}"
        share = float(j.rows.mean())
        found.append(
            Finding(
                j.code,
                "warning",
                what,
                "the angle between two samples across a jump is wrong"
                if angle
                else f"the rows between two jumps ({percent(share)} of the log) are left empty",
                "unwrap it before the import" if j.code == "wrapped" else "repair the sign before the import",
                sure=0.95,
                spans=tuple((float(flight.t[a]), float(flight.t[b - 1])) for a, b in runs(j.rows)),
                channels=(j.column,),
                values={"count": len(j.times), "size": j.size},
            )
        )
    return found


def _jumped(flight: Flight, column: str, airborne: Mask) -> Jumped | None:
    x = flight.get(column)[:, 0]
    good = np.flatnonzero(np.isfinite(x) & airborne)
    if len(good) < 100:
        return None
    t, x = flight.t[good], x[good]
    step, dt = np.diff(x), np.diff(t)
    moving = np.abs(step[step != 0])
    low, high = float(x.min()), float(x.max())
    if len(moving) < 50 or high <= low:
        return None
    far = (np.abs(step) > JUMP * np.percentile(moving, 95)) & (dt < GAP * np.median(dt))
    if not far.any():
        return None
    reach = high - low
    inner = ((x > low + END * reach) & (x < high - END * reach)).mean()
    wraps = far & (np.abs(step) > (1 - 2 * END) * reach) if inner > MIDDLE else np.zeros_like(far)
    flips = (
        far & (np.abs(x[1:] + x[:-1]) < 0.1 * np.abs(step)) & (np.abs(step) / 2 > LARGE * np.percentile(np.abs(x), 95))
    )
    both = wraps & flips
    if both.any():
        # from one end to the other is also from x to -x where the range is symmetric: the slope tells
        other = flips if _slope_goes_on(x, np.flatnonzero(both)) else wraps
        other &= ~both
    for code, at in (("sign_flips", flips), ("wrapped", wraps)):
        jumps = np.flatnonzero(at)
        if 2 * len(jumps) < far.sum():
            continue  # a wheel on grass jumps far all the time, by chance to -x or to the other end
        size = float(np.median(np.abs(step[jumps]))) if len(jumps) else 0.0
        if not len(jumps) or not _lasts(at, step) or (len(jumps) == 1 and (code == "sign_flips" or not _known(size))):
            continue
        if code == "sign_flips" and column.startswith(("tilt_", "cmd_")):
            continue
        rows = np.zeros(len(flight.table), dtype=bool)
        if "tilt_" not in column:
            other = np.concatenate([[0], np.cumsum(np.where(at, np.sign(step), 0.0))])
            usual = np.median(other)
            rows[good[other != usual]] = True
        return Jumped(code, column, t[jumps + 1], size, rows)
    return None


def _lasts(at: Array, step: Array) -> bool:
    """Whether the column stays away for more than a few samples: else these are spikes."""
    level = np.concatenate([[0], np.cumsum(np.where(at, np.sign(step), 0.0))])
    longest = [max(b - a for a, b in runs(level == value)) for value in np.unique(level)]
    return sum(length > SPIKE for length in longest) > 1


def _slope_goes_on(x: Array, jumps: NDArray[np.intp]) -> bool:
    """Whether the slope after the jumps is that before them, as in a wrap; a change of sign turns it round."""
    inside = jumps[(jumps >= 3) & (jumps + 4 < len(x))]
    return bool(np.sum((x[inside] - x[inside - 3]) * (x[inside + 4] - x[inside + 1])) > 0)


def _known(size: float) -> bool:
    return any(abs(size / m - 1) < 0.03 for m, _ in MODULI)
