"""Whether prediction and measurement belong together: their correlation at the best lag, its sign, and that lag."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.comparing.floor import fast_part
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

LEAST = 0.3  # correlation below which a loud prediction is unrelated to a loud measurement
_LOUD = 5.0  # times the floor
_COMPARABLE = 0.4  # of the measured side's size: a smaller prediction does not claim to explain it
_LAGS = (-0.3, 0.4)  # s, response behind prediction
_NEAR = (-0.05, 0.2)  # s, where actuators' lags and delays can put it
_CLEAR = 0.6
_UNRELATED = 0.2  # where one axis alone is to decide
_LEAD = 0.015  # s beyond the slowest declared actuator: an earlier response is against causality
_DRIFT = 2.0  # s: slower changes are left out, they may be anything


def contradictions(errors: Sequence[EquationError], vehicle: Vehicle) -> dict[str, str]:
    """`commands`: prediction unrelated or opposite to what was measured; `time stamps`: response before cause."""
    found: dict[str, str] = {}
    if not errors:
        return found
    step = max(0.01, float(np.median(np.concatenate([np.diff(e.t) for e in errors]))))
    lags = np.arange(_LAGS[0], _LAGS[1] + step / 2, step)
    total, weight = np.zeros(len(lags)), 0.0
    against: list[str] = []
    unrelated: list[str] = []
    faint: list[str] = []
    loud, worst = 0, 1.0
    for i, axis in enumerate(AXES):
        pairs = [p for e in errors if (p := _even(e, i, step)) is not None]
        floor = [x for e in errors if np.isfinite(x := _noise(e, i))]
        if not pairs or not floor:
            continue
        measured, predicted = (np.sqrt(np.mean(np.concatenate([p[k] for p in pairs]) ** 2)) for k in (0, 1))
        noise = float(np.mean(floor))
        if measured < _LOUD * noise or predicted < _LOUD * noise:
            continue
        r = np.array([_correlation(pairs, round(lag / step)) for lag in lags])
        loud += 1
        near = r[(lags > _NEAR[0]) & (lags < _NEAR[1])].max()
        # Slow signals agree at some lag by chance; only where they do so well is that lag the fault.
        fits = float(r.max() if r.max() > _CLEAR else near)
        if predicted < _COMPARABLE * measured:
            faint += [f"{axis} ({fits:.2f})"] if fits < LEAST else []
            continue
        if fits < LEAST:
            opposite = -r.min() > 0.6 and abs(lags[int(r.argmin())]) < 0.1
            worst = min(worst, fits)
            (against if opposite else unrelated).append(f"{axis} ({r.min() if opposite else fits:.2f})")
        elif r.max() > _CLEAR:
            total += r
            weight += 1.0
    # One torque of a vehicle that pushes sideways may be small, and drowned by an effect; of two this is not so.
    alone = len(unrelated) == 1 and (vehicle.tilts or worst > _UNRELATED)
    if against or (unrelated and not alone) or (len(faint) >= 2 and 2 * len(faint) > loud):
        parts = []
        if against:
            parts.append(f"the opposite of what was measured on {', '.join(against)}")
        if unrelated or not against:
            parts.append(f"unrelated to what was measured on {', '.join(unrelated + faint)}")
        found["commands"] = (
            f"what the actuators predict is {' and '.join(parts)} (correlation): actuators and motion do not belong "
            f"together (order of columns, spin or tilt axes in the vehicle file, commands of another flight)"
        )
    if weight and not found:
        best = float(lags[int(total.argmax())])
        slowest = max([*vehicle.input_time_constants, *(x.time_constant for x in vehicle.tilts)])
        if best < -(slowest + _LEAD + step):
            found["time stamps"] = (
                f"the vehicle responds {-1000 * best:.0f} ms before its commands: they are stamped late or held, and "
                f"no effect of the actuators can be told from that"
            )
    return found


def _noise(e: EquationError, i: int) -> float:
    """The floor of one axis; where unrelated commands make the error itself rough, how rough the measured side is."""
    return float(np.fmin(e.floor[i], fast_part(e.t, e.measured[:, i : i + 1], e.window)[0]))


def _even(e: EquationError, i: int, step: float) -> tuple[Array, Array] | None:
    """Measured and predicted side of one axis on an even grid, changes slower than `_DRIFT` taken off."""
    rows = np.flatnonzero(e.scored[:, i] & np.isfinite(e.predicted[:, i]))
    if len(rows) < 100:
        return None
    grid = np.arange(e.t[rows[0]], e.t[rows[-1]], step)
    if len(grid) < 100:
        return None
    sides = [
        _without_drift(np.interp(grid, e.t[rows], x[rows, i]), round(_DRIFT / step)) for x in (e.measured, e.predicted)
    ]
    return sides[0], sides[1]


def _without_drift(x: Array, width: int) -> Array:
    sums = np.cumsum(np.concatenate([[0.0], x]))
    low = np.maximum(np.arange(len(x)) - width // 2, 0)
    high = np.minimum(np.arange(len(x)) + width // 2 + 1, len(x))
    return x - (sums[high] - sums[low]) / (high - low)


def _correlation(pairs: Sequence[tuple[Array, Array]], shift: int) -> float:
    """Correlation of the measured side with the prediction `shift` samples before."""
    ab = aa = bb = 0.0
    for a, b in pairs:
        n = len(a) - abs(shift)
        if n < 20:
            continue
        x, y = (a[shift:], b[:n]) if shift >= 0 else (a[:n], b[-shift:])
        ab, aa, bb = ab + float(x @ y), aa + float(x @ x), bb + float(y @ y)
    return ab / np.sqrt(aa * bb) if aa * bb > 0 else 0.0
