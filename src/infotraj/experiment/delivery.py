"""Where flight tables of a vehicle of your own are put. Light, for the workflow asks on every start."""

from __future__ import annotations

from pathlib import Path

SUFFIXES = (".parquet", ".csv")


def delivered(folder: str | Path, name: str) -> list[str]:
    """The files of the flight `name` that lie in `folder`: none, one, or by mistake one of each kind."""
    return [str(path) for path in (Path(folder) / f"{name}{suffix}" for suffix in SUFFIXES) if path.is_file()]
