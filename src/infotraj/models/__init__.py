"""A model of a vehicle: what its file declares, and any set of effects on top, predicted along recorded flights."""

from infotraj.models.file import load_model, save_model
from infotraj.models.model import Model
from infotraj.models.prediction import Prediction

__all__ = ["Model", "Prediction", "load_model", "save_model"]
