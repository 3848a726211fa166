"""Writes the model that a diagnosis or an addition made, with where it came from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from infotraj.comparing.statistics import Statistics
from infotraj.comparing.summary import errors_by_axis
from infotraj.diagnosis.adding import Added
from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.flight import PART, Flight, sha256
from infotraj.models import Model, save_model
from infotraj.models.content import AcceptedFinding, FileReference, ModelFile, Provenance


def save_diagnosed(
    found: Diagnosis,
    path: Path,
    *,
    parent: Path,
    content: ModelFile,
    flights: Sequence[Flight],
    start: float | None = None,
    stop: float | None = None,
) -> None:
    """The model with the supported effects; the model as it was where there are none.

    start, stop: s, the part of each flight that was fitted.
    """
    note = f"diagnose: {', '.join(found.supported)}" if found.supported else "diagnose: no effect supported"
    note += _corrected(found.beside) + _read(found.command_steps, found.by_velocity)
    errors = found.errors_of or [e.standard_errors for e in content.effects]
    said = (found.accepted, found.at_bound)
    used = _references(flights, start, stop)
    _save(found.model, path, parent, used, errors, found.before, found.after, note, *said)


def save_added(
    made: Added,
    path: Path,
    *,
    parent: Path,
    flights: Sequence[Flight],
    start: float | None = None,
    stop: float | None = None,
) -> None:
    """The model with the effects that were asked for. start, stop: as in `save_diagnosed`."""
    note = f"add: {', '.join(made.names)}{_corrected(made.beside)}{_read(made.command_steps, bool(made.notes))}"
    said = (made.accepted, made.ended)
    used = _references(flights, start, stop)
    _save(made.model, path, parent, used, made.errors, made.before, made.after, note, *said)


def _corrected(beside: Sequence[str]) -> str:
    names = dict.fromkeys(x.split()[0] for x in beside)
    return f"; the file corrected by {', '.join(names)}" if beside else ""


def _read(steps: int, by_velocity: bool) -> str:
    return (f"; --command-steps {steps}" if steps > 1 else "") + ("; forces from the velocity" if by_velocity else "")


def _references(flights: Sequence[Flight], start: float | None, stop: float | None) -> tuple[FileReference, ...]:
    """The files of the flights, with the part of each that was fitted."""
    found = []
    for flight in flights:
        path = Path(str(flight.meta.get("source", "")))
        first, last = flight.meta.get(PART, (start, stop))
        if path.is_file():
            found.append(FileReference(path=str(path.resolve()), sha256=sha256(path), start=first, stop=last))
    return tuple(found)


def _save(
    model: Model,
    path: Path,
    parent: Path,
    flights: tuple[FileReference, ...],
    errors: Sequence[Mapping[str, Any]],
    before: Statistics,
    after: Statistics,
    note: str,
    accepted: Sequence[Mapping[str, Any]],
    at_bound: Mapping[str, str],
) -> None:
    provenance = Provenance(
        version=f"infotraj {version('infotraj')}",
        parent=FileReference(path=str(parent.resolve()), sha256=sha256(parent)),
        flights=flights,
        error=errors_by_axis(before, after),
        note=note,
        accepted=tuple(AcceptedFinding.model_validate(dict(entry)) for entry in accepted),
        at_bound=dict(at_bound),
    )
    save_model(model, path, standard_errors=errors, provenance=provenance)
