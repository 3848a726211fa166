"""How far a loop is and how long it will still take, or which step of how many something is at, and for how long it has
run: one line on a terminal, for what takes more than two seconds."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sized
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeVar

import click

from infotraj.remaining import Plan

T = TypeVar("T")
_QUICK = 2.0  # s: what is done by then says nothing
_EVERY = 1.0  # s
_FEW = 4.0  # s
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
_plan: list[Plan] = []  # one at most
_within: list[str] = []  # what stands before the names of parts, one at most
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
    steps are alike. With what it says by `parts` and `reached`: `label: 2 of 4, searching, about 40 s left`.
    """
    if not _heard():
        yield
        return
    _step.clear()
    _plan.clear()
    begun = time.monotonic()

    def line() -> str:
        passed = f"{_words(time.monotonic() - begun)} so far"
        left = _plan[0].left(time.monotonic()) if _plan else None
        if left is not None:
            passed = _about(left)
        if not _step:
            return _cut(label, passed)
        at = _step[0]
        if at.alike and at.number > 1:
            passed = f"{_words(_left(begun, at.since, at.number - 1, at.of))} left"
        return _cut(f"{label}: {at.number} of {at.of}, {at.words}", passed)

    try:
        with _telling(line, begun):
            yield
    finally:
        _step.clear()
        _plan.clear()


def step(number: int, of: int, words: str, *, alike: bool = False) -> None:
    """Says at which of its steps a long computation is, for whoever waits for it; alike: all take about as long."""
    _step[:] = [_Step(number, of, words, alike, time.monotonic())]


def parts(lengths: Mapping[str, float]) -> None:
    """Says of which parts a long computation is made, and about how long they are, in any unit.

    It begins with the first word about one of them: what is before has no known share.
    """
    _plan[:] = [Plan(lengths)]


@contextmanager
def within(name: str) -> Iterator[None]:
    """Parts that are told of meanwhile have this before their names: the same work for two purposes is two parts."""
    _within[:] = [name]
    try:
        yield
    finally:
        _within.clear()


def pieces(part: str, count: int) -> None:
    """Says, before it begins, that a part will be done so many times over."""
    if _plan:
        _plan[0].pieces("".join([*_within, part]), count)


def reached(part: str, done: int = 0, of: int = 1) -> None:
    """Says that so many pieces of a part are done, which take about as long each.

    Whoever does the work says so, whether anybody has named its parts or not; only a part that is named counts.
    """
    if _plan:
        _plan[0].reached("".join([*_within, part]), done, of, time.monotonic())


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


def _cut(what: str, passed: str) -> str:
    """Both in one line: the time is never cut off."""
    return f"{what[: _WIDTH - 2 - len(passed)]}, {passed}"


def _about(seconds: float) -> str:
    """An estimate of what is left, no more exact than it is."""
    if seconds < _FEW:
        return "a few seconds left"
    if seconds >= 100:
        return f"about {seconds / 60:.0f} min left"
    every = 5 if seconds < 32.5 else 10
    return f"about {every * round(seconds / every)} s left"


def _words(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"
