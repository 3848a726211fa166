"""What a wrong vehicle file makes of an answer: which names state its errors, which numbers are true beside it.

The scorer alone uses it. An effect named for what the file has wrong is no invention if it takes at least half of that
error away; under any other name it is one. A hidden effect that is itself a number of a wrong file may be told in the
answer's section on the file instead of by its name: the file's own error and it are one error to whoever has that file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from infotraj.diagnosis.judge.numbers import OVER_MASS
from infotraj.effects import effect_class
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

HALF = 0.5  # of an error: what a statement of it may leave
THIRD = 1 / 3  # of an error: what its statement in the answer's section on the file may leave
Values = Mapping[str, Any]


def _ratios(file: Vehicle, true: Vehicle, key: str) -> Array:
    pairs = [(getattr(t, key), getattr(f, key)) for t, f in zip(true.rotors, file.rotors, strict=True)]
    return np.array([t / f if t and f else 1.0 for t, f in pairs])


def _lag(file: Vehicle, true: Vehicle, parts: str) -> list[dict[str, Any]]:
    lags = [np.mean([p.time_constant for p in getattr(v, parts)] or [0.0]) for v in (true, file)]
    return [{"extra_time_constant": float(lags[0] - lags[1])}]


def _mass(file: Vehicle, true: Vehicle) -> list[dict[str, Any]]:
    return [{"dm": true.mass - file.mass}] if true.mass and file.mass else []


def _inertia(file: Vehicle, true: Vehicle) -> list[dict[str, Any]]:
    if true.inertia is None or file.inertia is None:
        return []
    off = np.diag(true.inertia_matrix() - file.inertia_matrix())
    return [dict(zip(("dxx", "dyy", "dzz"), off.tolist(), strict=True))]


def _center(file: Vehicle, true: Vehicle) -> list[dict[str, Any]]:
    """The offset itself, and what it comes to with the mean error of the rotors' places, which turns the body alike."""
    off = np.subtract(true.center_of_mass, file.center_of_mass)
    moved = np.mean([r.position for r in true.rotors], axis=0) - np.mean([r.position for r in file.rotors], axis=0)
    return [{"r": off.tolist()}, {"r": (off - moved).tolist()}]


def _thrust(file: Vehicle, true: Vehicle) -> list[dict[str, Any]]:
    return [{"factor": float(_ratios(file, true, "thrust_coefficient").mean())}]


def _rotors(file: Vehicle, true: Vehicle) -> list[dict[str, Any]]:
    """Each rotor against the file, and against the file's rotors together, where a common factor is named beside it."""
    each = _ratios(file, true, "thrust_coefficient")
    return [{"rotor": k, "factor": float(f)} for whole in (1.0, each.mean()) for k, f in enumerate(each / whole)]


def _moment(file: Vehicle, true: Vehicle) -> list[dict[str, Any]]:
    return [{"factor": float(_ratios(file, true, "moment_constant").mean())}]


STATED: dict[str, Callable[[Vehicle, Vehicle], list[dict[str, Any]]]] = {
    "mass_offset": _mass,
    "inertia_error": _inertia,
    "com_offset": _center,
    "thrust_scale": _thrust,
    "rotor_effectiveness": _rotors,
    "moment_scale": _moment,
    "rotor_lag": lambda file, true: _lag(file, true, "rotors"),
    "servo_lag": lambda file, true: _lag(file, true, "tilts"),
}


def states_the_file(name: str, said: Values, file: Vehicle, true: Vehicle) -> bool:
    """Whether an effect of this name with these numbers says what `file` has wrong of `true`, to within half of it."""
    for error in STATED.get(name, lambda *_: [])(file, true):
        if error.get("rotor") != said.get("rotor"):
            continue
        off, told = (_changes(name, values, file) for values in (error, said))
        if np.linalg.norm(off) > 0 and np.linalg.norm(told - off) <= HALF * np.linalg.norm(off):
            return True
    return False


def beside_the_file(name: str, hidden: Values, file: Vehicle, true: Vehicle) -> dict[str, Any]:
    """The numbers of a hidden effect as an answer that knows this file alone must have them."""
    out = dict(hidden)
    for error in STATED.get(name, lambda *_: [])(file, true)[: None if "rotor" in hidden else 1]:
        if error.get("rotor") != hidden.get("rotor"):
            continue
        for key, value in error.items():
            if key == "factor":
                out[key] = hidden[key] * value
            elif key in hidden and key != "rotor":
                out[key] = np.add(hidden[key], value).tolist()
        break
    return out


