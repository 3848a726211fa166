"""The model that is given: what is named is added, and flights that were not fitted are predicted better for it.

Every number of the file is in the model as these flights have it, where flights that were not fitted are predicted
better for it. Else numbers are fitted beside the file as it is, as far as they can take along what the file is off by,
or beside its thrust over mass alone, which `thrust_scale` says, or `mass_offset`: nearly every force is told beside the
thrust, and a fall of it with the voltage is none beside a file that is right at half of the charge. A number with which
an axis is still predicted worse stays absent where it spoils more than it mends: what a wrong file has cancelled by
chance on one axis is no reason against a number that takes most of the error off another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from infotraj.diagnosis.gates import refusal
from infotraj.diagnosis.judge.numbers import OF_THRUST_OVER_MASS, labels_of_file, out_of_line, thrust_over_mass
from infotraj.diagnosis.judge.path import shows_on_path
from infotraj.diagnosis.linear.candidates import places
from infotraj.diagnosis.linear.observation import Member, Observation
from infotraj.diagnosis.select.bounds import beyond_bounds
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.predicting import TELLS, fall, left, net
from infotraj.diagnosis.select.prior import SCALES, Scales
from infotraj.diagnosis.select.score import Choice, Solution
from infotraj.diagnosis.select.search import Search
from infotraj.progress import reached
from infotraj.rotations import Array

WORSE = 1.05  # times the error of an axis on flights that were not fitted, less than which is no difference
_ROUNDS = 4  # it changes what the other numbers mean: a fit beside it is further away than one without
_STEADY = "steady_force"
_LEAST = 1e-4  # of an axis' squared error: what changes less does not act on it


@dataclass(frozen=True)
class Given:
    """The fit of the model that is given. lost: labels of effects of which no number is left, and why; held_back: the
    same for effects of which numbers stay absent though they are sure; beside: labels that no name is given for, which
    correct the file; of_ratio: fits with each label that could correct thrust over mass, what predicts best first;
    at_bound: labels whose numbers end at a physical bound beside the file as it is but for thrust over mass: what else
    corrects it makes no bound, and takes none away."""

    fit: Fit
    at_bound: dict[str, str]
    lost: dict[str, str] = field(default_factory=dict)
    held_back: dict[str, str] = field(default_factory=dict)
    beside: tuple[str, ...] = ()
    of_ratio: dict[str, Fit] = field(default_factory=dict)

    @cached_property
    def gain(self) -> float:
        """By how much errors on flights that were not fitted fall from those of the model as given, their logarithms
        over all axes together; as they are and in units of their noise (`fall`)."""
        *shares, stays = _both_shares(self.fit)
        plain, weighted = (np.where(s > 0.0, -np.log(np.clip(s, 1e-6, 1e6)), 0.0) for s in shares)
        return float(fall(plain, weighted, stays).sum())


def given(search: Search, whole: Fit, labels: Sequence[str]) -> Given:
    """The model with the effects `labels`, from the fit of all that the search took."""
    if not search.known:
        return Given(whole, {})
    observation = search.observation
    of_ratio: dict[str, Fit] = {}
    beside: tuple[str, ...] = ()
    if observation.healthy is not None:
        if not labels:
            return Given(whole, beyond_bounds(whole.members, observation.vehicle))
        inside = set(labels) <= set(whole.labels)
        made = _as_found(search, whole, labels) if inside else search.fitted(labels, whole, Scales(0.0))
        at_bound = beyond_bounds(made.members, observation.vehicle)
    else:
        reached("the new model", 0, 2)
        made = search.fitted(labels, whole, Scales(0.0), go_on=True)
        reached("the new model", 1, 2)
        of_ratio = _of_ratio(search, whole, labels, made, _ratio(search, whole, labels))
        made = next(iter(of_ratio.values()), made)
        at_bound = beyond_bounds(made.members, observation.vehicle)
        ratio = next(iter(of_ratio), None)
        asked = [*labels, ratio] if ratio and out_of_line(whole, {x.split()[0] for x in labels}) else labels
        reached("the file's numbers")
        corrected = _corrected(search, whole, made, asked)
        beside = (ratio,) if ratio and (corrected is None or ratio in asked) else ()
        if corrected is not None:
            made, beside = corrected, (*beside, *(x for x in corrected.labels if x in corrected.scales.corrects))
        if not labels and not beside:
            return Given(whole, {})
        # What was judged is the model at these numbers, of which the last step may not have been taken.
        made = _at(made, made.solution.theta, made.solution.each)
    fit, lost, held_back = _pruned(made)
    stay = beyond_bounds(fit.members, observation.vehicle)
    at_bound = {k: v for k, v in at_bound.items() if k in stay or k not in held_back}
    left = {m.candidate.label for m in fit.members if _as_before(m, observation)}
    lost |= {x: lost.get(x, "the model that predicts best has nothing of it") for x in left}
    beside, absent = tuple(x for x in beside if x not in lost), set(beside) & lost.keys()
    fit = replace(fit, chosen=tuple(i for i in fit.chosen if fit.linear.choices[i].label not in absent))
    return Given(fit, at_bound, {k: v for k, v in lost.items() if k in labels}, held_back, beside, of_ratio)


def _of_ratio(search: Search, whole: Fit, labels: Sequence[str], bare: Fit, ratio: Sequence[str]) -> dict[str, Fit]:
    """The model with each label that may correct the file's thrust over mass, where it predicts better with it."""
    tried = {x: search.fitted([*labels, x], whole, Scales(0.0), _ROUNDS, go_on=True) for x in ratio}
    if not ratio:
        return {}
    least = net(_shares(bare)) - np.log(WORSE)
    found = {x: net(_shares(made)) for x, made in tried.items() if not _ends(made, bare)}
    return {x: tried[x] for x in sorted(found, key=lambda x: found[x]) if found[x] < least}


