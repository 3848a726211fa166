"""The one folder that the app works on: what lies in it, and which names may be written to it."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from infotraj.errors import InputError, UsageError, problem

FLIGHTS = (".parquet", ".csv")
LOGS = (".bag", ".mcap", ".db3", ".ulg", ".bin", ".bbl", ".bfl", ".log", ".tsv", ".txt", ".dat")
MODELS = (".yaml", ".yml")
_DEPTH = 2  # folders below DIR that are looked into
_MOST = 500  # files that are listed
_WORK = ".infotraj_app-"
_LONGEST = 100
_PARTS = {".mcap", ".db3"}  # of a ROS 2 bag
_MAPPING = re.compile(r"^(?:streams|extends)\s*:", re.MULTILINE)  # what no vehicle and no model file says
_EFFECTS = re.compile(r"^effects\s*:", re.MULTILINE)  # what no vehicle file says
_REFERENCE = b"t,ref_px,"
_PEEK = 65536
HEAD = 64  # bytes that tell a log


@dataclass
class Folder:
    """DIR, and a folder inside it that lives as long as the server: `work`. seen: what was found in files, by name."""

    top: Path
    work: Path
    seen: dict[str, tuple[object, Mapping[str, Any]]] = field(default_factory=dict)

    def listed(self) -> list[dict[str, object]]:
        """What can be chosen: its path in DIR, `flight`, `log`, `model` or `mapping`, its size, and whether it is a
        model with effects, not a vehicle file; by name."""
        rows = [
            {
                "name": p.relative_to(self.top).as_posix(),
                "kind": k,
                "size": _size(p),
                "effects": k == "model" and _says(p, _EFFECTS),
            }
            for p, k in self._files()
        ]
        return sorted(rows, key=lambda row: str(row["name"]))

    def _files(self) -> Iterator[tuple[Path, str]]:
        """What is listed, _MOST of it at most. A ROS 2 bag is a folder, and one log."""
        count, below = 0, [(self.top, 0)]
        while below:
            folder, depth = below.pop(0)
            for path in _inside(folder):
                if path.is_symlink() and not path.resolve().is_relative_to(self.top):
                    continue
                kind = _kind(path)
                if kind is None and path.is_dir() and not path.is_symlink() and depth < _DEPTH:
                    below.append((path, depth + 1))
                if kind is not None:
                    yield path, kind
                    count += 1
                if count == _MOST:
                    return

    def chosen(self, name: object, *kinds: str) -> Path:
        """The file of that name, as it is listed. UsageError for any other: no name becomes a path by itself."""
        for row in self.listed():
            if row["name"] == name and row["kind"] in kinds:
                return Path(str(name))
        raise UsageError(
            problem(f"no file {str(name)[:_LONGEST]!r}", f"a {' or '.join(kinds)} of the folder", "Look again.")
        )

    def stamp(self, path: Path) -> object:
        """Of a file of DIR: another one when it has changed, None where there is none."""
        place = self.top / path
        try:
            found = [p.stat() for p in (_inside(place) if place.is_dir() else [place])]
        except OSError:
            return None
        return [(f.st_size, f.st_mtime_ns) for f in found]

    def remember(self, path: Path, stamp: object, answer: Mapping[str, Any]) -> None:
        """What was found in a file when it had this stamp: for every window, until the file changes."""
        self.seen[str(path)] = (stamp, answer)

    def remembered(self) -> dict[str, Mapping[str, Any]]:
        """What was found in the files as they are now, by name."""
        self.seen = {name: held for name, held in self.seen.items() if held[0] == self.stamp(Path(name)) is not None}
        return {name: answer for name, (_, answer) in self.seen.items()}

    def free(self, name: str) -> Path:
        """A path in DIR for this safe name that does not exist yet."""
        path = self.top / name
        number = 1
        while path.exists() or path.is_symlink():
            number += 1
            path = self.top / f"{Path(name).stem}-{number}{Path(name).suffix}"
        return path

    def take(self, part: Path, name: str) -> Path:
        """Moves a finished file into DIR under this safe name, or the next one that is free: nothing is overwritten."""
        while True:
            path = self.free(name)
            try:
                open(path, "x").close()  # the name is ours from here on
            except FileExistsError:
                continue
            os.replace(part, path)
            return path

    def take_folder(self, part: Path, name: str) -> Path:
        """The same of a finished folder."""
        while True:
            path = self.free(_plain(name) or "bag")
            try:
                path.mkdir()
            except FileExistsError:
                continue
            os.replace(part, path)
            return path

    def close(self) -> None:
        """Removes what the server wrote for itself."""
        shutil.rmtree(self.work, ignore_errors=True)


def open_folder(path: Path) -> Folder:
    """InputError where it is no folder that can be written."""
    top = path.resolve()
    if not top.is_dir():
        raise InputError(problem(f"{path}: no folder", "a folder with flights and models", "Name another, or make it."))
    try:
        work = Path(tempfile.mkdtemp(prefix=_WORK, dir=top))
    except OSError as error:
        raise InputError(
            problem(f"{path}: {error.strerror}", "a folder that can be written", "Choose another.")
        ) from error
    return Folder(top, work)


def safe_name(name: str, suffixes: tuple[str, ...]) -> str:
    """A file name made of letters, digits, `.`, `_` and `-` that says nothing about a place. UsageError for a suffix
    that is not among these."""
    last = name.replace("\\", "/").rsplit("/", 1)[-1]
    suffix = Path(last).suffix.lower()
    if suffix not in suffixes:
        raise UsageError(
            problem(f"a file with {suffix[:20] or 'no suffix'}", ", ".join(suffixes), "Rename it by what it holds.")
        )
    return (_plain(last[: -len(suffix)]) or "file") + suffix


def log_name(name: str) -> str:
    """A safe name for what may be a log, whatever it is called: one with a suffix that is listed keeps it, any other
    has none (FLIGHT.01: FLIGHT_01), and its first bytes must tell what it is. UsageError where no name is left."""
    last = name.replace("\\", "/").rsplit("/", 1)[-1]
    if has_suffix(last):
        return safe_name(last, FLIGHTS + LOGS + MODELS)
    plain = _plain(last).replace(".", "_")
    if not plain:
        raise UsageError(problem("a file without a name", "letters or digits", "Give it one."))
    return plain


def has_suffix(name: str) -> bool:
    """Whether a name tells by its suffix what may be in the file."""
    return Path(name).suffix.lower() in FLIGHTS + LOGS + MODELS


def require_log(name: str, head: bytes) -> None:
    """UsageError where neither the name nor the first bytes (HEAD of them) of a file tell what it holds."""
    if not has_suffix(name) and not _begins_as_log(head):
        expected = f"{', '.join(FLIGHTS + LOGS + MODELS)}, or a log that its first bytes name"
        raise UsageError(problem(f"{name}: no known suffix, and no known log", expected, "Rename it by what it holds."))


def _begins_as_log(head: bytes) -> bool:
    from infotraj.importing.opening import kind_by_first_bytes

    return kind_by_first_bytes(head) is not None


def _plain(name: str) -> str:
    """The last part of a name, of letters, digits, `.`, `_` and `-`; nothing where none is left."""
    last = name.replace("\\", "/").rsplit("/", 1)[-1]
    return re.sub(r"[^A-Za-z0-9._-]+", "_", last).strip("._-")[:_LONGEST]


def is_mapping(path: Path) -> bool:
    """Whether a YAML file says what a mapping says."""
    return _says(path, _MAPPING)


def _says(path: Path, what: re.Pattern[str]) -> bool:
    """By its text, without reading it as YAML."""
    try:
        with open(path, errors="replace") as file:
            return what.search(file.read(_PEEK)) is not None
    except OSError:
        return False


def _kind(path: Path) -> str | None:
    if path.is_dir():
        return "log" if is_bag(path) else None
    suffix = path.suffix.lower()
    if suffix in MODELS:
        if path.name.endswith((".meta.yaml", "_metadata.yaml")):
            return None
        return "mapping" if is_mapping(path) else "model"
    if not path.is_file():
        return None
    if suffix not in FLIGHTS + LOGS:
        return "log" if _is_log(path) else None
    return None if suffix == ".csv" and _is_reference(path) else "flight" if suffix in FLIGHTS else "log"


def _is_log(path: Path) -> bool:
    """Whether a file whose name does not tell begins as a log does."""
    try:
        found = path.stat()
        return _held_log(path, found.st_size, found.st_mtime_ns)
    except OSError:
        return False


@lru_cache(maxsize=4 * _MOST)
def _held_log(path: Path, size: int, changed: int) -> bool:
    with open(path, "rb") as file:
        return _begins_as_log(file.read(HEAD))


def _is_reference(path: Path) -> bool:
    """Whether a CSV is what a vehicle is to fly, which nobody has flown."""
    try:
        with open(path, "rb") as file:
            return file.readline(_PEEK).startswith(_REFERENCE)
    except OSError:
        return False


def is_bag(folder: Path) -> bool:
    """A folder that a ROS 2 recorder wrote: its metadata, and parts that lie in it and nowhere else."""
    parts = _inside(folder)
    held = {p.suffix for p in parts if p.is_file()}
    return (folder / "metadata.yaml").is_file() and bool(held & _PARTS) and not any(p.is_symlink() for p in parts)


def _inside(folder: Path) -> list[Path]:
    """What lies in a folder, but for what is hidden; nothing where it cannot be read."""
    try:
        return sorted(p for p in folder.iterdir() if not p.name.startswith("."))
    except OSError:
        return []


def _size(path: Path) -> int:
    return sum(p.stat().st_size for p in (_inside(path) if path.is_dir() else [path]))
