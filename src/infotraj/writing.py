"""Files that are written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from secrets import token_hex

from infotraj.errors import InfotrajError, problem


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """The place where to write: it becomes `path` at the end, and is gone where that fails.

    Folders are made. Of several that write one file at once each has its own place. InfotrajError, one line, where the
    file cannot be written.
    """
    part = path.with_name(f".{path.name}.{token_hex(4)}.part") if path.name else path
    try:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            yield part
            os.replace(part, path)
        finally:
            with suppress(OSError):
                part.unlink(missing_ok=True)
    except OSError as error:
        what = f"{path}: {error.strerror or error}"
        raise InfotrajError(problem(what, "a place that can be written", "Choose another.")) from error


def write_text(text: str, path: str | Path) -> None:
    """Writes text, whole or not at all."""
    with whole(Path(path)) as part:
        part.write_text(text)
