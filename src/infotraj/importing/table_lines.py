"""The first lines of a text table with a layout of its own: which names stand on top, and what separates the cells."""

from __future__ import annotations

import csv
from pathlib import Path

from infotraj.importing.table_format import SPACE, TableFormat, TextLines


def laid_out_header(path: Path, layout: TableFormat) -> tuple[str, tuple[str, ...]]:
    """The same for a text with a layout of its own."""
    lines = TextLines(path, layout)
    line = next(iter(lines), "")
    lines.close()
    if "\0" in line or not line.strip():
        raise ValueError("no line of the layout that the mapping declares")
    found = max((",", ";", "\t", "|"), key=line.count)
    delimiter = layout.separator or (found if found in line else SPACE)
    if layout.header is not None:
        return delimiter, layout.header
    if delimiter == SPACE:
        return delimiter, tuple(line.split())
    names = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    return delimiter, tuple(n.strip() for n in names)


def is_spaced(path: Path) -> bool:
    """True where names and first row stand in columns of blanks, as many in one as in the other."""
    with open(path, encoding="utf-8-sig") as file:
        names, first = file.readline(1 << 20), file.readline(1 << 20)
    marked = any(mark in names for mark in ',;\t"#')
    return not marked and len(names.split()) > 1 and len(names.split()) == len(first.split())
