"""Whether one wrong entry of the vehicle file explains a flight: a spin, two rotors or tilts in each other's place.

Each entry is changed by itself and the torque predicted again. Such an entry is no physical effect: a fit to the
flights of a vehicle whose file has a spin reversed finds a steady torque that is not there. Nor is it every error of a
file: a file whose numbers are off by ten percent fits better with them mended than with its rotors in another order,
so that both are asked with their numbers free (`near_file`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy.ndimage import uniform_filter1d

from infotraj.comparing.equation_error import AXES, EquationError, equation_error
from infotraj.diagnosis.gates.doubt import Doubt
from infotraj.diagnosis.gates.near_file import nats_against
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
_SURE = 10.0  # nats by which a flight is more probable with each change: a layout is hardly ever wrong
_STEPS = 12
_ORDER = "in each other's place"
_SAME = 0.05  # nats
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
    now = _near(model, flight, start)
    for _ in range(_STEPS):
        tried = []
        for words, changed in _likely(Model(vehicle, model.effects), flight, part, every):
            made = Model(changed, model.effects)
            try:
                error = equation_error(made, flight)
            except InputError:
                continue
            tried.append((_near(made, flight, error), words, changed, error))
        best = min(tried, key=lambda x: x[0], default=None)
        if best is None or now - best[0] < _SURE:
            break
        # The two spins of a coaxial pair that shares a command cannot be told apart.
        changes.append(" or ".join(words for nats, words, *_ in tried if nats < best[0] + _SAME))
        now, _, vehicle, part = best
        if not suspected(part):
            break
    if not changes:
        return None
    before, after = _variance(start)[3:], _variance(part)[3:]
    fall = float(np.nanmax(before / np.maximum(after, 1e-300)))
    with np.errstate(invalid="ignore"):
        loud = np.any(after > (_LEFT * part.floor[3:]) ** 2)
    if fall < _FALL and loud:
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


def _near(model: Model, flight: Flight, error: EquationError) -> float:
    """How improbable the flight is with a file that may be off by as much as files are, in nats."""
    rotor, tilt = _actuators(model, flight)
    return nats_against(model.vehicle, rotor, tilt, error, _width(flight, error))


def _actuators(model: Model, flight: Flight) -> tuple[Array, Array]:
    """Rotor inputs and tilts at the flight's rows, lags of the model included."""
    recorded, law = model.prepare(flight).recorded, model.actuator_law
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