def _corrected(search: Search, whole: Fit, made: Fit, asked: Sequence[str]) -> Fit | None:
    """The model with what is asked for and every number of the file; None where the model `made` predicts as well.

    Each number is as far off beforehand as those of a file, all by a common factor: the one with which flights that
    were not fitted are predicted best (ridge regression, Hoerl and Kennard 1970; the factor by cross-validation, Stone
    1974). Marginal likelihood takes too large a one where noise is not what it is taken for.
    """
    said = {*asked, *(m.candidate.label for m in search.held)}
    # Thrust over mass is said once.
    said |= OF_THRUST_OVER_MASS if OF_THRUST_OVER_MASS & said else set()
    file = [x for x in labels_of_file(whole) if x not in said]
    moving = np.array([refusal.axis_group(a) is not None for a in whole.linear.sums.axes])
    if _STEADY in file:
        rest = [x for x in file if x != _STEADY]
        both = (_with_file(search, whole, asked, x, whole.scales.common) for x in (file, rest))
        file = file if shows_on_path(*both) else rest
    if not file:
        return None
    least = net(_shares(made)[moving]) - TELLS
    tried = [_with_file(search, whole, asked, file, s) for s in SCALES]
    nets = {k: net(_shares(f)[moving]) for k, f in enumerate(tried)}
    # Beside numbers that may be less far off none ends at a bound.
    for k in sorted((k for k in nets if nets[k] < least), key=lambda k: nets[k]):
        fit = search.fitted(tried[k].labels, whole, tried[k].scales, _ROUNDS)
        if not _ends(fit, made):
            return fit if net(_shares(fit)[moving]) < least else None
    return None


