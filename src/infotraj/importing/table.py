"""Tables: CSV (comma, semicolon or tab, one header line) and Parquet, in chunks, only the asked columns."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq

from infotraj.errors import InputError, problem
from infotraj.importing.log import Request, Samples, Topic, reading
from infotraj.rotations import Array

_CHUNK = 200_000
_EXPECTED = "a CSV or Parquet table with one header line"
_REMEDY = "Write it again, or correct the row."


class TableFile:
    """One table; it is a log with a single topic whose fields are the columns."""

    kind = "table"

    def __init__(self, path: Path, allow_damaged: bool = False) -> None:
        self.path = path
        self.notes: list[str] = []
        self._parquet = path.suffix == ".parquet"
        rows: int | None = None
        with reading(path, _EXPECTED, _REMEDY):
            if self._parquet:
                file = pq.ParquetFile(path)
                self.columns = tuple(file.schema_arrow.names)
                rows = file.metadata.num_rows
                file.close()
            else:
                self._delimiter, self.columns = _header(path)
                self._per_row = _row_delimiters(path, self._delimiter, len(self.columns))
                uneven = _uneven_row(path, self._delimiter, self._per_row)
                self._cut = uneven is not None and uneven[2]
                if uneven is not None and not (allow_damaged and self._cut):
                    remedy = "give --allow-damaged to leave that row out" if self._cut else "correct the row"
                    raise InputError(
                        problem(
                            f"{path}: {'the last row' if self._cut else f'row {uneven[0]}'} has {uneven[1]} fields",
                            f"{self._per_row + 1}",
                            f"It may be truncated: copy it again, or {remedy}.",
                        )
                    )
                if self._cut:
                    self.notes.append("the last row was cut and is left out")
        twice = sorted({c for c in self.columns if self.columns.count(c) > 1})
        if twice:
            raise InputError(
                problem(f"{path}: column {twice[0]!r} appears twice", "every column once", "Rename one of them.")
            )
        self.topics = [Topic(path.name, "", 0, rows)]

    def close(self) -> None:
        """Nothing is held open."""

    def has(self, topic: Topic, name: str) -> bool:
        """True where the table has the column."""
        return name.replace("*", "0") in self.columns

    def first(self, topic: Topic, name: str) -> Any:
        """The column's value in the first row."""
        if name not in self.columns:
            return None
        with reading(self.path, _EXPECTED, _REMEDY):
            if self._parquet:
                with pq.ParquetFile(self.path) as file:
                    for batch in file.iter_batches(batch_size=1, columns=[name]):
                        return batch.column(0)[0].as_py() if batch.num_rows else None
                return None
            head = pd.read_csv(self.path, sep=self._delimiter, usecols=[name], nrows=1, encoding="utf-8-sig")
        return head[name].iloc[0] if len(head) else None

    def read(self, requests: list[Request]) -> list[Samples]:
        """One pass; every asked column as doubles, an empty cell as NaN."""
        names: dict[str, None] = {}
        whole = {t for request in requests for t in request.times}
        expanded = []
        for request in requests:
            per_number = {n: self._expand(n) for n in request.numbers}
            expanded.append(per_number)
            for group in per_number.values():
                names.update(dict.fromkeys(group))
            names.update(dict.fromkeys(request.times))
        with reading(self.path, _EXPECTED, _REMEDY):
            data = self._columns(list(names), whole)
        found = []
        for request, per_number in zip(requests, expanded, strict=True):
            numbers = {
                n: np.stack([data[c] for c in group], axis=-1) if "*" in n else data[n]
                for n, group in per_number.items()
            }
            found.append(Samples(None, {t: data[t] for t in request.times}, numbers))
        return found

    def _expand(self, name: str) -> list[str]:
        if "*" not in name:
            return [name]
        group: list[str] = []
        while name.replace("*", str(len(group))) in self.columns:
            group.append(name.replace("*", str(len(group))))
        return group

    def _columns(self, names: list[str], whole: set[str]) -> dict[str, Any]:
        parts: dict[str, list[Any]] = {n: [] for n in names}
        before = 0
        for chunk in self._chunks(names):
            for name in names:
                # Nanoseconds since 1970 do not fit a double: a time of whole numbers stays one.
                integer = name in whole and pd.api.types.is_integer_dtype(chunk[name])
                column = chunk[name].to_numpy(np.int64) if integer else None
                parts[name].append(_numbers(chunk[name], name, before, self.path) if column is None else column)
            before += len(chunk)
        out = {n: np.concatenate(p) if p else np.zeros(0) for n, p in parts.items()}
        if not self._parquet and self._cut:
            out = {n: values[:-1] for n, values in out.items()}
        return out

    def _chunks(self, names: list[str]) -> Any:
        if self._parquet:
            with pq.ParquetFile(self.path) as file:
                for batch in file.iter_batches(batch_size=_CHUNK, columns=names):
                    yield batch.to_pandas()
            return
        with pd.read_csv(
            self.path,
            sep=self._delimiter,
            header=0,
            names=[*self.columns, *([""] if self._per_row == len(self.columns) else [])],
            usecols=names,
            chunksize=_CHUNK,
            encoding="utf-8-sig",
            skipinitialspace=True,
            low_memory=False,
            index_col=False,
            on_bad_lines="error",
        ) as reader:
            yield from reader


