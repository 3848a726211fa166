"""Files that stand beside an imported table, written whole or not at all: mappings, and reports for programs."""

from __future__ import annotations

import os
from pathlib import Path

import yaml

from infotraj import __version__
from infotraj.importing.mapping import Mapping
from infotraj.importing.mapping_files import load_mapping, shipped
from infotraj.importing.settings import Settings, with_settings
from infotraj.writing import whole


def save_mapping(used: Mapping | str, settings: Settings, path: Path) -> None:
    """The mapping that was used, whole, to be edited."""
    mapping = with_settings(load_mapping(used) if isinstance(used, str) else used, settings)
    _write_yaml(path, mapping.model_dump(mode="json", exclude_defaults=True))


def save_extension(base: str, settings: Settings, path: Path) -> None:
    """A mapping that takes over `base` (a shipped name or a path) with these settings on top."""
    name = base if base in shipped() else os.path.relpath(base, path.parent)
    _write_yaml(path, {"extends": name, "set": settings})


def write_text(path: Path, text: str) -> None:
    """A text file with an end to its last line. InfotrajError, one line, where it cannot be written."""
    with whole(path) as part:
        part.write_text(text + ("" if text.endswith("\n") else "\n"))


def _write_yaml(path: Path, content: object) -> None:
    text = yaml.safe_dump(content, sort_keys=False, width=110)
    write_text(path, f"# Written by infotraj {__version__}.\n{text}")
