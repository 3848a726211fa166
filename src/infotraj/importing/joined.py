"""Several tables of one flight as one log: a controller's file and the motion capture's, on one clock."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from infotraj.errors import InputError, UsageError, problem
from infotraj.importing.log import Request, Samples, Topic
from infotraj.importing.table import TableFile


class JoinedTables:
    """Tables whose times count from one zero; each is a topic under its file's name."""

    kind = "table"

    def __init__(self, tables: Sequence[TableFile]) -> None:
        self.path: Path = tables[0].path
        self.notes = [f"{t.path.name}: {note}" for t in tables for note in t.notes]
        self.topics = [topic for table in tables for topic in table.topics]
        self.columns = tuple(dict.fromkeys(c for table in tables for c in table.columns))
        self._tables = {topic.name: table for table in tables for topic in table.topics}
        if len(self._tables) < len(tables):
            raise UsageError(
                problem(f"--with: two files are called {self.path.name}", "files of different names", "Rename one.")
            )

    def close(self) -> None:
        """Nothing is held open."""

    def has(self, topic: Topic, name: str) -> bool:
        """True where the table has the column."""
        return self._tables[topic.name].has(topic, name)

    def fields(self, topic: Topic) -> list[str]:
        """All columns of one table."""
        return self._tables[topic.name].fields(topic)

    def first(self, topic: Topic, name: str) -> Any:
        """The column's value in the table's first row."""
        return self._tables[topic.name].first(topic, name)

    def read(self, requests: list[Request]) -> list[Samples]:
        """The asked columns, one pass a table."""
        found: dict[int, Samples] = {}
        for name, table in self._tables.items():
            own = [k for k, request in enumerate(requests) if request.topic.name == name]
            found.update(zip(own, table.read([requests[k] for k in own]) if own else [], strict=True))
        return [found[k] for k in range(len(requests))]


def require_overlap(path: Path, spans: dict[str, tuple[float, float]]) -> None:
    """InputError where two of the tables have no time in common: their clocks count from different zeros."""
    starts, stops = max(a for a, _ in spans.values()), min(b for _, b in spans.values())
    if starts >= stops:
        said = "; ".join(f"{name} {a:.3f} to {b:.3f} s" for name, (a, b) in spans.items())
        raise InputError(
            problem(
                f"{path}: its times and those of --with have nothing in common ({said})",
                "one clock",
                "Give one of the streams a `shift` in a mapping.",
            )
        )
