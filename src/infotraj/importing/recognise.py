"""Which shipped mapping fits a log: all that it requires is there, and it fills more channels than any other."""

from __future__ import annotations

import re
from pathlib import Path

from infotraj.errors import InputError, problem
from infotraj.importing.log import Log
from infotraj.importing.mapping import Mapping
from infotraj.importing.streams import Plan, plan


def fits(log: Log, mapping: Mapping) -> bool:
    """True where the log has every topic, type and field that the mapping requires."""
    filled = [t for t in log.topics if t.messages != 0]
    names, types = {t.name for t in filled}, {t.type for t in filled}
    for group, have in ((mapping.requires.topics, names), (mapping.requires.types, types)):
        if not all(any(re.fullmatch(entry, h) for h in have) for entry in group):
            return False
    return all(
        any(log.has(t, choice) for choice in entry.split("|") for t in filled) for entry in mapping.requires.fields
    )


def choose(log: Log, candidates: list[Mapping]) -> Plan:
    """The plan of the mapping that fills the most channels; of equals the one that requires more, then by name.

    InputError, naming what the log has, where none fits.
    """
    plans = [plan(log, mapping) for mapping in candidates if log.kind in mapping.reads and fits(log, mapping)]
    plans = [p for p in plans if p.channels]
    if not plans:
        topics = [*log.topics, *getattr(log, "others", ())]
        has = ", ".join(f"{t.name} ({t.type})" if t.type not in ("", t.name) else t.name for t in topics)
        columns = getattr(log, "columns", None)
        has = ", ".join(columns) if columns is not None else has
        hint = f" ({log.notes[0]})" if log.notes else ""
        raise InputError(
            problem(
                f"{log.path}: no known layout{hint}; it has {(has or 'no topics')[:300]}",
                f"one of {', '.join(m.name for m in candidates)}",
                "Write a mapping (docs/import.md) and give it with --mapping.",
            )
        )

    def merit(found: Plan) -> tuple[int, int, str]:
        needs = found.mapping.requires
        return -len(found.channels), -len((*needs.topics, *needs.types, *needs.fields)), found.mapping.name

    return min(plans, key=merit)


def recognise(path: str | Path, definitions: tuple[Path, ...] = (), allow_damaged: bool = False) -> Plan:
    """The shipped mapping that fits the log at `path`, with the topics that feed each channel."""
    from infotraj.importing.reading import opened

    with opened(Path(path), None, definitions, allow_damaged) as (_, chosen):
        return chosen
