"""The content of a page that was written as JSON, read again: nothing that computes is imported."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from infotraj.errors import InputError, problem

FORM = 4  # of the content; a page is drawn only from the form that this version writes


def read_content(path: Path) -> dict[str, Any]:
    """The content that `infotraj report --json` wrote. InputError for anything else."""
    expected = f"what `infotraj report --json` of this version writes (form {FORM})"
    try:
        content = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise InputError(problem(f"{path}: {error}", expected, "Write it again.")) from error
    form = content.get("form", "none") if isinstance(content, dict) else "none"
    if form != FORM:
        raise InputError(problem(f"{path}: form {form}", expected, "Write it again with `infotraj report --json`."))
    return content
