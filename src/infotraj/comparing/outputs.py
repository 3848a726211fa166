"""The outputs of a command that reads a model and flights, tried before it reads them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from infotraj.effects.registry import effect_files
from infotraj.flight import flight_files
from infotraj.models.behind import files_behind
from infotraj.outputs import Named, require_outputs


def try_outputs(
    files: Named,
    folders: Named,
    *,
    models: Sequence[Path] = (),
    flights: Sequence[Path] = (),
    reference: Sequence[Path] = (),
    effects_from: Sequence[Path] = (),
    contents: Sequence[Path] = (),
) -> None:
    """UsageError, InfotrajError: an output that is read as well, that is named twice, or that cannot be written.

    files, folders: by their options, None where one is not given; contents: what other commands wrote. The files behind
    a model count as read.
    """
    if not any((*files.values(), *folders.values())):
        return
    behind = [files_behind(m) for m in models]
    inputs = {
        "the model itself": models,
        "a flight that is read": _tables(flights),
        "a healthy flight that is read": _tables(reference),
        "a file with effects that are read": effect_files(effects_from),
        "a file that is read": contents,
        "a model that the model was made from": [p for _, ancestors in behind for p in ancestors],
        "the vehicle file of the model": [p for vehicles, _ in behind for p in vehicles],
    }
    require_outputs(files, folders, inputs)


def _tables(flights: Sequence[Path]) -> list[Path]:
    return [p for flight in flights for p in flight_files(flight)]
