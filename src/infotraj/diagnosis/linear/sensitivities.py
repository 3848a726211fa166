"""How the prediction changes with every parameter of every effect, around the current model.

A column is the change of the predicted samples for one usual size of one number: by a small difference where the
effect is in the model already, by a secant from its absent value where it is not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from infotraj.diagnosis.linear.candidates import Candidate, Variant, places, variants
from infotraj.diagnosis.linear.observation import Member, Observation, inward, packed, unpacked
from infotraj.diagnosis.measure.lapped import Lapped
from infotraj.effects.base import Effect
from infotraj.errors import InputError
from infotraj.models import Model
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

SMALL = 0.03  # of the usual size: the step of a derivative


@dataclass(frozen=True)
class Choice:
    """An absent candidate at one linearisation, with its columns in the sums."""

    variant: Variant
    columns: tuple[int, ...]
    scale: Array

    @property
    def candidate(self) -> Candidate:
        """The candidate."""
        return self.variant.candidate


@dataclass(frozen=True)
class Sensitivities:
    """Columns around a model.

    members: columns of each member; choices: absent candidates; joint: the residual and all columns over the bins of
    the transform, one (bins, 3, 1 + p) a channel of a flight.
    """

    members: tuple[tuple[int, ...], ...]
    choices: tuple[Choice, ...]
    joint: list[list[Array]]


def sensitivities(
    observation: Observation,
    members: Sequence[Member],
    absent: Sequence[Candidate],
    more: Mapping[str, Sequence[Variant]] | None = None,
    samples: bool = False,
) -> Sensitivities:
    """Residual of the model with `members`, and the columns of their numbers and of the candidates in `absent`.

    more: linearisations beside a candidate's own, by its label; samples: sample by sample, (m, 3, 1 + p) a channel,
    instead of over the bins of the transform.
    """
    vehicle = observation.vehicle
    x, owner = packed(members, vehicle)
    effects = [m.effect for m in members]
    models: list[tuple[list[Effect], float]] = []
    of_members: list[list[int]] = [[] for _ in members]
    for i, (number, place) in enumerate(owner):
        step = inward(x[i] * place.scale, place, SMALL * abs(place.scale)) / place.scale
        own = [k for k, (n, _) in enumerate(owner) if n == number]
        (moved,) = unpacked(members[number : number + 1], vehicle, x[own] + step * np.equal(own, i))
        models.append(([*effects[:number], moved.effect, *effects[number + 1 :]], step))
        of_members[number].append(len(models) - 1)
    choices = []
    for candidate in absent:
        for variant in (*variants(candidate, vehicle), *(more or {}).get(candidate.label, ())):
            if not variant.points:
                continue
            columns = []
            for _, effect, size in variant.points:
                columns.append(len(models))
                models.append(([*effects, effect], size))
            choices.append(_choice(variant, tuple(columns), vehicle))
    factor = np.array([1.0 / step for _, step in models])
    for choice in choices:
        # Columns are per usual size, whatever the step of the secant.
        factor[list(choice.columns)] *= choice.scale
    changed = [(moved, f) for (moved, _), f in zip(models, factor, strict=True)]
    joint = columns_of(observation, effects, changed, samples)
    return Sensitivities(tuple(map(tuple, of_members)), tuple(choices), joint)


def _choice(variant: Variant, columns: tuple[int, ...], vehicle: Vehicle) -> Choice:
    at = places(variant.candidate, vehicle)
    return Choice(variant, columns, np.array([at[i].scale for i, _, _ in variant.points]))


def columns_of(
    observation: Observation,
    effects: Sequence[Effect],
    changed: Sequence[tuple[Sequence[Effect], float]],
    samples: bool = False,
) -> list[list[Array]]:
    """The residual of the vehicle with `effects`, and what it loses with each changed set of effects, times a factor.

    Over the bins of the transform, one (bins, 3, 1 + p) a channel of a flight; samples: sample by sample instead. What
    a changed set loses is computed between fewer points than the residual: it need not be as exact.
    """

    def kept(turn: Lapped, x: Array) -> Array:
        return x if samples else turn.binned(x)

    out = []
    models = [(Model(observation.vehicle, moved), factor) for moved, factor in changed]
    now = Model(observation.vehicle, effects)
    for s, coarse, turns in zip(observation.samples, observation.coarse, observation.transforms, strict=True):
        own = [kept(turn, b) for turn, b in zip(turns, s.residual(now), strict=True)]
        joint = [np.zeros((*b.shape, 1 + len(models))) for b in own]
        for made, b in zip(joint, own, strict=True):
            made[..., 0] = b
        base = coarse.residual(now) if models else []
        for k, (model, factor) in enumerate(models):
            try:
                with np.errstate(all="ignore"):
                    residual = coarse.residual(model)
            except InputError:
                continue
            for made, turn, b, r in zip(joint, turns, base, residual, strict=True):
                # What a model leaves as it was is the same array.
                if r is not b:
                    made[..., 1 + k] = kept(turn, _finite((b - r) * factor))
        out.append(joint)
    return out


def _finite(x: Array) -> Array:
    return x if np.isfinite(x).all() else np.nan_to_num(x)