_AXES = ("x", "y", "z")
_IN_THE_SECTION: dict[str, dict[str, tuple[str, ...]]] = {  # by effect and parameter, one name a number
    "mass_offset": {"dm": ("mass",)},
    "inertia_error": {f"d{a}{a}": (f"inertia.{a}{a}",) for a in _AXES},
    "com_offset": {"r": tuple(f"center_of_mass.{a}" for a in _AXES)},
    "rotor_effectiveness": {"factor": ("rotor_{rotor}.thrust_coefficient",)},
    "moment_scale": {"factor": ("moment_constant of all rotors, factor",)},
    "rotor_lag": {"extra_time_constant": ("time_constant of the rotors, more by",)},
    "servo_lag": {"extra_time_constant": ("time_constant of the tilts, more by",)},
}


def told_in_file(name: str, hidden: Values, section: Sequence[Mapping[str, Any]], file: Vehicle, true: Vehicle) -> bool:
    """Whether the answer's section on the file says a hidden effect and the file's own error together, to a third.

    Of a mass or the scale of all thrusts it is enough that it says their ratio, of which it says that it is no more.

    section: rows with name, declared and value; what has no row is taken to be as declared. False where the file is
    right, or the effect is none of its numbers.
    """
    if file == true:
        return False
    ratio = next((row["value"] for row in section if row["name"].endswith(OVER_MASS)), None)
    if name in ("mass_offset", "thrust_scale") and ratio is not None:
        heavier = (true.mass + hidden.get("dm", 0.0)) / file.mass
        off = np.log(hidden.get("factor", 1.0) * _thrust(file, true)[0]["factor"] / heavier)
        return bool(abs(np.log(ratio) - off) <= THIRD * abs(off))
    names = _IN_THE_SECTION.get(name)
    if names is None:
        return False
    rows = {row["name"].replace(".thrust, factor", ".thrust_coefficient"): row for row in section}
    place = int(hidden.get("rotor", 0))

    def said(key: str, number: str) -> float:
        row = rows.get(number.format(rotor=place), {"declared": 1.0, "value": 1.0})
        return row["value"] / row["declared"] if key == "factor" else row["value"] - row["declared"]

    told = {key: np.squeeze([said(key, n) for n in numbers]) for key, numbers in names.items() if key in hidden}
    if name == "moment_scale":  # of all rotors, and of each beside
        each = [r["value"] / r["declared"] - 1.0 for n, r in rows.items() if n.endswith(".moment_constant")]
        told["factor"] = told["factor"] + sum(each) / len(file.rotors)
    total = beside_the_file(name, hidden, file, true)
    off, stated = (_changes(name, {k: values[k] for k in told}, file) for values in (total, told))
    return bool(np.linalg.norm(off) > 0 and np.linalg.norm(stated - off) <= THIRD * np.linalg.norm(off))


def cancelled(name: str, hidden: Values, file: Vehicle, true: Vehicle) -> bool:
    """Whether the file happens to be wrong by the hidden effect, so that less than half of it is left to be named."""
    was, left = (_changes(name, v, file) for v in (hidden, beside_the_file(name, hidden, file, true)))
    return bool(np.linalg.norm(left) < HALF * np.linalg.norm(was))


def _changes(name: str, values: Values, vehicle: Vehicle) -> Array:
    """All numbers of an effect as changes from the values that leave the model as it was, places left out."""
    cls, parts = effect_class(name), []
    for p in cls.parameters:
        if not p.index and p.name in values:
            parts.append(np.atleast_1d(np.asarray(values[p.name], dtype=float) - cls.absent(vehicle, p)))
    return np.concatenate(parts) if parts else np.zeros(0)


def excused(
    groups: Iterable[tuple[int, list[str]]],
    instances: Callable[[str], list[dict[str, Any]]],
    file: Vehicle,
    true: Vehicle,
    of_log: frozenset[str],
) -> tuple[list[str], list[str], set[int]]:
    """Which groups state an error of the file, which of the log, and the numbers of both.

    groups: (number, members), those that no hidden effect was found by; instances: the numbers of each instance of a
    name in the answer; of_log: names that state what the log does.
    """
    by_file, by_log, numbers = [], [], set()
    for number, group in groups:
        said = [(name, values) for name in group for values in instances(name)]
        if file != true and said and any(states_the_file(n, v, file, true) for n, v in said):
            by_file.append(group[0])
        elif set(group) & of_log:
            by_log.append(group[0])
        else:
            continue
        numbers.add(number)
    return by_file, by_log, numbers
