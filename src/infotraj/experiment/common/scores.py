"""Scores of runs as lines of JSON, one a run: what is there need not be made again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

Score = dict[str, Any]


def read_scores(scores: Path) -> list[Score]:
    """The scores that are there."""
    return [json.loads(line) for line in scores.read_text().splitlines()] if scores.is_file() else []


def add_score(score: Score, scores: Path) -> None:
    """Appends one line."""
    line = json.dumps(score, default=_plain)
    scores.parent.mkdir(parents=True, exist_ok=True)
    with scores.open("a") as file:
        file.write(line + "\n")


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else np.asarray(value).tolist()
