"""What a call from Python was given: of the right type, or one line that says which argument is not."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from numbers import Integral, Real
from pathlib import Path
from typing import Any, TypeGuard

from infotraj.errors import UsageError, problem

AnyPath = str | os.PathLike[str]


def is_path(value: object) -> TypeGuard[AnyPath]:
    """Whether it is a path: a str, a Path, or what another library has for one; bytes are none."""
    return isinstance(value, str | os.PathLike) and isinstance(os.fspath(value), str)


def as_path(name: str, value: Any) -> Path:
    """A path. UsageError for what is none."""
    if not is_path(value):
        raise UsageError(problem(f"{name} of type {type(value).__name__}", "a path", "Give a str or a Path."))
    return Path(value)


def as_paths(name: str, value: Any) -> list[Path]:
    """Paths, of one alone too."""
    return [as_path(name, x) for x in as_several(name, value, "a path or several")]


def as_several(name: str, value: Any, expected: str) -> list[Any]:
    """What is in a list or another collection; what is alone (a text, a path) as the only one."""
    if is_path(value):
        return [value]
    if not isinstance(value, Iterable) or isinstance(value, bytes):
        raise UsageError(problem(f"{name} of type {type(value).__name__}", expected, "Give a list."))
    return list(value)


def require_part(start: Any, stop: Any) -> None:
    """UsageError unless start and stop are times (s) or None, the first before the second."""
    for name, value in (("start", start), ("stop", stop)):
        number = isinstance(value, Real) and not isinstance(value, bool)
        if value is not None and not (number and not math.isnan(value)):
            raise UsageError(problem(f"{name}={value!r}", "a time in s, or None", "Give a number."))
    if start is not None and stop is not None and not start < stop:
        raise UsageError(problem(f"stop={stop:g} is not after start={start:g}", "start below stop", "Swap them."))


def require_seed(seed: Any) -> None:
    """UsageError unless the seed of the random numbers is a whole number from 0."""
    if not isinstance(seed, Integral) or seed < 0:
        raise UsageError(problem(f"seed={seed!r}", "a whole number from 0", "Give one."))
