"""Model files as models, and models as files: a vehicle, effects with numbers, and where they came from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml

from infotraj.effects.registry import effect_class
from infotraj.errors import InputError, UsageError, problem
from infotraj.models.content import ModelFile, Provenance, read_content
from infotraj.models.model import Model
from infotraj.vehicle import Vehicle, load_vehicle, parse_vehicle
from infotraj.writing import whole


def load_model(path: str | Path, effects_from: Iterable[str | Path] = ()) -> Model:
    """The model of a model file, or of a vehicle file (no effects). InputError, one line, where it is not valid.

    effects_from: files or folders with the user's own effects, beside INFOTRAJ_EFFECTS and installed packages.
    """
    return read_model(path, effects_from)[0]


def read_model(path: str | Path, effects_from: Iterable[str | Path] = ()) -> tuple[Model, ModelFile]:
    """The model of a file and the file's whole content, standard errors and provenance included."""
    path = Path(path)
    file = read_content(path)
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

    InfotrajError, one line, where it cannot be written.

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
        content["provenance"] = provenance.model_dump(mode="json", exclude_defaults=True, by_alias=True)
    ModelFile.model_validate(content)
    with whole(path) as part:
        part.write_text(yaml.safe_dump(_plain(content), sort_keys=False))


def vehicle_content(vehicle: Vehicle) -> dict[str, Any]:
    """A vehicle as the content of its file, what is left out left out."""
    return _plain(vehicle.model_dump(mode="python", exclude_defaults=True))


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    return value.item() if hasattr(value, "item") else value
