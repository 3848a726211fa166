"""Tables: text (CSV, or as a mapping's `table` says) and Parquet, in chunks, only the asked columns."""

from __future__ import annotations

from io import TextIOWrapper
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq

from infotraj.errors import InputError, problem
from infotraj.importing.log import Request, Samples, Topic, reading, what_is_left
from infotraj.importing.table_cells import list_length, list_numbers, numbers_of
from infotraj.importing.table_format import SPACE, TableFormat, TextLines
from infotraj.importing.table_lines import is_spaced, laid_out_header
from infotraj.progress import reached
from infotraj.text_rows import header, row_delimiters, uneven_row

_CHUNK = 200_000
_EXPECTED = "a CSV or Parquet table with one header line"
_REMEDY = "Write it again, or correct the row."


class TableFile:
    """One table; it is a log with a single topic whose fields are the columns."""

    kind = "table"

    def __init__(self, path: Path, allow_damaged: bool = False, layout: TableFormat | None = None) -> None:
        self.path = path
        self.notes: list[str] = []
        self._parquet = path.suffix.lower() == ".parquet"
        self._layout = layout
        self._cut = False
        rows: int | None = None
        with reading(path, _EXPECTED, _REMEDY):
            if self._parquet:
                file = pq.ParquetFile(path)
                self._names = tuple(file.schema_arrow.names)
                rows = file.metadata.num_rows
                file.close()
            else:
                self._open_text(allow_damaged)
            self._lists = self._list_columns()
        twice = sorted({c for c in self._names if self._names.count(c) > 1})
        if twice:
            raise InputError(
                problem(f"{path}: column {twice[0]!r} appears twice", "every column once", "Rename one of them.")
            )
        self.columns = tuple(
            part
            for name in self._names
            for part in ([f"{name}[{k}]" for k in range(self._lists[name])] if name in self._lists else [name])
        )
        self._known = frozenset(self.columns)
        self.topics = [Topic(path.name, "", 0, rows)]

    def _open_text(self, allow_damaged: bool) -> None:
        if self._layout is None and is_spaced(self.path):
            self._layout = TableFormat(separator=SPACE)
        if self._layout is None:
            self._delimiter, self._names = header(self.path)
            self._per_row = row_delimiters(self.path, self._delimiter, len(self._names))
            uneven = uneven_row(self.path, self._delimiter, self._per_row)
        else:
            self._delimiter, self._names = laid_out_header(self.path, self._layout)
            self._per_row = len(self._names) - 1
            uneven = self._uneven_line()
        self._cut = uneven is not None and uneven[2]
        if self._layout is None and uneven is not None and not uneven[2]:
            self._require_names_on_top(uneven[0])
        if uneven is not None and not (allow_damaged and self._cut):
            raise InputError(
                problem(
                    f"{self.path}: {'the last row' if self._cut else f'row {uneven[0]}'} has {uneven[1]} fields",
                    f"{self._per_row + 1}",
                    what_is_left(self.path) if self._cut else "It may be truncated: copy it again, or correct the row.",
                )
            )
        if self._cut:
            self.notes.append("the last row was cut and is left out")

    def _require_names_on_top(self, uneven: int) -> None:
        """InputError where the first line is a title or a comment, no names: row `uneven` has other columns."""
        with open(self.path, encoding="utf-8-sig", newline="") as file:
            line = file.readline(1 << 20).strip()
        mark = next((m for m in ("#", "%", "//") if line.startswith(m)), None)
        if len(self._names) > 1 and not (mark and uneven == 1):
            return
        layout = f'comment: "{mark}"' if mark else f"skip: {uneven}"
        raise InputError(
            problem(
                f"{self.path}: the first line is {line[:40]!r}, and row {uneven} has other columns",
                "the columns' names in the first line",
                f"Leave such lines out, or give a mapping with `table: {{{layout}}}` (`extends: flight_table`).",
            )
        )

    def _uneven_line(self) -> tuple[int, int, bool] | None:
        """As `uneven_row`, line by line, for a text with a layout of its own."""
        assert self._layout is not None
        lines = TextLines(self.path, self._layout)
        row, wrong = 0, None
        for row, line in enumerate(lines, start=int(self._layout.header is not None)):
            if wrong is not None:
                return (*wrong, False)
            if '"' in line:
                break
            fields = len(line.split()) if self._delimiter == SPACE else line.count(self._delimiter) + 1
            if fields != self._per_row + 1:
                wrong = (row, fields)
        for _ in lines:
            row += 1
        if lines.left_out:
            self.notes.append(f"{lines.left_out} lines without the line prefix are left out")
        return (*wrong, True) if wrong is not None else None

    def _list_columns(self) -> dict[str, int]:
        """Columns whose cells are lists, with the length of the first."""
        if self._parquet:
            with pq.ParquetFile(self.path) as file:
                nested = [f.name for f in file.schema_arrow if f.type.num_fields == 1]
                batch = next(file.iter_batches(batch_size=1000, columns=nested), None) if nested else None
                head = batch.to_pandas() if batch is not None else pd.DataFrame()
        else:
            head = self._frame(nrows=100, dtype=str)
        lengths = {str(name): list_length(head[name]) for name in head}
        return {name: length for name, length in lengths.items() if length}

    def close(self) -> None:
        """Nothing is held open."""

    def has(self, topic: Topic, name: str) -> bool:
        """True where the table has the column."""
        return name.replace("*", "0") in self._known

    def fields(self, topic: Topic) -> list[str]:
        """All columns."""
        return [name for name in self.columns if name]

    def first(self, topic: Topic, name: str) -> Any:
        """The column's value in the first row."""
        if name not in self._known:
            return None
        with reading(self.path, _EXPECTED, _REMEDY):
            if self._parquet:
                with pq.ParquetFile(self.path) as file:
                    for batch in file.iter_batches(batch_size=1, columns=[self._base(name)[0]]):
                        return batch.column(0)[0].as_py() if batch.num_rows else None
                return None
            head = self._frame(nrows=1, usecols=[self._base(name)[0]])
        return head.iloc[0, 0] if len(head) else None

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
        while name.replace("*", str(len(group))) in self._known:
            group.append(name.replace("*", str(len(group))))
        return group

    def _base(self, name: str) -> tuple[str, int | None]:
        """The column that holds a field, and the field's place in its lists."""
        if name in self._names:
            return name, None
        column, _, place = name.rpartition("[")
        return column, int(place[:-1])

    def _columns(self, names: list[str], whole: set[str]) -> dict[str, Any]:
        parts: dict[str, list[Any]] = {n: [] for n in names}
        asked = list(dict.fromkeys(self._base(n)[0] for n in names))
        before = 0
        for chunk in self._chunks(asked):
            lists = {
                column: list_numbers(chunk[column], column, self._lists[column], before, self.path)
                for column in asked
                if column in self._lists
            }
            for name in names:
                column, place = self._base(name)
                if place is not None:
                    parts[name].append(lists[column][:, place])
                    continue
                # Nanoseconds since 1970 do not fit a double: a time of whole numbers stays one.
                integer = name in whole and pd.api.types.is_integer_dtype(chunk[name])
                parts[name].append(
                    chunk[name].to_numpy(np.int64) if integer else numbers_of(chunk[name], name, before, self.path)
                )
            before += len(chunk)
        out = {n: np.concatenate(p) if p else np.zeros(0) for n, p in parts.items()}
        return {n: values[:-1] for n, values in out.items()} if self._cut else out

    def _chunks(self, names: list[str]) -> Any:
        if self._parquet:
            with pq.ParquetFile(self.path) as file:
                for k, batch in enumerate(file.iter_batches(batch_size=_CHUNK, columns=names)):
                    reached("reading", k * _CHUNK, file.metadata.num_rows)
                    yield batch.to_pandas()
            return
        lists = dict.fromkeys((n for n in names if n in self._lists), str)
        size = self.path.stat().st_size
        with (
            open(self.path, "rb") as raw,
            TextIOWrapper(raw, encoding="utf-8-sig", newline="") as file,
            self._frame(file if self._layout is None else None, usecols=names, chunksize=_CHUNK, dtype=lists) as reader,
        ):
            reached("reading")
            for chunk in reader:
                yield chunk
                reached("reading", raw.tell() if self._layout is None else self._lines.characters, size)

    def _frame(self, file: Any = None, **options: Any) -> Any:
        """The text by pandas' parser, under the names of the header. file: the same, open."""
        layout = self._layout
        if layout is not None:
            file = self._lines = TextLines(self.path, layout)
        spare = [""] if self._per_row == len(self._names) else []
        return pd.read_csv(
            self.path if file is None else file,
            sep=r"\s+" if self._delimiter == SPACE else self._delimiter,
            header=None if layout is not None and layout.header is not None else 0,
            names=[*self._names, *spare],
            decimal=layout.decimal if layout is not None else ".",
            encoding="utf-8-sig",
            skipinitialspace=True,
            low_memory=False,
            index_col=False,
            on_bad_lines="error",
            **options,
        )
