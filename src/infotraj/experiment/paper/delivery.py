"""Where flights of a vehicle of your own are put. Light, for the workflow asks on every start."""

from __future__ import annotations

from pathlib import Path

TABLES = (".parquet", ".csv")
MAPPING = "mapping.yaml"  # beside the logs, where the shipped mappings do not fit


def delivered(folder: str | Path, name: str) -> list[str]:
    """What lies in `folder` for the flight `name`: NAME with any ending, or a bag's folder NAME; metadata left out."""
    found = [p for p in Path(folder).glob(f"{name}*") if p.name.split(".")[0] == name and p.suffix != ".yaml"]
    return sorted(str(path) for path in found)
