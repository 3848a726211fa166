"""The catalogue of physical effects: what a first-principles model may lack, one small class each."""

from infotraj.effects.base import Effect, Parameter
from infotraj.effects.registry import catalogue, effect_class

__all__ = ["Effect", "Parameter", "catalogue", "effect_class"]
