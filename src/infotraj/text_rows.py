"""Rows of a text table that are cut or uneven: counted in bytes, for a parser fills up a short row without a word."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np


def header(path: Path) -> tuple[str, tuple[str, ...]]:
    """(delimiter, names) of a CSV by its first line."""
    with open(path, encoding="utf-8-sig", newline="") as file:
        line = file.readline(1 << 20)
    if "\0" in line or not line.strip():
        raise ValueError("no header line")
    delimiter = max(",;\t", key=line.count)
    names = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    return delimiter, tuple(n.strip().removeprefix("#").strip() for n in names)


def row_delimiters(path: Path, delimiter: str, columns: int) -> int:
    """How many delimiters a row has: one less than columns, or as many where every row ends with one."""
    with open(path, encoding="utf-8-sig", newline="") as file:
        file.readline(1 << 20)
        first = file.readline(1 << 20).rstrip("\r\n")
    ends_with_one = first.count(delimiter) == columns and first.endswith(delimiter)
    return columns if ends_with_one else columns - 1


def uneven_row(path: Path, delimiter: str, expected: int) -> tuple[int, int, bool] | None:
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
