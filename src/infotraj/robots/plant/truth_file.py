"""Writes a truth file."""

from __future__ import annotations

from pathlib import Path

import yaml

from infotraj.robots.plant.truth import Truth


def write_truth(truth: Truth, path: str | Path) -> None:
    """The truth as YAML, to be read by `load_truth`."""
    Path(path).write_text(yaml.safe_dump(truth.model_dump(mode="json"), sort_keys=False))
