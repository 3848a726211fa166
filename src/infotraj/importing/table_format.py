"""How a text table is laid out that is no plain CSV: a logger's prefixes, comments, separators, the columns' names."""

from __future__ import annotations

import re
from collections.abc import Generator, Iterator
from pathlib import Path

from pydantic import Field, model_validator

from infotraj.importing.channel_map import Names, Strict

SPACE = "space"
_SEPARATORS = (",", ";", "\t", "|", SPACE)


class TableFormat(Strict):
    """The layout of a text file; what is left out is found as in a CSV."""

    line_prefix: str | None = Field(
        None, description="regular expression at the start of every line, taken off; lines without it are left out"
    )
    comment: str | None = Field(None, min_length=1, description="lines that start so are left out")
    skip: int = Field(0, ge=0, description="lines before the names")
    separator: str | None = Field(None, description="`,` `;` tab `|` or `space` (any run); default: found by looking")
    decimal: str = Field(".", description="`.` or `,`")
    header: Names | None = Field(None, description="the columns' names, where the file does not hold them")

    @model_validator(mode="after")
    def _known(self) -> TableFormat:
        if self.line_prefix is not None:
            require_pattern(self.line_prefix)
        if self.separator is not None and self.separator not in _SEPARATORS:
            raise ValueError(f"separator {self.separator!r} is none of , ; tab | {SPACE}")
        if self.decimal not in (".", ",") or self.decimal == self.separator:
            raise ValueError(f"decimal {self.decimal!r} is none of . and , or is the separator")
        return self

    def recognises(self, path: Path) -> bool:
        """True where the file's first line has the prefix; a layout without one cannot be told by looking."""
        if self.line_prefix is None:
            return False
        with open(path, encoding="utf-8-sig", errors="replace") as file:
            return re.match(self.line_prefix, file.readline(1 << 16)) is not None


def require_pattern(pattern: str) -> None:
    """ValueError unless `pattern` is a regular expression."""
    try:
        re.compile(pattern)
    except (re.error, RecursionError, OverflowError) as error:
        raise ValueError(f"{pattern!r} is no regular expression ({error})") from error


class TextLines:
    """The lines of a text file as a CSV would have them: prefix, comments and skipped lines taken off.

    `left_out` counts lines without the prefix, after all have been read, `characters` what has been read of the file
    so far. It reads as a file does, so that a parser takes it for one, and holds no more than a block.
    """

    def __init__(self, path: Path, layout: TableFormat) -> None:
        self._path, self._layout = path, layout
        self.left_out = self.characters = 0
        self._lines = self._cleaned()

    def __iter__(self) -> Iterator[str]:
        return self._lines

    def read(self, size: int = -1) -> str:
        """The next `size` characters or a little more; all that is left where `size` is negative."""
        parts: list[str] = []
        length = 0
        for line in self._lines:
            parts.append(line)
            length += len(line)
            if 0 <= size <= length:
                break
        return "".join(parts)

    def close(self) -> None:
        """Lets the file go."""
        self._lines.close()

    def _cleaned(self) -> Generator[str]:
        layout = self._layout
        prefix = re.compile(layout.line_prefix) if layout.line_prefix is not None else None
        skipped = 0
        with open(self._path, encoding="utf-8-sig") as file:
            for line in file:
                self.characters += len(line)
                if skipped < layout.skip:
                    skipped += 1
                    continue
                if layout.comment is not None and line.startswith(layout.comment):
                    continue
                if prefix is not None:
                    found = prefix.match(line)
                    if found is None:
                        self.left_out += bool(line.strip())
                        continue
                    line = line[found.end() :]
                if line.strip():
                    yield line.strip() + "\n" if layout.separator == SPACE else line
