"""Finds effects by name: the built-in catalogue, and the user's own from files and from installed packages.

A user's file holds subclasses of `Effect`. It is named by the environment variable INFOTRAJ_EFFECTS or an option
(files or folders), or its package declares an entry point in the group `infotraj.effects` that names a class or a
module. Nothing else needs to change.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
from collections.abc import Iterable
from functools import lru_cache
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType

from infotraj.arguments import AnyPath, as_paths
from infotraj.effects.base import Effect
from infotraj.effects.inertia_products import InertiaProducts
from infotraj.effects.rotor_height import RotorHeight
from infotraj.effects.rotor_torque import RotorTorque
from infotraj.errors import InputError, UsageError, problem

ENVIRONMENT = "INFOTRAJ_EFFECTS"
GROUP = "infotraj.effects"
# In models, and never named.
OF_THE_FILE: dict[str, type[Effect]] = {c.name: c for c in (InertiaProducts, RotorHeight, RotorTorque)}
_FAMILIES = (
    *("rigid_body", "thrust", "thrust_curve", "actuators", "drag", "forward_flight", "air", "steady", "gyroscopic"),
    *("load", "measurement"),
)


def catalogue(paths: AnyPath | Iterable[AnyPath] = ()) -> dict[str, type[Effect]]:
    """Every known effect by name, built-in ones in the catalogue's order, then the user's.

    paths: files or folders beside those of INFOTRAJ_EFFECTS and of the entry points. InputError where a file cannot be
    used or a name is taken.
    """
    found = dict(_built_in())
    for source, module_or_class in (*_of_files(paths), *_of_packages()):
        for cls in _effects_in(module_or_class):
            _checked(cls, source)
            if found.get(cls.name, OF_THE_FILE.get(cls.name, cls)) is not cls:
                raise InputError(
                    problem(f"{source}: the name {cls.name} is taken", "a name of its own", "Rename the effect.")
                )
            found[cls.name] = cls
    return found


def effect_class(name: str, paths: AnyPath | Iterable[AnyPath] = ()) -> type[Effect]:
    """The effect of that name, or the number of the file. UsageError, with the names that come close, for no such."""
    known = catalogue(paths)
    if name in OF_THE_FILE:
        return OF_THE_FILE[name]
    if name not in known:
        import difflib

        holding = sorted(n for n in known if name in n) if name else []
        close = list(dict.fromkeys([*holding, *difflib.get_close_matches(name, known, n=3)])) or ["a name of the list"]
        raise UsageError(problem(f"no effect {name!r}", " or ".join(close), "The list: `infotraj effects`."))
    return known[name]


@lru_cache(maxsize=1)
def _built_in() -> dict[str, type[Effect]]:
    found = {}
    for family in _FAMILIES:
        for cls in _effects_in(importlib.import_module(f"infotraj.effects.{family}")):
            found[cls.name] = cls
    return found


def effect_files(paths: AnyPath | Iterable[AnyPath] = ()) -> list[Path]:
    """The files with a user's own effects, there or not: of `paths` (files or folders) and of INFOTRAJ_EFFECTS."""
    named = [
        *as_paths("effects_from", paths),
        *(Path(p) for p in os.environ.get(ENVIRONMENT, "").split(os.pathsep) if p),
    ]
    files: list[Path] = []
    for path in named:
        if path.is_dir():
            files += sorted(p for p in path.glob("*.py") if not p.name.startswith(("_", ".")))
        else:
            files.append(path)
    return files


def _of_files(paths: AnyPath | Iterable[AnyPath]) -> list[tuple[str, ModuleType]]:
    files = effect_files(paths)
    for path in files:
        if not path.is_file():
            raise InputError(
                problem(f"{path}: no such file or folder", "a Python file with effects", "Check the path.")
            )
    unique = list(dict.fromkeys(p.resolve() for p in files))
    return [(str(p), _load(p, p.stat().st_mtime_ns)) for p in unique]


@lru_cache(maxsize=64)
def _load(path: Path, changed: int) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"infotraj_effects_{path.stem}_{abs(hash(path))}", path)
    if spec is None or spec.loader is None:
        raise InputError(problem(f"{path}: not a Python file", "a file that ends in .py", "Rename it."))
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except InputError:
        raise
    except Exception as error:
        what = f"{type(error).__name__}: {error}".splitlines()[0]
        raise InputError(
            problem(f"{path}: cannot be imported ({what})", "a Python file with effects", "Correct it.")
        ) from error
    if not _effects_in(module):
        raise InputError(
            problem(f"{path}: holds no effect", "a subclass of infotraj.effects.Effect", "See docs/effects.md.")
        )
    return module


@lru_cache(maxsize=1)
def _of_packages() -> tuple[tuple[str, object], ...]:
    """What installed packages declare, asked once: looking through all of them takes 6 ms."""
    found = []
    for entry in entry_points(group=GROUP):
        try:
            found.append((f"entry point {entry.name}", entry.load()))
        except Exception as error:
            what = f"{type(error).__name__}: {error}".splitlines()[0]
            raise InputError(
                problem(
                    f"entry point {entry.name} = {entry.value}: {what}", "a module or a class", "Repair the package."
                )
            ) from error
    return tuple(found)


def _effects_in(source: object) -> list[type[Effect]]:
    if isinstance(source, type) and issubclass(source, Effect):
        return [source]
    classes = [c for c in vars(source).values() if isinstance(c, type) and issubclass(c, Effect)]
    return [c for c in classes if c.__module__ == getattr(source, "__name__", None) and hasattr(c, "name")]


def _checked(cls: type[Effect], source: str) -> None:
    lacking = [a for a in ("name", "place", "parameters") if not hasattr(cls, a)]
    if lacking:
        raise InputError(
            problem(f"{source}: {cls.__name__} has no {', '.join(lacking)}", "name, place and parameters", "Add them.")
        )
