"""Cells of a table as numbers: plain ones, and lists in a cell ("[1, 2, 3]", numpy's "[1. 2. 3.]"), a column each."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from infotraj.errors import InputError, problem
from infotraj.rotations import Array

_LIST = re.compile(r"\s*(?:array|tensor)?\s*[\[(].*[\])]\s*", re.DOTALL)
_MARKS = str.maketrans("[](),;", " " * 6)
_REMEDY = "Write it again, or correct the row."
_LONGEST = 1000
_COMMA = re.compile(r"\s*[+-]?\d*,\d+(?:[eE][+-]?\d+)?\s*")
_DATE = re.compile(r"\s*(?:\d{4}-\d\d?-\d\d?|\d\d?:\d\d:\d\d)")


def list_length(cells: Any) -> int:
    """How many numbers the first filled cell holds, where it is a list of numbers; else 0."""
    for cell in cells:
        if cell is None or isinstance(cell, float):
            continue
        if not isinstance(cell, (np.ndarray, list)) and not (isinstance(cell, str) and _LIST.fullmatch(cell)):
            return 0
        numbers = _split(cell)
        return len(numbers) if numbers is not None and 0 < len(numbers) <= _LONGEST else 0
    return 0


def list_numbers(column: Any, name: str, length: int, before: int, path: Path) -> Array:
    """A column of lists as (n, length), an empty cell as NaN. InputError where a list is longer or shorter."""
    out = np.full((len(column), length), np.nan)
    for k, cell in enumerate(column):
        if cell is None or isinstance(cell, float) or (isinstance(cell, str) and not cell.strip()):
            continue
        numbers = _split(cell)
        if numbers is None or len(numbers) != length:
            raise InputError(
                problem(
                    f"{path}: column {name!r}, row {before + k + 1}: {' '.join(str(cell).split())[:40]!r}",
                    f"a list of {length} numbers, as in the first row",
                    _REMEDY,
                )
            )
        out[k] = numbers
    return out


def numbers_of(column: Any, name: str, before: int, path: Path) -> Array:
    """A column as doubles (n,), an empty cell as NaN. InputError at the first cell that is no number."""
    if pd.api.types.is_numeric_dtype(column) or pd.api.types.is_bool_dtype(column):
        return column.to_numpy(dtype=float, na_value=np.nan)
    values = pd.to_numeric(column, errors="coerce")
    text = np.flatnonzero(values.isna().to_numpy() & column.notna().to_numpy())
    if text.size:
        k = int(text[0])
        raise InputError(
            problem(
                f"{path}: column {name!r}, row {before + k + 1}: {str(column.iloc[k])[:40]!r}",
                "a number or an empty cell",
                _cell_remedy(str(column.iloc[k]), before + k == 0 and text.size == 1, path),
            )
        )
    return values.to_numpy(dtype=float, na_value=np.nan)


def _cell_remedy(cell: str, first_alone: bool, path: Path) -> str:
    """What to do with a cell that is no number; `first_alone`: it stands in the first row, and numbers follow."""
    if _DATE.match(cell):
        return "Write times as seconds: (pd.to_datetime(t) - pd.to_datetime(t)[0]).dt.total_seconds() in pandas."
    if path.suffix.lower() == ".parquet":
        return _REMEDY
    if _COMMA.fullmatch(cell):
        return 'It has a decimal comma: give a mapping with `table: {decimal: ","}` (`extends: flight_table`).'
    if first_alone:
        return (
            "Are these units? Leave the row out, or give a mapping with `table: {skip: 2, header: [t, px, ..]}`, "
            "the names of the columns (`extends: flight_table`)."
        )
    return _REMEDY


def _split(cell: Any) -> list[float] | None:
    try:
        if isinstance(cell, str):
            return [float(number) for number in cell.strip().removeprefix("array").translate(_MARKS).split()]
        return [float(number) for number in np.ravel(np.asarray(cell, dtype=float))]
    except (TypeError, ValueError):
        return None
