"""The model file: a vehicle, effects with parameters and standard errors, and where they came from."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from infotraj.effects.registry import effect_class
from infotraj.errors import InputError, UsageError, problem
from infotraj.models.model import Model
from infotraj.vehicle import Vehicle, load_vehicle, parse_vehicle, validation_line

Values = dict[str, float | int | list[float]]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class EffectEntry(_Strict):
    """One effect of a model file."""

    name: str
    parameters: Values = {}
    standard_errors: Values = {}


class FileReference(_Strict):
    """A file that a model was made from."""

    path: str
    sha256: str = Field(pattern=r"^[0-9a-f]{64}$")


class Provenance(_Strict):
    """Where a model came from: the version that made it, its parent, the flights it was fitted to, the errors."""

    version: str = ""
    parent: FileReference | None = None
    flights: tuple[FileReference, ...] = ()
    error: dict[str, Any] = {}
    note: str = ""


class ModelFile(_Strict):
    """The content of a model file."""

    vehicle: str | dict[str, Any]
    effects: tuple[EffectEntry, ...] = ()
    provenance: Provenance = Provenance()


def load_model(path: str | Path, effects_from: Iterable[str | Path] = ()) -> Model:
    """The model of a model file, or of a vehicle file (no effects). InputError, one line, where it is not valid.

    effects_from: files or folders with the user's own effects, beside INFOTRAJ_EFFECTS and installed packages.
    """
    return read_model(path, effects_from)[0]


def read_model(path: str | Path, effects_from: Iterable[str | Path] = ()) -> tuple[Model, ModelFile]:
    """The model of a file and the file's whole content, standard errors and provenance included."""
    path = Path(path)
    try:
        content = yaml.safe_load(path.read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        what = " ".join(str(error).split())
        raise InputError(
            problem(f"{path}: cannot be read as YAML ({what})", "a model or vehicle file", "Check the path.")
        ) from error
    if not isinstance(content, dict) or "vehicle" not in content:
        vehicle = parse_vehicle(content, source=str(path))
        return Model(vehicle), ModelFile(vehicle=str(path.resolve()))
    try:
        file = ModelFile.model_validate(content)
    except ValidationError as error:
        raise InputError(f"{path}: {validation_line(error)}") from error
    if isinstance(file.vehicle, str):
        named = Path(file.vehicle)
        vehicle = load_vehicle(named if named.is_absolute() else path.parent / named)
    else:
        vehicle = parse_vehicle(file.vehicle, source=f"{path}: vehicle")
    try:
        effects = [effect_class(e.name, effects_from)(**e.parameters) for e in file.effects]
        model = Model(vehicle, effects)
    except (InputError, UsageError) as error:
        raise InputError(f"{path}: {error}") from error
    return model, file


def save_model(
    model: Model,
    path: str | Path,
    *,
    standard_errors: Iterable[Mapping[str, Any]] = (),
    provenance: Provenance | None = None,
) -> None:
    """Writes a model file, whole or not at all; the vehicle is written into it, so that it stands alone.

    standard_errors: a mapping an effect, in the model's order; none where the model was not fitted.
    """
    path = Path(path)
    errors = [dict(e) for e in standard_errors] or [{} for _ in model.effects]
    if len(errors) != len(model.effects):
        raise UsageError(
            problem(
                f"{len(errors)} standard errors", f"one mapping for each of {len(model.effects)} effects", "Pass all."
            )
        )
    entries = [
        {"name": e.name, "parameters": e.values, **({"standard_errors": s} if s else {})}
        for e, s in zip(model.effects, errors, strict=True)
    ]
    content: dict[str, Any] = {"vehicle": vehicle_content(model.vehicle), "effects": entries}
    if provenance is not None:
        content["provenance"] = provenance.model_dump(mode="json", exclude_defaults=True)
    ModelFile.model_validate(content)
    part = path.with_name(f".{path.name}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_text(yaml.safe_dump(_plain(content), sort_keys=False))
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def vehicle_content(vehicle: Vehicle) -> dict[str, Any]:
    """A vehicle as the content of its file, what is left out left out."""
    return _plain(vehicle.model_dump(mode="python", exclude_defaults=True))


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    return value.item() if hasattr(value, "item") else value
