"""What `import --fix` would set: a log is checked, mended by the settings that its findings name, and checked again."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from infotraj.checking.finding import Finding
from infotraj.checking.load import load
from infotraj.checking.standing import standing
from infotraj.checking.whole import examine
from infotraj.importing import Mapping, Settings, recognise
from infotraj.importing.fixing import Fix, fix
from infotraj.importing.settings import with_settings


def mend(
    log: Path,
    mapping: Mapping | None = None,
    settings: Settings | None = None,
    start: float | None = None,
    stop: float | None = None,
    definitions: Sequence[Path] = (),
) -> Fix:
    """The settings that leave the least to find in a log, on top of those that are given. It writes nothing.

    InputError where the log cannot be read, UsageError for a setting that its mapping does not take.
    """
    used = mapping if mapping is not None else recognise(log, tuple(definitions)).mapping
    used = used.model_copy(update={"definitions": (*map(str, definitions), *used.definitions)})
    with_settings(used, settings or {})  # a wrong --set is an error of the call, not of the log

    def judge(now: Settings) -> list[Finding]:
        loaded = load(log, used, start, stop, now)
        return standing(examine(loaded).findings, loaded.plan, loaded.flight.meta)

    return fix(judge, used, settings)
