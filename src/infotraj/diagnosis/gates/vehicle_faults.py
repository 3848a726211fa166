"""Whether one wrong entry of the vehicle file explains a flight: a spin, two rotors or tilts in each other's place.

Each entry is changed by itself and the torque predicted again. Such an entry is no physical effect: a fit to the
flights of a vehicle whose file has a spin reversed finds a steady torque that is not there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy.ndimage import uniform_filter1d

from infotraj.comparing.equation_error import AXES, EquationError, equation_error
from infotraj.diagnosis.gates.doubt import Doubt
from infotraj.dynamics.actuators import body_wrench
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.models.actuation import rotors_at, tilts_at
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_SUSPICIOUS = 3.0  # times the floor, the mean of the error forgiven
_LOUD = 10.0  # times the floor: then the order of rotors and tilts is questioned too
_BETTER = 1.5  # times less variance of the error on one axis with each change
_FALL = 50.0  # times less variance in the end, unless next to nothing is left: effects can copy a part of a fault
_LEFT = 2.0  # times the floor
_STEPS = 12
_ORDER = "in each other's place"
_SAME = 0.05  # log likelihood
_VERIFIED = 3
_NAMED = 3
_SECONDS = 6.0  # of the flight are enough


def suspected(error: EquationError, times: float = _SUSPICIOUS) -> bool:
    """Whether the torque error is `times` above the floor, far enough to ask about the vehicle file."""
    varies = _variance(error)[3:]
    with np.errstate(invalid="ignore"):
        return bool(np.any(varies > (times * error.floor[3:]) ** 2))


def vehicle_fault(model: Model, flight: Flight, error: EquationError, contradicted: bool) -> Doubt | None:
    """The change of the vehicle file that takes most of the error away, and the axes whose prediction it changes.

    error: of the model on the flight; contradicted: whether prediction and measurement disagree so far that the order
    of rotors and tilts and the tilts' axes are tried whatever the size of the error.
    """
    if not model.vehicle.rotors or (not contradicted and not suspected(error)):
        return None
    every = contradicted or suspected(error, _LOUD)
    used = error.t[error.scored.any(axis=1)]
    if len(used) < 100:
        return None
    begin = _fullest(used)
    flight = flight.between(begin, begin + _SECONDS)
    vehicle, changes = model.vehicle, []
    start = part = equation_error(model, flight)
    first = now = _variance(part)
    for _ in range(_STEPS):
        tried = []
        for words, changed in _likely(Model(vehicle, model.effects), flight, part, every):
            try:
                made = equation_error(Model(changed, model.effects), flight)
            except InputError:
                continue
            tried.append((_gain(now, _variance(made), part.floor), words, changed, made))
        best = max(tried, key=lambda x: x[0], default=None)
        if best is None or best[0] <= 0:
            break
        # The two spins of a coaxial pair that shares a command cannot be told apart.
        changes.append(" or ".join(words for gain, words, *_ in tried if gain > best[0] - _SAME))
        vehicle, part = best[2], best[3]
        now = _variance(part)
        if not suspected(part):
            break
    if not changes:
        return None
    fall = float(np.nanmax(first[3:] / np.maximum(now[3:], 1e-300)))
    with np.errstate(invalid="ignore"):
        loud = np.any(now[3:] > (_LEFT * part.floor[3:]) ** 2)
    if (fall < _FALL and loud) or _servo_bias_instead(model, flight, start, now):
        return None
    few = len(changes) <= _NAMED
    what = " and ".join(changes) if few else f"another order of rotors or tilts ({', '.join(changes)})"
    reason = f"the flights fit the vehicle file far better with {what} (squared torque error {fall:.0f} times smaller)"
    moved = np.nanstd(part.predicted - start.predicted, axis=0)
    with np.errstate(invalid="ignore"):
        axes = tuple(a for a, far in zip(AXES, moved > start.floor, strict=True) if far)
    # A spin is one sign; rotors in each other's place leave open which column is which rotor's.
    unordered = any(_ORDER in words for words in changes)
    return Doubt("wrong_vehicle_file", "vehicle file", axes, reason, unordered=unordered)


def _fullest(used: Array) -> float:
    """Where `_SECONDS` begin that hold the most rows that can be compared, at times `used` (n,), near the middle."""
    rows = np.searchsorted(used, used + _SECONDS) - np.arange(len(used))
    full = used[rows >= 0.95 * rows.max()]
    middle = 0.5 * (used[0] + used[-1] - _SECONDS)
    return float(full[np.argmin(np.abs(full - middle))])


def _servo_bias_instead(model: Model, flight: Flight, error: EquationError, left: Array) -> bool:
    """Whether constant offsets of the tilts explain the torque better than the changes that leave `left` (6,).

    Reaction torques of a pair whose spins do not cancel turn with its arm as the thrust that a tilt's offset turns
    sideways; the offset shows in the force too, so both are fitted together.
    """
    vehicle = model.vehicle
    if not vehicle.tilts:
        return False
    rotor, tilt = _actuators(model, flight)
    width = _width(flight, error)
    before = body_wrench(vehicle, rotor, tilt)
    columns = []
    for i in range(len(vehicle.tilts)):
        turned = tilt.copy()
        turned[:, i] += 1e-3
        columns.append(uniform_filter1d((body_wrench(vehicle, rotor, turned) - before) / 1e-3, width, axis=0))
    scored = np.isfinite(error.residual).all(axis=1)
    y = error.residual[scored]
    y = (y - y.mean(axis=0)) / (spread := y.std(axis=0))
    x = np.stack([(c[scored] - c[scored].mean(axis=0)) / spread for c in columns], axis=2)
    theta = np.linalg.lstsq(x.reshape(-1, x.shape[2]), y.reshape(-1), rcond=1e-9)[0]
    rest = np.mean((y - x @ theta) ** 2, axis=0) * spread**2
    return bool(np.sum(rest[3:]) < np.sum(left[3:]))


def _actuators(model: Model, flight: Flight) -> tuple[Array, Array]:
    """Rotor inputs and tilts at the flight's rows, lags of the model included."""
    recorded, law = model.prepare(flight).recorded, model.actuator_law()
    rotor, _ = rotors_at(recorded, law, flight.t)
    tilt = tilts_at(recorded, law, flight.t)[0] if model.vehicle.tilts else np.zeros((len(flight.t), 0))
    return rotor, tilt


