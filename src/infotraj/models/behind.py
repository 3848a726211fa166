"""The files behind a model file: its vehicle's, and the models that it was made from."""

from __future__ import annotations

from pathlib import Path

from infotraj.errors import InputError
from infotraj.models.content import ModelFile, read_content


def files_behind(model: Path) -> tuple[list[Path], list[Path]]:
    """The vehicle files that a model and its ancestors name, and the ancestors, the nearest first.

    As far as the files can be read; an ancestor that is missing ends the chain and is in it.
    """
    vehicles: list[Path] = []
    ancestors: list[Path] = []
    path, seen = model, {model.resolve()}
    while True:
        content = _content(path)
        if content is None:
            return vehicles, ancestors
        if isinstance(content.vehicle, str):
            vehicles.append(path.parent / content.vehicle)
        parent = content.provenance.parent
        if parent is None or Path(parent.path).resolve() in seen:
            return vehicles, ancestors
        path = Path(parent.path)
        seen.add(path.resolve())
        ancestors.append(path)


def _content(path: Path) -> ModelFile | None:
    try:
        return read_content(path)
    except InputError:
        return None