def _with_file(search: Search, whole: Fit, asked: Sequence[str], file: Sequence[str], common: float) -> Fit:
    """What is asked for and every number of the file, as the model around `whole` has them; common: how far it is off.

    What is wrong with clocks and mounts of the log is fitted along, and no part of the model.
    """
    scales = replace(whole.scales.times(common / whole.scales.common), corrects=frozenset(file))
    chosen = whole.linear.labelled([*asked, *file])
    solution = whole.linear.scorer(scales, search.held).solution(chosen)
    made = replace(whole, chosen=chosen, scales=scales, held=search.held)
    return _at(made, solution.theta, solution.each)


def _ends(made: Fit, before: Fit) -> bool:
    """Whether numbers of a model end at a physical bound, and did not before."""
    vehicle = made.linear.observation.vehicle
    return bool(beyond_bounds(made.members, vehicle)) and not beyond_bounds(before.members, vehicle)


def _ratio(search: Search, whole: Fit, labels: Sequence[str]) -> list[str]:
    """What may correct the file's thrust over mass: where these flights show it to be off, and nothing that is named or
    in the model says it. A thrust that is corrected changes torques too, a mass does not."""
    said = {m.candidate.name for m in search.held} | {x.split()[0] for x in labels}
    found = {x.split()[0] for x in whole.labels} & OF_THRUST_OVER_MASS
    if said & OF_THRUST_OVER_MASS or not (found or thrust_over_mass(whole)):
        return []
    return sorted(OF_THRUST_OVER_MASS & {c.label for c in search.known})


def _as_before(m: Member, observation: Observation) -> bool:
    """Whether an effect has the numbers that it has in the model as given."""
    healthy, vehicle = observation.healthy, observation.vehicle
    if healthy is None:
        return m.effect.is_absent(vehicle)
    return not healthy.changed(m.candidate, m.effect, m.places(vehicle), vehicle)


def _as_found(search: Search, whole: Fit, labels: Sequence[str]) -> Fit:
    """The effects with what is new in the numbers that the search found for them, and nothing else beside what is
    healthy."""
    linear = whole.linear
    chosen = tuple(i for i in whole.chosen if linear.choices[i].label in labels)
    kept = sorted({*linear.kept, *(c for i in chosen for c in linear.choices[i].columns)})
    out = np.ones(linear.sums.width, dtype=bool)
    out[kept] = False
    theta, each, _ = (x.copy() for x in whole.changes)
    theta[out], each[:, out] = 0.0, 0.0
    before = linear.scorer(Scales(0.0), search.held).given
    if linear.kept:
        # The effects that the model has stay as they are.
        theta[list(linear.kept)] = before[list(linear.kept)]
        each[:, list(linear.kept)] = before[list(linear.kept)]
    return _at(replace(whole, chosen=chosen, scales=Scales(0.0), held=search.held), theta, each)


def _at(made: Fit, theta: Array, each: Array) -> Fit:
    """A fit with other numbers."""
    linear = made.linear
    point = linear.members(made.chosen, theta, shift=np.inf)
    solution = Solution(made.chosen, made.solution.score, theta, each)
    return replace(made, linear=replace(linear, point=point), solution=solution)


def _shares(made: Fit, each: Array | None = None) -> Array:
    """Root mean square error (axes,) on flights not fitted, as a share of that of the model as given; 0 of nothing."""
    before = left(made, None)
    after = left(made, made.solution.each if each is None else each)
    return _roots(before, after)


def _both_shares(made: Fit) -> tuple[Array, Array, Array]:
    """The same, that of errors in units of their noise, frequency by frequency, and the squares left in these units;
    infinite where one sensor is held against another, which moves no vehicle."""
    stays = left(made, made.solution.each, weighted=True)
    moves = [refusal.axis_group(a) is not None for a in made.linear.sums.axes]
    return _shares(made), _roots(left(made, None, weighted=True), stays), np.where(moves, stays, np.inf)


def _roots(before: Array, after: Array) -> Array:
    return np.where(before > 0, np.sqrt(after / np.maximum(before, 1e-300)), 0.0)


