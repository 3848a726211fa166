"""What a command will write, tried before it computes: no output may be read as well, and each can be written."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory

from infotraj.errors import InfotrajError, UsageError, problem

Named = Mapping[str, Path | Sequence[Path] | None]


def require_outputs(files: Named, folders: Named, inputs: Mapping[str, Sequence[Path]]) -> None:
    """UsageError where an output is an input or another output; InfotrajError where it cannot be written.

    files, folders: one or several by their options, None where an option is not given; inputs: by what they are in
    words. Nothing is left behind.
    """
    named = [(option, path) for option, paths in {**files, **folders}.items() for path in _listed(paths)]
    for option, path in named:
        for what, paths in inputs.items():
            if any(_same(path, p) for p in paths):
                raise UsageError(problem(f"{option} {path} is {what}", "a new file", "Choose another name."))
    for (first, a), (second, b) in combinations(named, 2):
        if _same(a, b):
            found = f"{first} and {second} are both {a}"
            raise UsageError(problem(found, "a file for each", "Choose another name for one."))
    for option, path in named:
        _try(option, path, folder=option in folders)


def _listed(paths: Path | Sequence[Path] | None) -> Sequence[Path]:
    return [] if paths is None else [paths] if isinstance(paths, Path) else paths


def _same(a: Path, b: Path) -> bool:
    try:
        return os.path.samefile(a, b)
    except OSError:  # one of them is not there
        return os.path.realpath(a) == os.path.realpath(b)


def _try(option: str, path: Path, *, folder: bool) -> None:
    """InfotrajError unless a file can be made at this path, or in this folder."""
    place = path if folder else path.parent
    try:
        there = next(p for p in (place, *place.parents) if p.exists())
        wrong = "is a folder" if not folder and path.is_dir() else "is no plain file" if _special(path) else ""
        if not there.is_dir():
            wrong = "is a file" if there == path else f"lies in {there}, which is a file"
        if not wrong:
            _build(there, place.relative_to(there), "file" if folder else path.name)
    except OSError as error:
        wrong = f"cannot be written ({error.strerror})"
    if wrong:
        expected = "a folder that can be written to" if folder else "a file that can be written"
        raise InfotrajError(problem(f"{option} {path} {wrong}", expected, "Choose another place."))


def _special(path: Path) -> bool:
    """A device or a pipe: it would be replaced by a file."""
    return path.exists() and not path.is_file() and not path.is_dir()


def _build(there: Path, missing: Path, name: str) -> None:
    """Makes folders and a file in a folder of its own, and takes them away: no other run sees or loses any of them."""
    with TemporaryDirectory(prefix=".", suffix=".try", dir=there) as own:
        place = Path(own, missing)
        place.mkdir(parents=True, exist_ok=True)
        (place / name).touch()
