"""Whether prediction and measurement belong together: their correlation at the best lag, its sign, and that lag."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.comparing.floor import fast_part
from infotraj.diagnosis.gates.doubt import Doubt, reached
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

LEAST = 0.3  # correlation below which a loud prediction is unrelated to a loud measurement
_LOUD = 5.0  # times the floor
_COMPARABLE = 0.4  # of the measured side's size: a smaller prediction does not claim to explain it
_LAGS = (-0.3, 0.4)  # s, response behind prediction
_NEAR = (-0.05, 0.2)  # s, where actuators' lags and delays can put it
_CLEAR = 0.6
_FOLLOWS = 0.9  # where other axes do not: the motion is that of these commands
_UNRELATED = 0.2  # where one axis alone is to decide
_LEAD = 0.015  # s beyond the slowest declared actuator: an earlier response is against causality
_ALIKE = 0.02  # s by which the lags of axes and flights may differ where one shift of the clock makes them
_UNDONE = 0.2  # of the disagreement that a shift of the clock leaves
_BAD = 0.1  # 1 - r^2 as stamped: with less the model says enough of the motion as it is
_BEFORE = "response_before_command"
_DRIFT = 2.0  # s: slower changes are left out, they may be anything
_AT_ONCE = 0.5  # s: the same where the air may balance slower torques of the rotors
_HARDLY_LATE = (-0.03, 0.08)  # s, where what turns a vehicle at once is looked for


def contradictions(errors: Sequence[EquationError], vehicle: Vehicle) -> list[Doubt]:
    """`commands`: prediction unrelated or opposite to what was measured; `time stamps`: response before cause.

    Of an axis on which no actuator acts a disagreement tells nothing of the commands: a centre of mass that is not
    where the file has it makes one.
    """
    if not errors:
        return []
    step = max(0.01, float(np.median(np.concatenate([np.diff(e.t) for e in errors]))))
    lags = np.arange(_LAGS[0], _LAGS[1] + step / 2, step)
    related: dict[str, _Lagged] = {}
    against: dict[str, float] = {}
    unrelated: dict[str, float] = {}
    faint: dict[str, float] = {}
    loud, acts = 0, reached(vehicle)
    for i, axis in enumerate(AXES):
        pairs = [p for e in errors if (p := _even(e, i, step)) is not None]
        floor = [x for e in errors if np.isfinite(x := _noise(e, i))]
        if not pairs or not floor:
            continue
        measured, predicted = (np.sqrt(np.mean(np.concatenate([p[k] for p in pairs]) ** 2)) for k in (0, 1))
        noise = float(np.mean(floor))
        if measured < _LOUD * noise or predicted < _LOUD * noise:
            continue
        loud += 1
        r, fits = _at_best(pairs, lags, step)
        if fits < LEAST and axis[0] == "t":
            # At speed the rotors' torques hold against the air's: what is left of them turns the vehicle, and fast.
            fast = [p for e in errors if (p := _even(e, i, step, drift=_AT_ONCE)) is not None]
            at_once = [_correlation(fast, round(x / step)) for x in np.arange(*_HARDLY_LATE, step)]
            # The opposite agrees half a period later.
            fits = max(fits, *at_once) if max(at_once) > -min(at_once) else fits
        if fits < LEAST and axis[0] == "t" and not vehicle.tilts:
            beside = [
                _beside_thrust(p, thrust)
                for e in errors
                if (p := _even(e, i, step)) and (thrust := _even(e, i, step, 2))
            ]
            if _at_best(beside, lags, step)[1] >= LEAST:
                continue
        if predicted < _COMPARABLE * measured:
            faint |= {axis: fits} if fits < LEAST else {}
        elif fits < LEAST and axis in acts:
            opposite = -r.min() > 0.6 and abs(lags[int(r.argmin())]) < 0.1
            (against if opposite else unrelated)[axis] = float(r.min()) if opposite else fits
        elif r.max() > _CLEAR:
            each = [lags[int(np.argmax([_correlation([p], round(x / step)) for x in lags]))] for p in pairs]
            related[axis] = _Lagged(r, tuple(map(float, each)))
    # One torque of a vehicle that pushes sideways may be small, and drowned by an effect; of two this is not so.
    alone = len(unrelated) == 1 and (vehicle.tilts or min(unrelated.values()) > _UNRELATED)
    if against or (unrelated and not alone) or (len(faint) >= 2 and 2 * len(faint) > loud):
        near = (lags > _NEAR[0]) & (lags < _NEAR[1])
        follow = [axis for axis, x in related.items() if x.correlation[near].max() > _FOLLOWS]
        return [_unrelated(against, unrelated, faint, follow, vehicle)]
    early = _early(related, lags, vehicle, step)
    return [] if early is None else [early]


def still_doubtful(doubts: Sequence[Doubt], errors: Sequence[EquationError], vehicle: Vehicle) -> tuple[Doubt, ...]:
    """The doubts, without a response before its cause that refuses nothing and is gone with what the model lacked.

    errors: of the model that is given.
    """
    early = [d for d in doubts if d.code == _BEFORE and not d.refuses]
    if not early or any(d.code == _BEFORE for d in contradictions(errors, vehicle)):
        return tuple(doubts)
    return tuple(d for d in doubts if d not in early)


def _at_best(pairs: Sequence[tuple[Array, Array]], lags: Array, step: float) -> tuple[Array, float]:
    """Correlation at every lag, and at the best lag that actuators may have."""
    r = np.array([_correlation(pairs, round(lag / step)) for lag in lags])
    near = r[(lags > _NEAR[0]) & (lags < _NEAR[1])].max()
    # Slow signals agree at some lag by chance; only where they do so well is that lag the fault.
    return r, float(r.max() if r.max() > _CLEAR else near)


def _beside_thrust(pair: tuple[Array, Array], thrust: tuple[Array, Array]) -> tuple[Array, Array]:
    """Measured and predicted torque without what goes with the predicted force along z.

    Arms that are not where the file has them put the thrust of all rotors into a torque: that is no wrong order.
    """
    x = thrust[1]
    size = max(float(x @ x), 1e-300)
    measured, predicted = (side - (side @ x) / size * x for side in pair)
    return measured, predicted


@dataclass(frozen=True)
class _Lagged:
    """One axis: correlation at every lag over all flights, and the best lag (s) of each flight."""

    correlation: Array
    each: tuple[float, ...]


def _unrelated(
    against: Mapping[str, float],
    unrelated: Mapping[str, float],
    faint: Mapping[str, float],
    follow: Sequence[str],
    vehicle: Vehicle,
) -> Doubt:
    """The doubt about the commands, and the axes that it takes out.

    Those of no actuator are left, and those that clearly follow their commands: slow signals of two flights may agree
    by chance. Where none does, or where rotors
    that tilt make every force and torque together, no axis is sure.
    """
    parts = []
    if against:
        parts.append(f"the opposite of what was measured on {_listed(against)}")
    if unrelated or not against:
        parts.append(f"unrelated to what was measured on {_listed({**unrelated, **faint})}")
    reason = (
        f"what the actuators predict is {' and '.join(parts)} (correlation): actuators and motion do not belong "
        f"together (order of columns, spin or tilt axes in the vehicle file, commands of another flight)"
    )
    whole = bool(vehicle.tilts) or not follow
    axes = AXES if whole else tuple(a for a in reached(vehicle) if a not in follow)
    return Doubt("commands_unrelated", "commands", axes, reason, unordered=True)


def _listed(axes: Mapping[str, float]) -> str:
    return ", ".join(f"{axis} ({r:.2f})" for axis, r in axes.items())


def _early(related: Mapping[str, _Lagged], lags: Array, vehicle: Vehicle, step: float) -> Doubt | None:
    """The doubt where the vehicle responds before its commands.

    What a model lacks shifts a correlation, too: drag follows the speed, which follows the force. A late stamp is one
    and the same shift on every axis of every flight, it undoes nearly all of the disagreement, and without it the
    disagreement is large. Less than that is said, and refuses nothing.
    """
    if not related:
        return None
    total = np.mean([x.correlation for x in related.values()], axis=0)
    best = int(total.argmax())
    slowest = max([*vehicle.input_time_constants, *(x.time_constant for x in vehicle.tilts)])
    earliest = -(slowest + _LEAD + step)
    if lags[best] >= earliest:
        return None
    apart = [1.0 - x.correlation[best] ** 2 for x in related.values()]
    causal = [1.0 - x.correlation[lags >= -step / 2].max() ** 2 for x in related.values()]
    every = np.array([x for lagged in related.values() for x in lagged.each])
    alike = bool(np.all(every < earliest)) and bool(np.all(np.abs(every - lags[best]) < _ALIKE + step / 2))
    undone = all(left < _UNDONE * before for left, before in zip(apart, causal, strict=True))
    sure = len(related) >= 2 and alike and undone and float(np.mean(causal)) > _BAD
    numbers = (
        f"(1 - r^2 of prediction and measurement over {', '.join(related)}: {np.mean(causal):.2f} as stamped, "
        f"{np.mean(apart):.3f} shifted)"
    )
    reason = f"the vehicle responds {-1000 * lags[best]:.0f} ms before its commands {numbers}: "
    if sure:
        reason += "they are stamped late or held, and no effect of the actuators can be told from that"
    else:
        reason += "not sure enough to refuse, for missing physics shifts a correlation, too; doubt delays and lags"
    return Doubt(_BEFORE, "time stamps", reached(vehicle) if sure else (), reason, refuses=sure)


def _noise(e: EquationError, i: int) -> float:
    """The floor of one axis; where unrelated commands make the error itself rough, how rough the measured side is."""
    return float(np.fmin(e.floor[i], fast_part(e.t, e.measured[:, i : i + 1], e.window)[0]))


def _even(
    e: EquationError, i: int, step: float, other: int | None = None, drift: float = _DRIFT
) -> tuple[Array, Array] | None:
    """Measured and predicted side of one axis on an even grid, changes slower than `drift` (s) taken off.

    other: of that axis instead, where the first one is known.
    """
    rows = np.flatnonzero(e.scored[:, i] & np.isfinite(e.predicted[:, i]))
    if len(rows) < 100:
        return None
    grid = np.arange(e.t[rows[0]], e.t[rows[-1]], step)
    if len(grid) < 100:
        return None
    sides = [
        _without_drift(np.interp(grid, e.t[rows], x[rows, i if other is None else other]), round(drift / step))
        for x in (e.measured, e.predicted)
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
