"""How far a loop is and how long it will still take, or which step of how many something is at, and for how long it has
run: one line on a terminal, for what takes more than two seconds."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sized
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeVar

import click

T = TypeVar("T")
_QUICK = 2.0  # s: what is done by then says nothing
_EVERY = 1.0  # s
_WIDTH = 79


@dataclass(frozen=True)
class _Step:
    """At which step what is waited for says it is; alike: all take about as long; since: s, when the first began."""

    number: int
    of: int
    words: str
    alike: bool
    since: float


_step: list[_Step] = []  # one at most
_shown: list[object] = []  # lines that are under way; the last one is seen
_writing = threading.Lock()


def progress(items: Iterable[T], label: str) -> Iterator[T]:
    """The items, one after another. On standard error, where that is a terminal: `label 3 of 12, 40 s left`.

    The line is written over itself and gone at the end; there is none under `-q`, and nothing in a pipe or a file.
    Until the first item is done it says for how long it has run.
    """
    if not isinstance(items, Sized) or not _heard():
        yield from items
        return
    begun = at = time.monotonic()
    done, count = 0, len(items)

    def line() -> str:
        if not done:
            return f"{label} 1 of {count}, {_words(time.monotonic() - begun)} so far"
        return f"{label} {done + 1} of {count}, {_words(_left(begun, at, done, count))} left"

    with _telling(line, begun) as tell:
        for item in items:
            if done:
                tell()
            yield item
            done, at = done + 1, time.monotonic()


@contextmanager
def waiting(label: str) -> Iterator[None]:
    """While something runs whose length nobody can tell beforehand: `label, 12 s so far`, under the same rules.

    With what it says of itself by `step`: `label: 2 of 4, searching, 12 s so far`, or how long it will take where its
    steps are alike.
    """
    if not _heard():
        yield
        return
    _step.clear()
    begun = time.monotonic()

    def line() -> str:
        passed = f"{_words(time.monotonic() - begun)} so far"
        if not _step:
            return f"{label}, {passed}"
        at = _step[0]
        if at.alike and at.number > 1:
            passed = f"{_words(_left(begun, at.since, at.number - 1, at.of))} left"
        return f"{label}: {at.number} of {at.of}, {at.words}, {passed}"

    try:
        with _telling(line, begun):
            yield
    finally:
        _step.clear()


def step(number: int, of: int, words: str, *, alike: bool = False) -> None:
    """Says at which of its steps a long computation is, for whoever waits for it; alike: all take about as long."""
    _step[:] = [_Step(number, of, words, alike, time.monotonic())]


def interrupted() -> None:
    """Takes the line away, for something that is printed while it is under way."""
    if _shown and _heard():
        with _writing:
            _cleared()


def _left(begun: float, at: float, done: int, count: int) -> float:
    """Seconds until all are done, where `done` were at `at` and the others take as long."""
    return max((at - begun) / done * (count - done) - (time.monotonic() - at), 0.0)


@contextmanager
def _telling(line: Callable[[], str], begun: float) -> Iterator[Callable[[], None]]:
    """Writes the line each second, and when it is told to, while it is the last of those under way."""
    own, ended, written = object(), threading.Event(), False

    def tell() -> None:
        nonlocal written
        with _writing:
            if not ended.is_set() and _shown[-1:] == [own] and time.monotonic() - begun > _QUICK:
                _over(line())
                written = True

    def each_second() -> None:
        while not ended.wait(_EVERY):
            tell()

    _shown.append(own)
    thread = threading.Thread(target=each_second, name="_so_far", daemon=True)
    thread.start()
    try:
        yield tell
    finally:
        ended.set()
        thread.join()
        _shown.remove(own)
        if written:
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
