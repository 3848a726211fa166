"""A vehicle file held against a flight: is the thrust right, do the torques go the right way, and are they as large?

A rotor that is weak, or a centre of mass beside the origin, brings torques that no inertia makes. So how large a torque
is, is asked beside rotors each of which may differ, and the file is to be corrected only by what is sure beside them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj.comparing.equation_error import AXES, EquationError, equation_error
from infotraj.effects.thrust import RotorEffectiveness
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.rotations import Array

_UNRELATED = 0.3  # correlation below which a torque that is there is not the one that was commanded
_OFF = 0.15  # share by which a torque may be off before it is said to be: the filter and the lag take some, too
_SEEN = 3.0  # times the floor: a quieter torque says nothing
_DIFFER = 0.1  # share by which one rotor's thrust may differ from the file's
_STEP = 0.1  # share of a rotor's thrust that is taken away to see what it does
_SURE = 2.0  # standard errors
_EXACT = 0.05  # of a torque: a file that is right predicts it no better, for its lags are not
_WHOLE = 0.9  # correlation above which a torque is what it is told to be, but for its size
_STRETCHES = 8  # of a flight, of which each is left out in turn for the standard error
_DIAGNOSE = "`infotraj diagnose` tells what it is"


@dataclass(frozen=True)
class Seen:
    """One axis: its sentence, and whether it is as the file says."""

    axis: str
    good: bool
    sentence: str


def seen(error: EquationError, rotors: Array | None = None) -> list[Seen]:
    """Thrust, and the three torques, of a flight against what the vehicle file predicts.

    rotors (r, n, 6): what each rotor does of the predicted wrench; none by default, as of a vehicle without rotors.
    """
    rotors = np.zeros((0, *error.predicted.shape)) if rotors is None else rotors
    out = [_thrust(error, rotors)]
    for k, axis in enumerate(AXES[3:], start=3):
        rows = error.scored[:, k]
        if axis in error.reasons or rows.sum() < 20:
            out.append(Seen(axis, True, f"{axis}: not asked ({error.reasons.get(axis, 'too few rows')})"))
            continue
        windows = max(error.window / float(np.median(np.diff(error.t))), 1.0)
        sides = error.measured[rows, k], error.predicted[rows, k], rotors[:, rows, k]
        out.append(_torque(axis, *sides, float(error.floor[k]), windows))
    return out


def of_rotors(model: Model, flight: Flight, error: EquationError) -> Array:
    """What each rotor does of the predicted wrench, (r, n, 6), through the filter of `error`."""
    out = []
    for k in range(len(model.vehicle.rotors)):
        less = model.with_effects(RotorEffectiveness(rotor=k, factor=1.0 - _STEP))
        out.append((error.predicted - equation_error(less, flight).predicted) / _STEP)
    return np.array(out).reshape(len(out), *error.predicted.shape)


def _thrust(error: EquationError, rotors: Array) -> Seen:
    rows = error.scored[:, 2]
    if not rows.any():
        return Seen("fz", True, f"thrust: not asked ({error.reasons.get('fz', 'no rows')})")
    predicted = float(error.predicted[rows, 2].mean())
    share = float(error.measured[rows, 2].mean()) / predicted
    said = f"thrust: the flight has {share:.3f} of what the file predicts"
    if abs(share - 1.0) <= 0.03:
        return Seen("fz", True, f"{said}: right")
    if not len(rotors):
        return Seen("fz", False, f"{said}; divide the mass by {share:.3f}")
    if abs(share - 1.0) <= _SURE * _DIFFER * float(np.linalg.norm(rotors[:, rows, 2].mean(axis=1))) / abs(predicted):
        return Seen("fz", False, f"{said}; one weak rotor, the thrust map or the mass: {_DIAGNOSE}")
    return Seen("fz", False, f"{said}; multiply the thrust of every rotor by {share:.3f}, or divide the mass by it")


def _torque(axis: str, measured: Array, predicted: Array, rotors: Array, floor: float, windows: float) -> Seen:
    # About their means: what does not change is a trim, and says nothing of order and spins.
    measured, predicted = measured - measured.mean(), predicted - predicted.mean()
    sizes = float(np.std(measured)), float(np.std(predicted))
    if max(sizes) < _SEEN * floor:
        return Seen(axis, True, f"{axis}: too quiet in this flight to say")
    r = float(np.mean(measured * predicted) / (sizes[0] * sizes[1])) if min(sizes) > 0 else 0.0
    if r < _UNRELATED:
        what = "goes against" if r < -_UNRELATED else "does not go with"
        where = "spins" if axis == "tz" else "order of the rotors, or the body's axes"
        return Seen(
            axis,
            False,
            f"{axis}: the measured torque {what} the predicted one (correlation {r:.2f}); check the {where}",
        )
    share, deviation, whole = _size(measured, predicted, rotors - rotors.mean(axis=1, keepdims=True), windows)
    off, unsure = abs(share - 1.0), _SURE * deviation
    said = f"{axis}: goes with the commands (correlation {r:.2f}) and is {share:.2f} as large"
    if off <= _OFF and unsure <= _OFF:
        return Seen(axis, True, f"{said}: right")
    if off <= unsure + _OFF or whole < _WHOLE:
        good = off <= max(_OFF, unsure)
        beside = " beside rotors that may differ" if len(rotors) else ""
        return Seen(axis, good, f"{said}, +- {deviation:.2f}{beside}; {_DIAGNOSE}")
    remedy = {
        "tx": f"divide inertia.xx by {share:.2f}",
        "ty": f"divide inertia.yy by {share:.2f}",
        "tz": f"multiply moment_constant by {share:.2f}, or divide inertia.zz by it"
        if len(rotors)
        else f"divide inertia.zz by {share:.2f}",
    }[axis]
    return Seen(axis, False, f"{said}; {remedy}")


def _size(measured: Array, predicted: Array, rotors: Array, windows: float) -> tuple[float, float, float]:
    """How large a torque (n,) is against the predicted one, beside rotors (r, n) that may differ; its standard error;
    and how closely the measured one goes with what that makes (correlation).

    Ridge regression (Hoerl and Kennard 1970) with the rotors' differences as likely as in files; the error is what it
    has for noise that is independent from one filter's window, of so many rows, to the next, and what the flight's
    stretches scatter by (jackknife).
    """
    whole = rotors.sum(axis=0) if len(rotors) else predicted
    left = measured - (predicted - whole)  # what does not come from rotors is as predicted
    x = np.column_stack([whole, *rotors])
    stretch = (np.arange(len(x)) * _STRETCHES) // len(x)
    inside = [stretch == k for k in range(_STRETCHES)]
    grams = np.array([x[i].T @ x[i] for i in inside])
    rights = np.array([x[i].T @ left[i] for i in inside])
    free = np.linalg.lstsq(x, left, rcond=None)[0]
    noise = windows * float(np.mean((left - x @ free) ** 2) + (_EXACT * np.std(left)) ** 2)
    known = np.diag([0.0] + [noise / _DIFFER**2] * len(rotors))
    found = np.linalg.solve(grams.sum(axis=0) + known, rights.sum(axis=0))
    without = [
        np.linalg.solve(grams.sum(axis=0) - g + known, rights.sum(axis=0) - b)[0]
        for g, b in zip(grams, rights, strict=True)
    ]
    scatter = (_STRETCHES - 1) / _STRETCHES * float(np.sum((np.array(without) - np.mean(without)) ** 2))
    own = noise * float(np.linalg.inv(grams.sum(axis=0) + known)[0, 0])
    return float(found[0]), float(np.sqrt(scatter + own)), float(np.corrcoef(x @ found, left)[0, 1])
