"""Checks that were made before: one that nothing has changed for is read back instead of made again.

A check costs twenty times what comparing a model with the same flight does, and every command makes it. What it
depends on is its key: the flight's numbers and metadata, the vehicle, and the code of the checks. Entries lie in the
user's cache directory (INFOTRAJ_CACHE overrides it) and are pickles, as numba's are; without a place to write, every
check is made.
"""

from __future__ import annotations

import hashlib
import os
import pickle
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

import infotraj

VARIABLE = "INFOTRAJ_CACHE"
_MOST = 500  # entries that are kept
_CODE = ("checking", "dynamics", "flight.py", "rotations.py", "vehicle.py")


def remembered(parts: Iterable[Any], make: Callable[[], Any]) -> Any:
    """What `make` gives, or gave when these parts (anything whose repr says all) and the checks' code were the same."""
    key = hashlib.sha256("\0".join([_code(), *map(repr, parts)]).encode()).hexdigest()
    path = _folder() / f"{key}.pickle"
    try:
        with open(path, "rb") as file:
            found = pickle.load(file)
        os.utime(path)
        return found
    except Exception:  # absent, damaged, or of another version of a library: made again
        made = make()
    _write(path, made)
    return made


def _write(path: Path, made: Any) -> None:
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_bytes(pickle.dumps(made))
        os.replace(part, path)
        entries = sorted(path.parent.glob("*.pickle"), key=lambda p: p.stat().st_mtime)
        for old in entries[: max(0, len(entries) - _MOST)]:
            old.unlink(missing_ok=True)
    except OSError:  # a cache is a help, never a reason to stop
        pass
    finally:
        part.unlink(missing_ok=True)


def _folder() -> Path:
    own = os.environ.get(VARIABLE)
    if own:
        return Path(own) / "checks"
    base = os.environ.get("LOCALAPPDATA") or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "infotraj" / "checks"


@cache
def _code() -> str:
    """A hash of the sources that a check runs."""
    package = Path(infotraj.__file__).parent
    digest = hashlib.sha256(infotraj.__version__.encode())
    for name in _CODE:
        at = package / name
        for path in sorted(at.glob("*.py")) if at.is_dir() else [at]:
            digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()
