"""What is ordinary: how far the numbers of any vehicle file are off, and how far they are off on these flights."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from infotraj.diagnosis.observation import Member
from infotraj.diagnosis.sensitivities import Sensitivities
from infotraj.diagnosis.sums import Sums
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

# Standard deviations in usual sizes of the effect (Parameter.scale), with what that is.
TOLERANCES = {
    "rotor_effectiveness": 1 / 15,  # 1 % of a rotor's thrust
    "inertia_error": 2 / 15,  # 2 %
    "com_offset": 1 / 10,  # 0.3 % of an arm
    "moment_scale": 1 / 30,  # 1 %
    "rotor_lag": 1 / 30,  # 1 ms
    "servo_lag": 1 / 30,  # 1 ms
    "actuation_delay": 1 / 15,  # 1 ms
    "time_offset": 1 / 10,  # 1 ms
    "servo_bias": 1 / 10,  # 0.1 deg
    "imu_misalignment": 1 / 10,  # 0.1 deg
}
# Where commands are logged more slowly than this, what was in force between two samples is not known.
DENSE = 0.005  # s
_UNSURE = 1 / 6  # of the time beyond twice that by which they may seem early or late, however they are read
_STAMP = 0.1  # of the time between rows: time stamps are hardly more exact, whatever else is
_FREE = 100.0  # standard deviations: no prior at all
TIMING = ("rotor_lag", "servo_lag", "actuation_delay", "time_offset")
_SHOWN = 10.0  # squared error that a kind of tolerance would raise: with more, flights say how large it is
_MOST = 3.0  # standard deviations that are ordinary
_SCALES = (0.03, 0.1, 0.3, 0.6, 1.0, 1.5)  # of all tolerances together


def scale_and_spread(sums: Sums, found: Sensitivities) -> tuple[float, Array]:
    """How large the tolerances are on these flights, times ordinary ones, and the variance (p,) that they give the fit.

    Each tolerance that the model does not have moves the numbers that are fitted without it. Their common scale is
    estimated from what the fit leaves, by marginal likelihood (MacKay 1992): exact vehicle files get 0, also where one
    thing alone is off. Where kinds of tolerance differ, the second largest scale of a kind counts, and that of a kind
    of which several are off (rotors): they say that the file is not exact, one thing alone may be an effect. The
    variance is that of the members' numbers in usual sizes, each kind at its own scale where these flights show it.
    sums: of the fitted model and all candidates.
    """
    columns, deviation = nuisance(found)
    own = list(found.of_members)
    if not columns:
        return 0.0, np.zeros(len(own))
    gram, right, _ = sums.total()
    gram, right = gram.sum(axis=0), right.sum(axis=0)
    of_own = gram[np.ix_(own, own)]
    of_own = of_own + 1e-9 * np.diag(np.diag(of_own)) + 1e-12 * np.eye(len(own))
    across = gram[np.ix_(own, columns)] * deviation
    solved = np.linalg.solve(of_own, across)
    rest = gram[np.ix_(columns, columns)] * np.outer(deviation, deviation) - across.T @ solved
    pull = right[columns] * deviation - solved.T @ right[own]
    owner = {c: choice.candidate.name for choice in found.choices for c in choice.columns}
    kinds = ["timing" if owner[c] in TIMING else owner[c] for c in columns]
    names = list(dict.fromkeys(kinds))
    kind = np.array([names.index(k) for k in kinds])
    labels = {c: choice.candidate.label for choice in found.choices for c in choice.columns}
    label = np.array([labels[c] for c in columns])
    common = _common_scale(rest, pull, label)
    of_kind = _scales_by_kind(rest, pull, kind)
    second = float(np.sort(of_kind)[-2]) if len(of_kind) > 1 else 0.0
    apart = [np.flatnonzero(kind == k) for k in range(len(names)) if names[k] != "timing"]
    several = max((_common_scale(rest[np.ix_(i, i)], pull[i], label[i]) for i in apart), default=0.0)
    scale = max(common, second, several)
    shown = np.maximum(scale, of_kind) ** 2 * np.bincount(kind, np.diag(rest)) > _SHOWN
    each = np.where(shown, of_kind, scale)[kind]
    each = np.maximum(each, nuisance(found, 0.0)[1] / deviation)
    return scale, np.sum((each * solved) ** 2, axis=1)


def stamp_variance(members: Sequence[Member], vehicle: Vehicle, command_step: float) -> Array:
    """Variance (p,) of the members' numbers in usual sizes by what time stamps are off: 0 but for times."""
    return np.array(
        [
            (_STAMP * command_step / p.scale) ** 2 if m.candidate.name in TIMING else 0.0
            for m in members
            for p in m.places(vehicle)
        ]
    )


