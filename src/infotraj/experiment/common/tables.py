"""Tables of results as CSV, and those of single runs put together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from infotraj.errors import InputError, problem
from infotraj.writing import whole


def gather(*, tables: Sequence[str | Path], table: str | Path) -> None:
    """Writes the rows of all `tables` (CSV, the same columns) below each other. InputError where columns differ."""
    parts = {path: pd.read_csv(path) for path in tables}
    columns = [list(part.columns) for part in parts.values()]
    for path, names in zip(parts, columns, strict=True):
        if names != columns[0]:
            raise InputError(problem(f"{path}: columns {names}", f"{columns[0]}", "Write all tables by one version."))
    write_table(pd.concat(parts.values(), ignore_index=True), table)


def write_table(rows: pd.DataFrame, path: str | Path) -> None:
    """Writes a table of results as CSV, whole or not at all."""
    with whole(Path(path)) as part:
        rows.to_csv(part, index=False, float_format="%.9g")
