"""How the prediction changes with every parameter of every effect, around the current model.

A column is the change of the predicted samples for one usual size of one number: by a small difference where the
effect is in the model already, by a secant from its absent value where it is not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace

import numpy as np

from infotraj.diagnosis.linear.candidates import Candidate, Place, Variant, places, variants, written
from infotraj.diagnosis.linear.observation import Member, Observation, inward, packed, unpacked
from infotraj.effects.base import Effect
from infotraj.errors import InputError
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

SMALL = 0.03  # of the usual size: the step of a derivative


@dataclass(frozen=True)
class Choice:
    """An absent candidate at one linearisation, with its columns in the sums."""

    variant: Variant
    columns: tuple[int, ...]
    now: Array
    scale: Array
    low: Array
    high: Array

    @property
    def candidate(self) -> Candidate:
        """The candidate."""
        return self.variant.candidate


@dataclass(frozen=True)
class Sensitivities:
    """Columns around a model.

    members: columns of each member; now, scale, low, high: of the members' numbers; choices: absent candidates; joint:
    the residual and all columns, one (m, 3, 1 + p) a channel of a flight, not whitened; command_step: of `Observation`.
    """

    members: tuple[tuple[int, ...], ...]
    now: Array
    scale: Array
    low: Array
    high: Array
    choices: tuple[Choice, ...]
    joint: list[list[Array]]
    command_step: float = 0.0

    @property
    def of_members(self) -> tuple[int, ...]:
        """Columns of all members."""
        return tuple(c for part in self.members for c in part)


def sensitivities(
    observation: Observation,
    members: Sequence[Member],
    absent: Sequence[Candidate],
    more: Mapping[str, Sequence[Variant]] | None = None,
    skip: AbstractSet[str] = frozenset(),
) -> Sensitivities:
    """Residual of the model with `members`, and the columns of their numbers and of the candidates in `absent`.

    more: linearisations beside a candidate's own, by its label; skip: labels of members whose columns are not asked
    for.
    """
    vehicle = observation.vehicle
    x, owner = packed(members, vehicle)
    effects = [m.effect for m in members]
    models: list[tuple[list[Effect], float]] = []
    of_members: list[list[int]] = [[] for _ in members]
    for i, (number, place) in enumerate(owner):
        if members[number].candidate.label in skip:
            continue
        step = inward(x[i] * place.scale, place, SMALL * abs(place.scale)) / place.scale
        moved = x.copy()
        moved[i] += step
        models.append(([m.effect for m in unpacked(members, vehicle, moved)], step))
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
    scales = np.array([p.scale for _, p in owner])
    joint = _joint(observation, effects, models, choices)
    low, high = (np.array([getattr(p, side) for _, p in owner]) for side in ("low", "high"))
    return Sensitivities(
        tuple(map(tuple, of_members)), x * scales, scales, low, high, tuple(choices), joint, observation.command_step
    )


def extended(
    found: Sensitivities, observation: Observation, members: Sequence[Member], variant: Variant
) -> Sensitivities:
    """The same with the columns of one more linearisation behind the others."""
    count = found.joint[0][0].shape[2] - 1
    effects = [m.effect for m in members]
    models = [([*effects, effect], size) for _, effect, size in variant.points]
    local = _choice(variant, tuple(range(len(models))), observation.vehicle)
    more = _joint(observation, effects, models, [local])
    joint = [
        [np.concatenate([a, b[:, :, 1:]], axis=2) for a, b in zip(old, new, strict=True)]
        for old, new in zip(found.joint, more, strict=True)
    ]
    choice = replace(local, columns=tuple(count + c for c in local.columns))
    return replace(found, choices=(*found.choices, choice), joint=joint)


def _choice(variant: Variant, columns: tuple[int, ...], vehicle: Vehicle) -> Choice:
    at = places(variant.candidate, vehicle)
    kept = [at[i] for i, _, _ in variant.points]
    return Choice(
        variant,
        columns,
        np.array([p.absent for p in kept]),
        np.array([p.scale for p in kept]),
        np.array([p.low for p in kept]),
        np.array([p.high for p in kept]),
    )


def _joint(observation, effects, models, choices) -> list[list[Array]]:
    factor = np.array([1.0 / step for _, step in models])
    for choice in choices:
        # Columns are per usual size, whatever the step of the secant.
        factor[list(choice.columns)] *= choice.scale
    out = []
    for s in observation.samples:
        base = s.residual(observation.model([]).with_effects(*effects))
        joint = [np.empty((len(b), 3, 1 + len(models))) for b in base]
        for part, b in zip(joint, base, strict=True):
            part[:, :, 0] = b
        for k, (moved, _) in enumerate(models):
            try:
                with np.errstate(all="ignore"):
                    residual = s.residual(observation.model([]).with_effects(*moved))
            except InputError:
                residual = base
            for part, b, r in zip(joint, base, residual, strict=True):
                part[:, :, 1 + k] = np.nan_to_num((b - r) * factor[k])
        out.append(joint)
    return out


def start_of(choice: Choice, at: Sequence[Place], theta: Array) -> Effect:
    """The effect to start a fit from: the linear answer theta (usual sizes), within its bounds and not absent.

    at: the places of the candidate. A number with its absent value at a bound starts at a tenth of its usual size at
    least, and at three times at most: its effect is rarely linear so far out.
    """
    x = choice.variant.start.copy()
    for k, (i, _, size) in enumerate(choice.variant.points):
        one_sided = min(choice.now[k] - choice.low[k], choice.high[k] - choice.now[k]) < 1e-12
        amount = theta[k] * choice.scale[k]
        if one_sided:
            amount = size * float(np.clip(amount / size, 0.1, 3.0))
        x[i] = np.clip(choice.now[k] + amount, choice.low[k], choice.high[k])
    return written(choice.candidate, at, x)