def _pruned(made: Fit) -> tuple[Fit, dict[str, str], dict[str, str]]:
    """The fit without the numbers for which an axis is predicted worse, and labels of which none or some are left."""
    units = _units(made)
    theta, each = made.solution.theta.copy(), made.solution.each.copy()
    why: dict[str, str] = {}
    gone: set[tuple[int, ...]] = set()
    while True:
        share = _shares(made, each)
        k = int(np.argmax(share))
        left = [u for u in units if u not in gone and _acts(made, each, u, k)]
        if share[k] <= WORSE or not left:
            break
        tried = {u: _without(theta, each, u) for u in left}
        shares = {u: _shares(made, x) for u, (_, x) in tried.items()}
        spoil = [u for u in left if shares[u][k] < share[k] and net(shares[u]) < net(share)]
        if not spoil:
            break
        best = min(spoil, key=lambda u: net(shares[u]))
        axis = refusal.axis_group(made.linear.sums.axes[k]) or made.linear.sums.axes[k]
        why.setdefault(units[best], f"{axis} is predicted worse with it, by {100 * (share[k] - 1):.0f} %")
        gone.add(best)
        theta, each = tried[best]
        if units[best] in made.labels and all(u in gone for u, owner in units.items() if owner == units[best]):
            break  # what is left is fitted anew without it
    if not gone:
        return made, {}, {}
    lost, held_back = {}, {}
    for label, reason in ((x, r) for x, r in why.items() if x in made.labels):
        own = [u for u, owner in units.items() if owner == label]
        out = [u for u in own if u in gone]
        if len(out) == len(own):
            lost[label] = f"{reason}, on flights that were not fitted"
        else:
            columns = [made.linear.columns[u[0]] for u in out]
            at = places(columns[0].candidate, made.linear.observation.vehicle)
            names = ", ".join(f"{at[c.place].parameter}[{at[c.place].component}]" for c in columns)
            held_back[label] = f"without {names} in the model: {reason}, on flights that were not fitted"
    return _at(made, theta, each), lost, held_back


def _units(made: Fit) -> dict[tuple[int, ...], str]:
    """What may stay absent by itself, with its effect's label: each number of a vector, or an effect as a whole.

    Where several effects of a kind correct the file, as every rotor does, all numbers of that kind, with the kind.
    """
    vehicle = made.linear.observation.vehicle
    units: dict[tuple[int, ...], str] = {}
    of_kind: dict[str, list[Choice]] = {}
    for choice in (made.linear.choices[i] for i in made.chosen):
        declared = made.linear.columns[choice.columns[0]].candidate.cls.declared
        kind = declared.kind if declared is not None and choice.label in made.scales.corrects else choice.label
        of_kind.setdefault(kind, []).append(choice)
    for label, choices in of_kind.items():
        every = tuple(c for choice in choices for c in choice.columns)
        columns = [made.linear.columns[c] for c in every]
        at = places(columns[0].candidate, vehicle)
        vector = len(choices) == 1 < len(every) and len({at[c.place].parameter for c in columns}) == 1
        units |= {(c,): label for c in every} if vector else {every: label}
    return units


def _acts(made: Fit, each: Array, columns: Sequence[int], axis: int) -> bool:
    """Whether these numbers change what is predicted of an axis."""
    sums = made.linear.absent
    place = [1 + c for c in columns]
    gram = sums.plain[axis][:, place][:, :, place]
    moved = np.einsum("fi,fij,fj->", each[:, list(columns)], gram, each[:, list(columns)])
    return bool(moved > _LEAST * sums.plain[axis, :, 0, 0].sum())


def _without(theta: Array, each: Array, columns: Sequence[int]) -> tuple[Array, Array]:
    """Numbers, on all folds and without each, after these columns have been taken out."""
    theta, each = theta.copy(), each.copy()
    theta[list(columns)], each[:, list(columns)] = 0.0, 0.0
    return theta, each