def _width(flight: Flight, error: EquationError) -> int:
    return max(1, round(error.window / float(np.median(np.diff(flight.t)))))


def _likely(model: Model, flight: Flight, error: EquationError, every: bool) -> list[tuple[str, Vehicle]]:
    """The changes that look best when only the rotors' steady wrench is computed again: a cheap first look."""
    rotor, tilt = _actuators(model, flight)
    before = body_wrench(model.vehicle, rotor, tilt)
    width = _width(flight, error)
    now, scored = _variance(error), []
    for words, changed in _changed(model.vehicle, every):
        difference = uniform_filter1d(body_wrench(changed, rotor, tilt) - before, width, axis=0)
        made = _variance(replace(error, predicted=error.predicted + difference))
        scored.append((_gain(now, made, error.floor), words, changed))
    scored.sort(key=lambda x: -x[0])
    return [(words, changed) for gain, words, changed in scored[:_VERIFIED] if gain > 0]


def _gain(now: Array, made: Array, floor: Array) -> float:
    """How much better, as a log likelihood; 0 unless an axis falls by far and none rises by as much."""
    used = np.isfinite(now) & np.isfinite(made)
    low = np.square(np.nan_to_num(floor))
    change = np.log((now[used] + low[used]) / (made[used] + low[used]))
    if not used.any() or change.max() < np.log(_BETTER):
        return 0.0
    return float(max(change.sum(), 0.0))


def _variance(error: EquationError) -> Array:
    """Variance of the error (6,) about its mean: what is steady may be a steady effect."""
    residual = np.where(error.scored, error.residual, np.nan)
    out = np.full(6, np.nan)
    for i in range(6):
        x = residual[:, i][np.isfinite(residual[:, i])]
        if len(x) > 50:
            out[i] = float(np.var(x))
    return out


def _changed(vehicle: Vehicle, every: bool) -> Iterator[tuple[str, Vehicle]]:
    rotors, tilts = vehicle.rotors, vehicle.tilts
    flipped = [r.model_copy(update={"spin": -r.spin}) for r in rotors]
    yield "all spins reversed", vehicle.model_copy(update={"rotors": tuple(flipped)})
    for i, r in enumerate(rotors):
        yield f"the spin of {r.name} reversed", _with(vehicle, "rotors", {i: flipped[i]})
    if not every:
        return
    for i, j in combinations(range(len(rotors)), 2):
        swapped = _with(vehicle, "rotors", {i: rotors[j], j: rotors[i]})
        yield f"{rotors[i].name} and {rotors[j].name} {_ORDER}", swapped
    arms = [[k for k, r in enumerate(rotors) if r.tilt == i] for i in range(len(tilts))]
    for a, b in combinations([arm for arm in arms if len(arm) > 1], 2):
        if len(a) == len(b):
            there = {
                **{i: rotors[j] for i, j in zip(a, b, strict=True)},
                **{j: rotors[i] for i, j in zip(a, b, strict=True)},
            }
            names = " and ".join(",".join(rotors[k].name for k in arm) for arm in (a, b))
            yield f"{names} {_ORDER}", _with(vehicle, "rotors", there)
    turned = [x.model_copy(update={"axis": tuple(-a for a in x.axis)}) for x in tilts]
    if tilts:
        yield "all tilt axes reversed", vehicle.model_copy(update={"tilts": tuple(turned)})
    for i, j in combinations(range(len(tilts)), 2):
        swapped = _with(vehicle, "tilts", {i: tilts[j], j: tilts[i]})
        yield f"{tilts[i].name} and {tilts[j].name} {_ORDER}", swapped
    for i, x in enumerate(tilts):
        yield f"the axis of {x.name} reversed", _with(vehicle, "tilts", {i: turned[i]})


def _with(vehicle: Vehicle, field: str, entries: dict) -> Vehicle:
    items = list(getattr(vehicle, field))
    for i, entry in entries.items():
        items[i] = entry
    return vehicle.model_copy(update={field: tuple(items)})
