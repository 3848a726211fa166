"""Model files as models, and models as files: a vehicle, effects with numbers, and where they came from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from infotraj.arguments import AnyPath, as_path
from infotraj.effects.base import Effect, Parameter
from infotraj.effects.registry import effect_class
from infotraj.errors import InputError, UsageError, problem
from infotraj.models.behind import files_behind
from infotraj.models.content import EffectEntry, ModelFile, Provenance, read_content
from infotraj.models.model import Model
from infotraj.outputs import require_outputs
from infotraj.vehicle import Vehicle, load_vehicle, parse_vehicle
from infotraj.writing import whole

_ROUNDED = 1e-6  # of a bound: a number that a fit left at it may be rounded


def load_model(path: AnyPath, effects_from: AnyPath | Iterable[AnyPath] = ()) -> Model:
    """The model of a model file, or of a vehicle file (no effects). InputError, one line, where it is not valid.

    effects_from: files or folders with the user's own effects, beside INFOTRAJ_EFFECTS and installed packages.
    """
    return read_model(path, effects_from)[0]


def read_model(path: AnyPath, effects_from: AnyPath | Iterable[AnyPath] = ()) -> tuple[Model, ModelFile]:
    """The model of a file and the file's whole content, standard errors and provenance included."""
    path = as_path("a model", path)
    file = read_content(path)
    if isinstance(file.vehicle, str):
        named = Path(file.vehicle)
        vehicle = load_vehicle(named if named.is_absolute() else path.parent / named)
    else:
        vehicle = parse_vehicle(file.vehicle, source=f"{path}: vehicle")
    vehicles, ancestors = files_behind(path)
    vehicle = vehicle.read_from(path, *vehicles, *ancestors)
    try:
        effects = [_effect(e, vehicle, effects_from) for e in file.effects]
        model = Model(vehicle, effects)
    except (InputError, UsageError) as error:
        raise InputError(f"{path}: {error}") from error
    return model, file


def _effect(entry: EffectEntry, vehicle: Vehicle, effects_from: AnyPath | Iterable[AnyPath]) -> Effect:
    """The effect of an entry. InputError where a parameter is left out, or is beyond its physical bounds."""
    cls = effect_class(entry.name, effects_from)
    effect = cls(**entry.parameters)
    needed = [p.name for p in cls.parameters if not p.optional]
    lacking = next((name for name in needed if name not in entry.parameters), None)
    forms = [p.name for p in cls.parameters if p.optional]
    if lacking is None and forms and not set(forms) & set(entry.parameters):
        lacking = " or ".join(forms)
    if lacking is not None:
        raise InputError(
            problem(f"{entry.name} has no {lacking}", "a number for it", "Write it, or leave the effect out.")
        )
    for p in cls.parameters:
        value = np.asarray(getattr(effect, p.name), dtype=float)
        low, high = _widest(cls, vehicle, p)
        if np.any(value < low - _ROUNDED * abs(low)) or np.any(value > high + _ROUNDED * abs(high)):
            what = f"{entry.name}: {p.name} is {entry.parameters[p.name]}"
            raise InputError(problem(what, f"{low:.4g} to {high:.4g}, its physical bounds", "Correct the value."))
    return effect


def _widest(cls: type[Effect], vehicle: Vehicle, p: Parameter) -> tuple[float, float]:
    """The bounds of a parameter on any vehicle, or on this one where they are wider."""
    try:
        low, high = cls.bounds(vehicle, p)
    except InputError:  # the file leaves out what they are made of
        return p.bounds
    return min(p.bounds[0], float(np.min(low))), max(p.bounds[1], float(np.max(high)))


def save_model(
    model: Model,
    path: AnyPath,
    *,
    standard_errors: Iterable[Mapping[str, Any]] = (),
    provenance: Provenance | None = None,
) -> None:
    """Writes a model file, whole or not at all; the vehicle is written into it, so that it stands alone.

    Folders are made. InfotrajError, one line, where it cannot be written, or where the model was read from this file.

    standard_errors: a mapping an effect, in the model's order; none where the model was not fitted.
    """
    path = as_path("the model's new file", path)
    if not isinstance(model, Model):
        found = f"a model of type {type(model).__name__}"
        raise UsageError(problem(found, "a Model", "`infotraj.diagnose(...).model` is one."))
    require_outputs({"the model's new file": path}, {}, {"a file that the model was read from": model.vehicle.files})
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
