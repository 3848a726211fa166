"""What every kind of log offers to the importer: topics with fields, and their samples read once, in one pass."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from infotraj.errors import InfotrajError, InputError, problem
from infotraj.rotations import Array
from infotraj.suggested import quoted


@dataclass(frozen=True)
class Topic:
    """One topic of a log: `name`, message type, instance (ULog), and how many messages it has (None: not counted)."""

    name: str
    type: str = ""
    instance: int = 0
    messages: int | None = None


@dataclass(frozen=True)
class Request:
    """Fields of one topic. `numbers` may hold one `*`, which counts 0, 1, 2, .. as far as the messages go."""

    topic: Topic
    numbers: tuple[str, ...]
    times: tuple[str, ...] = ()


@dataclass
class Samples:
    """What a request gave: n samples. Times are int64 ns where the log has whole ones, else float seconds."""

    record: Any = None  # (n,) when the logger wrote the message, ns; None where the log does not say
    times: dict[str, Any] = field(default_factory=dict)  # field: (n,), raw numbers; ROS stamps in ns
    numbers: dict[str, Array] = field(default_factory=dict)  # field: (n,), or (n, count) for a `*`


class Log(Protocol):
    """An open log. `close` is called once; reading never loads more than the requested fields."""

    kind: str
    path: Path
    topics: list[Topic]
    notes: list[str]

    def has(self, topic: Topic, name: str) -> bool:
        """True where `topic` has the field `name` (a `*` stands for 0)."""
        ...

    def first(self, topic: Topic, name: str) -> Any:
        """The field's value in the first message; None where there is none."""
        ...

    def read(self, requests: list[Request]) -> list[Samples]:
        """The samples of every request, in the order of the log."""
        ...

    def close(self) -> None:
        """Releases the file."""
        ...


def what_is_left(path: Path) -> str:
    """What to do with a log that was cut or damaged, as a command that works."""
    command = f"infotraj import {quoted(path)} --allow-damaged -o NEW.parquet"
    return f"Copy it again, or take what is left of it: {command}"


@contextmanager
def reading(path: Path, expected: str, remedy: str) -> Iterator[None]:
    """Turns whatever a third-party reader raises on a damaged file into one InputError line."""
    try:
        yield
    except InfotrajError:
        raise
    # Damaged bytes make the readers raise anything: AssertionError, struct.error, KeyError, MemoryError, sqlite's own.
    except Exception as error:
        text = " ".join(str(error).split())[:160]
        what = text if text and not isinstance(error, KeyError) else f"{type(error).__name__} {text}".strip()
        raise InputError(problem(f"{path}: cannot be read ({what})", expected, remedy)) from error
