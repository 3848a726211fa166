"""Results as a person reads them: long lines go on below, at a word, on a terminal; elsewhere they stay whole."""

from __future__ import annotations

import shutil
import sys
import textwrap

import click

_LEAST = 40  # columns: what is narrower is left to the terminal


def show(text: str) -> None:
    """Prints a result; folded where standard output is a terminal."""
    folding = sys.stdout.isatty()
    click.echo(folded(text, shutil.get_terminal_size().columns) if folding else text, nl=not text.endswith("\n"))


def counted(count: int, what: str) -> str:
    """`1 flight`, `2 flights`."""
    return f"{count} {what}" + ("s" if count != 1 else "")


def folded(text: str, width: int) -> str:
    """The text with lines of at most `width` columns, continued four columns in from where each begins.

    Columns that stand apart keep their distances; a word that is longer than a line stays whole.
    """
    if width < _LEAST:
        return text
    return "\n".join(_folded(line, width) for line in text.split("\n"))


def _folded(line: str, width: int) -> str:
    if len(line) <= width:
        return line
    begun = line[: len(line) - len(line.lstrip())]
    below = begun + "    "
    return textwrap.fill(
        line.rstrip(), width, subsequent_indent=below, expand_tabs=False, replace_whitespace=False,
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip
