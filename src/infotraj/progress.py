"""How far a loop is and how long it will still take, or which step of how many something is at, and for how long it has
run: one line on a terminal, for what takes more than two seconds."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterable, Iterator, Sized
from contextlib import contextmanager
from typing import TypeVar

import click

T = TypeVar("T")
_QUICK = 2.0  # s: what is done by then says nothing
_EVERY = 1.0  # s
_WIDTH = 79
_step: list[str] = []  # at which step what is waited for says it is


def progress(items: Iterable[T], label: str) -> Iterator[T]:
    """The items, one after another. On standard error, where that is a terminal: `label 3 of 12, 40 s left`.

    The line is written over itself and gone at the end; there is none under `-q`, and nothing in a pipe or a file.
    """
    if not isinstance(items, Sized) or not _heard():
        yield from items
        return
    begun, shown = time.monotonic(), False
    try:
        for done, item in enumerate(items):
            passed = time.monotonic() - begun
            if done and passed > _QUICK:
                left = passed / done * (len(items) - done)
                _over(f"{label} {done + 1} of {len(items)}, {_words(left)} left")
                shown = True
            yield item
    finally:
        if shown:
            _cleared()


@contextmanager
def waiting(label: str) -> Iterator[None]:
    """While something runs whose length nobody can tell beforehand: `label, 12 s so far`, under the same rules.

    With what it says of itself by `step`: `label: 2 of 4, searching, 12 s so far`.
    """
    if not _heard():
        yield
        return
    _step.clear()
    begun, ended = time.monotonic(), threading.Event()
    thread = threading.Thread(target=_so_far, args=(label, begun, ended), daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        _step.clear()


def step(number: int, of: int, words: str) -> None:
    """Says at which of its steps a long computation is, for whoever waits for it."""
    _step[:] = [f"{number} of {of}, {words}"]


def _so_far(label: str, begun: float, ended: threading.Event) -> None:
    shown = False
    while not ended.wait(_EVERY):
        passed = time.monotonic() - begun
        if passed > _QUICK:
            _over(f"{': '.join([label, *_step])}, {_words(passed)} so far")
            shown = True
    if shown:
        _cleared()


def _heard() -> bool:
    context = click.get_current_context(silent=True)
    quiet = context is not None and context.params.get("quiet")
    return not quiet and sys.stderr.isatty()


def _cleared() -> None:
    _over("")
    sys.stderr.write("\r")
    sys.stderr.flush()


def _over(line: str) -> None:
    sys.stderr.write(f"\r{line[:_WIDTH]:<{_WIDTH}}")
    sys.stderr.flush()


def _words(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"