def _numbers(column: Any, name: str, before: int, path: Path) -> Array:
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
                _REMEDY,
            )
        )
    return values.to_numpy(dtype=float, na_value=np.nan)


def _header(path: Path) -> tuple[str, tuple[str, ...]]:
    with open(path, encoding="utf-8-sig", newline="") as file:
        line = file.readline(1 << 20)
    if "\0" in line or not line.strip():
        raise ValueError("no header line")
    delimiter = max(",;\t", key=line.count)
    names = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    return delimiter, tuple(n.strip().removeprefix("#").strip() for n in names)


def _uneven_row(path: Path, delimiter: str, expected: int) -> tuple[int, int, bool] | None:
    """(row, fields, is last) of the first row that has not `expected` delimiters; None where all have.

    Counted in bytes, block by block: the parser itself takes a row of any length when only some columns are asked.
    A file with quotes, whose cells may hold delimiters, is left to the parser.
    """
    mark, row, carried, length = ord(delimiter), -1, 0, 0
    with open(path, "rb") as file:
        while block := file.read(1 << 22):
            if b'"' in block:
                return None
            data = np.frombuffer(block, dtype=np.uint8)
            marks = np.flatnonzero((data == mark) | (data == 10))
            line_ends = np.flatnonzero(data[marks] == 10)
            ends = marks[line_ends]
            counts = np.diff(line_ends, prepend=-1) - 1
            lengths = np.diff(ends, prepend=-1) - 1
            if ends.size:
                counts[0] += carried
                lengths[0] += length
                # A lone carriage return is an empty line too.
                wrong = np.flatnonzero((counts != expected) & (lengths > 1))
                wrong = wrong[wrong + row + 1 > 0]  # the header may lack the delimiter that ends every row
                if wrong.size:
                    k = int(wrong[0])
                    is_last = k == ends.size - 1 and ends[-1] == data.size - 1 and not file.peek(1)
                    return row + 1 + k, int(counts[k]) + 1, is_last
                row += ends.size
                carried, length = int(marks.size - 1 - line_ends[-1]), int(data.size - 1 - ends[-1])
            else:
                carried, length = carried + int(marks.size), length + data.size
    if length > 0 and carried != expected and row >= 0:
        return row + 1, carried + 1, True
    return None


def _row_delimiters(path: Path, delimiter: str, columns: int) -> int:
    """How many delimiters a row has: one less than columns, or as many where every row ends with one."""
    with open(path, encoding="utf-8-sig", newline="") as file:
        file.readline(1 << 20)
        first = file.readline(1 << 20).rstrip("\r\n")
    ends_with_one = first.count(delimiter) == columns and first.endswith(delimiter)
    return columns if ends_with_one else columns - 1