def unsure(command_step: float) -> float:
    """Standard deviation (s) of when commands acted that were logged every `command_step` s."""
    return _UNSURE * max(command_step - 2 * DENSE, 0.0)


def _evidence(rest: Array, pull: Array, scale: Array) -> float:
    """Twice the log marginal likelihood, up to a constant, under tolerances of these scales (q,)."""
    inside = np.eye(len(pull)) + rest * np.outer(scale, scale)
    scaled = pull * scale
    return float(scaled @ np.linalg.solve(inside, scaled) - np.linalg.slogdet(inside)[1])


def _common_scale(rest: Array, pull: Array, label: NDArray) -> float:
    """The most likely common scale when the one thing that raises it most is left out of it."""
    least = np.inf
    for one in (None, *dict.fromkeys(label)):
        free = label == one
        trials = [_evidence(rest, pull, np.where(free, _FREE, scale)) for scale in (0.0, *_SCALES)]
        least = min(least, (0.0, *_SCALES)[int(np.argmax(trials))])
    return least


def _scales_by_kind(rest: Array, pull: Array, kind: NDArray) -> Array:
    """The most likely scale of every kind of tolerance (kinds,), found one after another, three times round."""
    of_kind = np.zeros(kind.max() + 1)
    for _ in range(3):
        for k in range(len(of_kind)):
            trials = []
            for scale in (0.0, *_SCALES):
                of_kind[k] = scale
                trials.append(_evidence(rest, pull, of_kind[kind]))
            of_kind[k] = (0.0, *_SCALES)[int(np.argmax(trials))]
    return of_kind


def ordinary(sums: Sums, found: Sensitivities, scale: float) -> tuple[list[int], Array]:
    """Columns of the tolerances, and their standard deviations, without those that would have to be extraordinary.

    What asks for more than three standard deviations is no tolerance but may be an effect: the worst goes first, and
    with it all numbers of its candidate. scale: how large tolerances are, times ordinary ones.
    """
    columns, deviation = nuisance(found, scale)
    owner = {c: choice.candidate.label for choice in found.choices for c in choice.columns}
    while columns:
        numbers = beside_members(sums, found, columns, deviation)[columns]
        worst = int(np.argmax(np.abs(numbers / deviation)))
        if abs(numbers[worst] / deviation[worst]) <= _MOST:
            break
        kept = [k for k, c in enumerate(columns) if owner[c] != owner[columns[worst]]]
        columns, deviation = [columns[k] for k in kept], deviation[kept]
    return columns, deviation


def without_tolerances(sums: Sums, found: Sensitivities, scale: float) -> Sums:
    """The sums after what tolerances explain beside the members has been taken off the residual.

    scale: how large the tolerances are, times ordinary ones.
    """
    columns, deviation = ordinary(sums, found, scale)
    if not columns:
        return sums
    theta = beside_members(sums, found, columns, deviation)
    theta[list(found.of_members)] = 0.0
    return sums.shifted(theta)


def beside_members(sums: Sums, found: Sensitivities, columns: Sequence[int], deviation: Array) -> Array:
    """Numbers (p,) of all columns when the members' are free and these have a prior; 0 for the others.

    deviation: its standard deviations, in usual sizes.
    """
    own = list(found.of_members)
    index = np.array([*own, *columns], dtype=int)
    prior = np.concatenate([np.full(len(own), 1e-6), 1 / deviation**2])
    gram, right, _ = sums.total()
    theta = np.zeros(gram.shape[-1])
    theta[index] = np.linalg.solve(gram.sum(axis=0)[np.ix_(index, index)] + np.diag(prior), right.sum(axis=0)[index])
    return theta


def nuisance(found: Sensitivities, scale: float = 1.0) -> tuple[list[int], Array]:
    """Columns that tolerances move, and their standard deviations in usual sizes; scale: times ordinary ones."""
    columns, deviation, seen = [], [], set()
    for choice in found.choices:
        label = choice.candidate.label
        if choice.candidate.name not in TOLERANCES or label in seen:
            continue
        seen.add(label)
        columns += list(choice.columns)
        own = scale * TOLERANCES[choice.candidate.name]
        if choice.candidate.name in ("actuation_delay", "time_offset"):
            own += unsure(found.command_step) / abs(choice.scale[0])
        if choice.candidate.name in TIMING:
            own = max(own, _STAMP * found.command_step / abs(choice.scale[0]))
        deviation += [own] * len(choice.columns)
    return columns, np.array(deviation)
