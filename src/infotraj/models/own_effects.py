"""Tries an effect of the user's own once along a flight, so that what is wrong in its file is said by name.

Later nothing looks at what hooks return: they are called many thousand times.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from types import FunctionType
from typing import Any

import numpy as np

from infotraj.effects.along import Along
from infotraj.effects.base import Effect, Load, overrides
from infotraj.effects.laws import ActuatorLaw, AirLaw, BodyLaw, ImuLaw, RotorMove
from infotraj.errors import InfotrajError, InputError, problem
from infotraj.flight import Flight
from infotraj.models.model import Model
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_LAWS: dict[str, tuple[type, ...]] = {
    "actuators": (ActuatorLaw,),
    "air": (AirLaw,),
    "moved_rotor": (RotorMove, type(None)),
    "load": (Load,),
    "body": (BodyLaw,),
    "imu": (ImuLaw,),
}
_OF_ROTORS = ("thrust_factor", "thrust_loss", "reaction_factor")  # a number, one a rotor, or (N, rotors)
_ARRAYS = ("rotor_force", "rotor_momentum", "wrench")
_DOCS = "Correct it; docs/effects.md has an example."


def is_own(cls: type[Effect]) -> bool:
    """Whether an effect is the user's, not one of the catalogue."""
    return not cls.__module__.startswith("infotraj.")


@contextmanager
def named(cls: type[Effect]) -> Iterator[None]:
    """InputError, which names the effect, its file and the hook, for whatever an effect of the user's own raises."""
    try:
        yield
    except InfotrajError:
        raise
    except Exception as error:
        if not is_own(cls):
            raise
        inside = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == _file(cls)]
        where = f"{inside[-1].name}, line {inside[-1].lineno}: " if inside else ""
        what = f"{type(error).__name__}: {error}".splitlines()[0]
        raise InputError(problem(f"{_file(cls)}: {cls.name}: {where}{what}", "a hook that runs", _DOCS)) from error


def require_usable(effect: Effect, vehicle: Vehicle, flight: Flight) -> None:
    """InputError where a hook of an own effect fails along the flight, or returns what no model can use."""
    cls = type(effect)
    try:
        Model(vehicle).predict(flight)
    except InfotrajError:
        return  # The flight is refused for its own reason, whatever the effect does.
    for hook in (*_LAWS, *_OF_ROTORS, *_ARRAYS):
        if overrides(effect, hook):
            setattr(effect, hook, partial(_held, cls, hook, getattr(effect, hook)))
    with named(cls):
        Model(vehicle, [effect]).predict(flight)


def _held(cls: type[Effect], hook: str, call: Callable[..., Any], *given: Any) -> Any:
    """What a hook returns, once it is known to be right."""
    made = call(*given)
    wrong = _wrong_law(hook, made) if hook in _LAWS else _wrong_numbers(hook, made, *given)
    if wrong is not None:
        raise InputError(problem(f"{_file(cls)}: {cls.name}: {hook} returns {wrong[0]}", wrong[1], _DOCS))
    return made


def _wrong_law(hook: str, made: Any) -> tuple[str, str] | None:
    """What was returned in place of a law, and what was expected."""
    if isinstance(made, _LAWS[hook]):
        return None
    return f"{'nothing' if made is None else type(made).__name__}", f"{_LAWS[hook][0].__name__}"


def _wrong_numbers(hook: str, made: Any, along: Along) -> tuple[str, str] | None:
    """What is wrong with the numbers that were returned, and what was expected."""
    n, rotors = along.count, len(along.vehicle.rotors)
    shapes = {"wrench": (n, 6), "rotor_force": (n, rotors, 3), "rotor_momentum": (n, 3)}
    shape = shapes.get(hook, (n, rotors))
    said = f"({', '.join(['N', *map(str, shape[1:])])})"
    expected = {
        "rotor_momentum": f"two arrays {said}, N being {n} here",
        **dict.fromkeys(_OF_ROTORS, f"a number, ({rotors},) or {said}, N being {n} here"),
    }.get(hook, f"an array {said}, N being {n} here")
    pair = hook == "rotor_momentum"
    if pair and not (isinstance(made, tuple) and len(made) == 2):
        return f"{'nothing' if made is None else type(made).__name__}", expected
    for part in made if pair else (made,):
        try:
            values = np.asarray(part, dtype=float)
        except (TypeError, ValueError):
            return f"{type(part).__name__}", expected
        if part is None:
            return "nothing", expected
        if values.shape != shape and not (hook in _OF_ROTORS and _spread(values.shape, shape)):
            return f"an array {values.shape}", expected
        bad = ~np.isfinite(values)
        if values.shape[:1] == (n,):
            bad = bad[_known(along)]
        if bad.any():
            share = 100 * float(bad.mean())
            return f"numbers of which {share:.3g} % are not finite where the motion is known", "finite ones"
    return None


def _spread(shape: tuple[int, ...], full: tuple[int, ...]) -> bool:
    try:
        return np.broadcast_shapes(shape, full) == full
    except ValueError:
        return False


def _known(along: Along) -> Array:
    """Instants (N,) at which all that the flight records of the motion is a number."""
    m = along.motion
    parts = [x for x in (m.attitude, m.height, m.velocity, m.rate, m.battery) if x is not None]
    return np.all([np.isfinite(x.reshape(len(x), -1)).all(axis=1) for x in (m.time, *parts)], axis=0)


def _file(cls: type[Effect]) -> str:
    """Where an effect is written."""
    own = (getattr(f, "__func__", f) for f in vars(cls).values())
    return next((f.__code__.co_filename for f in own if isinstance(f, FunctionType)), cls.__module__)
