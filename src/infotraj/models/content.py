"""What a model file holds, read without anything that evaluates a model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from infotraj.errors import InputError, problem, unread
from infotraj.vehicle import parse_vehicle, validation_line

Values = dict[str, float | int | list[float]]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class EffectEntry(_Strict):
    """One effect of a model file."""

    name: str
    parameters: Values = {}
    standard_errors: Values = {}


class FileReference(_Strict):
    """A file that a model was made from; start, stop: s, the part of a flight that was fitted, None for no limit.

    In files these two are `from` and `to`.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)

    path: str
    sha256: str = Field(pattern=r"^[0-9a-f]{64}$")
    start: float | None = Field(default=None, alias="from")
    stop: float | None = Field(default=None, alias="to")


class AcceptedFinding(_Strict):
    """A finding about a flight, or a refusal of the diagnosis, that the user overruled."""

    code: str
    what: str
    path: str = ""
    severity: str = ""
    axes: tuple[str, ...] = ()


class Provenance(_Strict):
    """Where a model came from.

    The version that made it, its parent, the flights it was fitted to, the errors, the findings that the user
    overruled, and the effects whose numbers stopped at a physical bound, with the reason.
    """

    version: str = ""
    parent: FileReference | None = None
    flights: tuple[FileReference, ...] = ()
    error: dict[str, Any] = {}
    note: str = ""
    accepted: tuple[AcceptedFinding, ...] = ()
    at_bound: dict[str, str] = {}


class ModelFile(_Strict):
    """The content of a model file."""

    vehicle: str | dict[str, Any]
    effects: tuple[EffectEntry, ...] = ()
    provenance: Provenance = Provenance()


def read_content(path: str | Path) -> ModelFile:
    """The content of a model file; of a vehicle file: that vehicle and no effects. InputError, one line."""
    path = Path(path)
    try:
        content = yaml.safe_load(path.read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(unread(path, error, "a model or vehicle file")) from error
    if not isinstance(content, dict) or "vehicle" not in content:
        parse_vehicle(content, source=str(path))
        return ModelFile(vehicle=str(path.resolve()))
    try:
        file = ModelFile.model_validate(content)
    except ValidationError as error:
        raise InputError(f"{path}: {validation_line(error, ModelFile)}") from error
    for name, key, value in ((e.name, k, v) for e in file.effects for k, v in e.parameters.items()):
        if not np.isfinite(value).all():
            raise InputError(problem(f"{path}: {name}: {key} is {value}", "finite numbers", "Correct the value."))
    return file
