"""A model of a vehicle: what its file declares, and any set of effects on top, predicted along recorded flights."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from infotraj.models.file import load_model, save_model
    from infotraj.models.model import Model
    from infotraj.models.prediction import Prediction

__all__ = ["Model", "Prediction", "load_model", "save_model"]
_HOME = {"Model": "model", "Prediction": "prediction", "load_model": "file", "save_model": "file"}


def __getattr__(name: str) -> Any:
    # Late: reading what a model file holds takes none of what evaluates a model.
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
