"""Mapping files: those that come with the tool, a user's own, and one that extends another."""

from __future__ import annotations

import os
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from infotraj.arguments import AnyPath
from infotraj.errors import UsageError, problem
from infotraj.importing.mapping import Mapping
from infotraj.importing.settings import merged, with_settings
from infotraj.vehicle import validation_line

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml, where it is: ten times faster
_DEEPEST = 8  # files that extend one another


@cache
def shipped() -> dict[str, Mapping]:
    """The mappings that come with the tool, by name."""
    folder = files("infotraj.importing") / "mappings"
    found = sorted((f for f in folder.iterdir() if f.name.endswith(".yaml")), key=lambda f: f.name)
    return {m.name: m for m in (_mapping(yaml.load(f.read_text(), Loader=_LOADER), f.name) for f in found)}


def load_mapping(name: AnyPath) -> Mapping:
    """A shipped mapping by its name, or a mapping file (YAML) by its path. UsageError where it is neither."""
    return _load(os.fspath(name), None, 0)


def parse_mapping(content: object, source: str = "mapping") -> Mapping:
    """A mapping from the content of its file. UsageError, one line, naming `source`, where it is not valid.

    `extends: NAME` (shipped, or a path from the file's folder) takes over all that the file does not say; streams of
    the file stand before those that it takes over, in place of those of the same name. `set: {CHANNEL: {KEY: VALUE}}`
    replaces keys of a channel in every stream that has it.
    """
    return _parse(content, source, Path(source).parent, 0)


def mapping_files(name: AnyPath) -> list[Path]:
    """The file of a mapping and those that it extends, as far as they can be read; none of a shipped one."""
    found: list[Path] = []
    following, folder = os.fspath(name), None
    while following not in shipped() and len(found) <= _DEEPEST:
        path = _place(following, folder)
        found.append(path)
        try:
            content = yaml.safe_load(path.read_text())
        except (OSError, yaml.YAMLError, ValueError, RecursionError):
            break
        base = content.get("extends") if isinstance(content, dict) else None
        if not isinstance(base, str):
            break
        following, folder = base, path.parent
    return found


def _place(name: str, folder: Path | None) -> Path:
    """Where a mapping file is: in the folder of the file that names it, else where the command runs."""
    beside = folder / name if folder is not None else None
    return beside if beside is not None and _is_file(beside) else Path(name)


def _load(name: str, folder: Path | None, depth: int) -> Mapping:
    if name in shipped():
        return shipped()[name]
    path = _place(name, folder)
    if not _is_file(path):
        raise UsageError(
            problem(
                f"mapping {name!r}: no such file", f"a YAML file or one of {', '.join(shipped())}", "Check the path."
            )
        )
    try:
        content = yaml.safe_load(path.read_text())
    # A deeply nested file overflows the parser's stack; a date that is none is a ValueError.
    except (OSError, yaml.YAMLError, ValueError, RecursionError) as error:
        what = " ".join(str(error).split())[:160]
        raise UsageError(
            problem(f"mapping {path}: cannot be read ({what})", "YAML", "See docs/import.md for an example.")
        ) from error
    return _parse(content, str(path), path.parent, depth)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name longer than the file system takes
        return False


def _parse(content: object, source: str, folder: Path, depth: int) -> Mapping:
    if not isinstance(content, dict):
        raise UsageError(
            problem(f"{source}: holds {type(content).__name__}", "name, reads and streams", "See docs/import.md.")
        )
    if "extends" not in content:
        return _mapping(content, source)
    name = content["extends"]
    if not isinstance(name, str) or depth >= _DEEPEST:
        found = f"extends {name!r}" if not isinstance(name, str) else f"{_DEEPEST} files extend one another"
        raise UsageError(problem(f"{source}: {found}"[:200], "a shipped mapping's name or a path", "Correct it."))
    own = {key: value for key, value in content.items() if key != "extends"}
    return _mapping(_over(_load(name, folder, depth + 1), own), source)


def _over(base: Mapping, own: dict[Any, Any]) -> dict[Any, Any]:
    """`own` over what `base` says."""
    content = base.model_dump(mode="json", exclude_defaults=True) | own
    settings = own.get("set", {})
    if isinstance(settings, dict) and all(isinstance(keys, dict) for keys in settings.values()):
        content["set"] = merged(base.set, settings)
    streams = own.get("streams", [])
    if isinstance(streams, list):
        named = {s.get("name") for s in streams if isinstance(s, dict) and isinstance(s.get("name"), str)}
        taken_over = [s.model_dump(mode="json", exclude_defaults=True) for s in base.streams if s.name not in named]
        content["streams"] = [*streams, *taken_over]
    return content


def _mapping(content: Any, source: str) -> Mapping:
    try:
        mapping = Mapping.model_validate(content)
    except (ValidationError, RecursionError) as error:
        line = validation_line(error, Mapping) if isinstance(error, ValidationError) else "nested too deeply"
        raise UsageError(" ".join(f"{source}: {line}".split())) from error
    try:
        return with_settings(mapping, mapping.set)
    except UsageError as error:
        raise UsageError(f"{source}: {error}") from error
