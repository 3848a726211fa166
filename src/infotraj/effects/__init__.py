"""The catalogue of physical effects: what a first-principles model may lack, one small class each."""

from infotraj.effects.base import Declared, Effect, Parameter, labels_in_words
from infotraj.effects.registry import catalogue, effect_class

__all__ = ["Declared", "Effect", "Parameter", "catalogue", "effect_class", "labels_in_words"]
