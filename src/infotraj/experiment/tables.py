"""Tables of single seeds put together, each row saying where it comes from."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from infotraj.errors import InputError, problem


def gather(*, tables: Sequence[str | Path], table: str | Path) -> None:
    """Writes the rows of all `tables` (CSV, the same columns) below each other. InputError where columns differ."""
    parts = {path: pd.read_csv(path) for path in tables}
    columns = [list(part.columns) for part in parts.values()]
    for path, names in zip(parts, columns, strict=True):
        if names != columns[0]:
            raise InputError(problem(f"{path}: columns {names}", f"{columns[0]}", "Write all tables by one version."))
    target = Path(table)
    target.parent.mkdir(parents=True, exist_ok=True)
    hidden = target.with_name(f".{target.name}.part")
    pd.concat(parts.values(), ignore_index=True).to_csv(hidden, index=False)
    os.replace(hidden, target)
