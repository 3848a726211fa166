"""How strong the evidence for an effect is: on flights that were not fitted, and by its probability."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from infotraj.diagnosis.gates import refusal
from infotraj.diagnosis.linear.candidates import firsts
from infotraj.diagnosis.linear.sums import Sums
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.predicting import fall
from infotraj.diagnosis.select.prior import Scales
from infotraj.rotations import Array

RESAMPLES = 1000
_OPEN = 8  # of the other effects of a set any may be absent: with twelve sixteen times as many sets say the same
_FEW_FLIGHTS = 3  # and more say what flights differ by
_LEAST = 1e-3  # of the squared error that is left on an axis: what moves it by less does not act there


@dataclass(frozen=True)
class Evidence:
    """Evidence for one effect beside the others of a set.

    heldout_change: relative change of the weighted squared error on flights not fitted, of the axes on which it acts,
    with its 95 % interval; flights_better: folds in which it falls, of all; selected: share of resamples in which it
    falls; rise: by how much the error on the most affected axis rises without it, in units of the floor; by_axis: that
    of each axis; axis: the most affected one; falls: the logarithm by which the root mean square error (slow, weighed
    by coherence) of flights not fitted falls on each axis on which it acts; gain: their sum; probability: that it is
    needed; form_error: share by which its size differs between parts of the flights.
    """

    heldout_change: float
    ci95: tuple[float, float]
    flights_better: tuple[int, int]
    selected: float
    rise: float
    axis: str
    by_axis: dict[str, float] = field(default_factory=dict)
    falls: dict[str, float] = field(default_factory=dict)
    gain: float = 0.0
    probability: float = 0.0
    form_error: float = 0.0

    @property
    def against(self) -> bool:
        """Whether flights that were not fitted are predicted worse with the effect, on every fold and resample."""
        return self.heldout_change > 0.0 and self.flights_better[0] == 0 and self.selected == 0.0


def little(e: Evidence) -> str:
    """That an effect takes too little off to be named."""
    return f"it takes {max(1.0 - np.exp(-e.gain), 0.0):.0%} of the error off flights that were not fitted"


def evidence(whole: Fit, label: str, rng: np.random.Generator, rest: Fit | None = None) -> Evidence:
    """Evidence for one effect of a fitted set: the set as it is against the set without any of the effect's numbers.

    rest: the set without it, fitted by itself. It is needed of an effect that is not linear in its numbers: what a
    derivative says of the model without it may be wrong by any amount.
    """
    linear = whole.linear
    mine = [i for i, c in enumerate(linear.columns) if c.candidate.label == label]
    chosen = tuple(i for i in whole.chosen if linear.choices[i].label != label)
    own_choice = [i for i in whole.chosen if linear.choices[i].label == label]
    each, wider = whole.solution.each, overdispersion(whole)[0]
    nats = any_of(whole, chosen, own_choice, wider) - any_of(rest or whole, rest.chosen if rest else chosen, (), wider)
    if rest is None:
        without = _Left.of(whole, whole.scorer.beside(chosen, each, mine))
    else:
        own = [i for i, c in enumerate(rest.linear.columns) if c.candidate.label == label]
        without = _Left.of(rest, rest.scorer.beside(rest.chosen, translated(whole, each, rest), own))
    return _against(whole, without, _Left.of(whole, each), nats, mine, rng, whole.solution.theta)


def any_of(made: Fit, of: Sequence[int], always: Sequence[int], wider: float) -> float:
    """Logarithm of the probability, up to a constant, of the choices `always` with any of the others `of`.

    Whichever of them: what needs a second effect beside it is no surer than the two together. Of many others those may
    be absent that are least missed. wider: how much more the data scatter than the noise model says.
    """
    whole = (*always, *of)
    if len(of) > _OPEN:
        missed = -made.log_probability([tuple(i for i in whole if i != x) for x in of])
        of = [of[k] for k in np.argsort(missed)[:_OPEN]]
    stay = tuple(i for i in whole if i not in of)
    sets = [(*stay, *some) for k in range(len(of) + 1) for some in combinations(of, k)]
    return float(np.logaddexp.reduce(made.log_probability(sets) / wider))


def shared(whole: Fit, found: Mapping[str, Evidence]) -> dict[str, Evidence]:
    """The evidence for every effect of a set, by label, with no more gain on an axis than the set has there.

    Where numbers make up for one another the model without one of them is worse than the model without any: what two
    claim together of an axis goes to each in proportion. What others make up for elsewhere is not an effect's doing.
    """
    linear, each = whole.linear, whole.solution.each
    mine = [i for i, c in enumerate(linear.columns) if c.candidate.label in whole.labels]
    without, kept = _Left.of(whole, whole.scorer.beside((), each, mine)), _Left.of(whole, each)
    own = acts(linear.absent, mine, whole.solution.theta, kept.believed)
    together = dict(zip(linear.sums.axes, np.where(own, np.maximum(_falls(without, kept), 0.0), 0.0), strict=True))
    share = {}
    for axis, gain in together.items():
        alone = sum(max(e.falls.get(axis, 0.0), 0.0) for e in found.values())
        share[axis] = min(1.0, float(gain) / alone) if alone > 0.0 else 1.0
    return {
        label: replace(e, gain=float(sum(share[a] * x if x > 0.0 else x for a, x in e.falls.items())))
        for label, e in found.items()
    }


def _falls(without: _Left, kept: _Left) -> Array:
    """The logarithm by which the root mean square error of each axis falls, (axes,): of the slow one, weighed by
    coherence, and of all of it in units of its noise (`fall`)."""
    plain = 0.5 * np.log(np.maximum(without.believed, 1e-300) / np.maximum(kept.believed, 1e-300))
    weighted = 0.5 * np.log(np.maximum(without.error.sum(axis=1), 1e-300) / np.maximum(kept.error.sum(axis=1), 1e-300))
    stays = np.full(len(kept.noise), np.inf)
    np.divide(kept.error.sum(axis=1), kept.noise, out=stays, where=kept.noise > 0.0)
    return fall(plain, weighted, stays)


def translated(whole: Fit, each: Array, rest: Fit) -> Array:
    """Numbers (folds, p) of one fit in the columns of another, by label and place; its own where there are none."""
    known = firsts((c.candidate.label, c.place) for c in whole.linear.columns)
    out = rest.solution.each.copy()
    for i, c in enumerate(rest.linear.columns):
        if (c.candidate.label, c.place) in known and out[:, i].any():
            out[:, i] = each[:, known[c.candidate.label, c.place]]
    return out


@dataclass(frozen=True)
class _Left:
    """What a model leaves: weighted squared error (axes, blocks), mean squares (axes,) of what goes with the motion.

    noise (axes,): what the richest model leaves of the first, all blocks together; 0 where one sensor is held against
    another, which moves no vehicle.
    """

    error: Array
    believed: Array
    noise: Array

    @classmethod
    def of(cls, made: Fit, theta: Array) -> _Left:
        """With numbers theta (folds, p), each fold under its own."""
        sums = made.linear.absent
        moves = [refusal.axis_group(a) is not None for a in sums.axes]
        return cls(made.error(theta), sums.believed_error(theta), np.where(moves, sums.noise, 0.0))


def evidence_of_absent(whole: Fit, choice: int, rng: np.random.Generator) -> Evidence:
    """The same for one that is not in the set, were it added."""
    chosen = (*whole.chosen, choice)
    wider = overdispersion(whole)[0]
    nats = float(np.subtract(*whole.log_probability([chosen, whole.chosen]))) / wider
    added = whole.scorer.solution(chosen)
    mine = list(whole.linear.choices[choice].columns)
    without, with_it = _Left.of(whole, whole.solution.each), _Left.of(whole, added.each)
    return _against(whole, without, with_it, nats, mine, rng, added.theta)


def gain_beside(whole: Fit, choice: int) -> float:
    """The logarithm by which errors of flights that were not fitted fall with one more effect: `Evidence.gain`."""
    added, mine = whole.scorer.solution((*whole.chosen, choice)), whole.linear.choices[choice].columns
    without, kept = _Left.of(whole, whole.solution.each), _Left.of(whole, added.each)
    return float(_falls(without, kept)[acts(whole.linear.absent, mine, added.theta, kept.believed)].sum())


def _against(
    whole: Fit, out: _Left, kept: _Left, nats: float, mine: Sequence[int], rng: np.random.Generator, theta: Array
) -> Evidence:
    sums = whole.linear.absent
    # What other numbers do on an axis meanwhile is not this effect's doing.
    own = acts(sums, mine, theta, kept.believed)
    lost, left = out.error[own], kept.error[own]
    draws = resampled(sums.flight, rng)
    a, b = draws @ lost.sum(axis=0), draws @ left.sum(axis=0)
    change = (b - a) / np.maximum(a, 1e-300)
    better = [bool(left[:, sums.fold == f].sum() < lost[:, sums.fold == f].sum()) for f in np.unique(sums.fold)]
    rise, falls = _risen(sums, out, kept, own)
    total = float(lost.sum())
    return Evidence(
        float((left.sum() - total) / max(total, 1e-300)),
        (float(np.quantile(change, 0.025)), float(np.quantile(change, 0.975))),
        (sum(better), len(better)),
        float(np.mean(b < a)),
        float(rise.max()),
        sums.axes[int(np.argmax(rise))],
        dict(zip(sums.axes, map(float, rise), strict=True)),
        {a: float(x) for a, x, o in zip(sums.axes, falls, own, strict=True) if o},
        float(falls[own].sum()),
        float(1.0 / (1.0 + np.exp(-np.clip(nats, -50.0, 50.0)))),
        form_error(whole, mine, theta),
    )


def _risen(sums: Sums, out: _Left, kept: _Left, own: NDArray) -> tuple[Array, Array]:
    """By how much errors rise from `kept` to `out`, in units of the floor, and the logarithms by which they fall back,
    (axes,) each; no rise but on axes of `own` (axes,)."""
    takes = out.believed - kept.believed
    floor = np.maximum(kept.believed, 1e-300)
    rise = (out.error - kept.error).sum(axis=1) / np.maximum(sums.windows.sum(axis=1), 1)
    return np.where(own, np.maximum(rise, takes / floor), 0.0), _falls(out, kept)


def of_number(made: Fit, i: int) -> tuple[dict[str, float], dict[str, float]]:
    """What `Evidence.falls` and `Evidence.by_axis` are, of the number in one column, all others as they are; of the
    axes on which it acts."""
    sums, each = made.linear.absent, made.solution.each
    without = each.copy()
    without[:, i] = 0.0
    out, kept = _Left.of(made, without), _Left.of(made, each)
    own = acts(sums, [i], made.solution.theta, kept.believed)
    rise, falls = _risen(sums, out, kept, own)
    acted = [(a, float(x), float(y)) for a, x, y, o in zip(sums.axes, falls, rise, own, strict=True) if o]
    return {a: x for a, x, _ in acted}, {a: y for a, _, y in acted}


def acts(sums: Sums, mine: Sequence[int], theta: Array, left: Array) -> NDArray:
    """The axes (axes,) whose prediction these columns change with numbers theta (p,), beside what is left (axes,)."""
    place, x = [1 + i for i in mine], theta[list(mine)]
    size = np.einsum("i,afij,j->a", x, sums.believed[:, :, place][:, :, :, place], x)
    return size / np.maximum(sums.slow.sum(axis=1), 1) > _LEAST * left


def rise_beside(whole: Fit, chosen: tuple[int, ...], mine: Sequence[int], near: Array | None = None) -> float:
    """By how much the error rises with another set of choices, on the axes of `mine`, as in `Evidence.rise`.

    near (folds, p): numbers that it rises from; of the set where they are not given.
    """
    sums = whole.linear.absent
    near = whole.solution.each if near is None else near
    other = whole.scorer.beside(chosen, near, mine)
    weighted = (whole.error(other) - whole.error(near)).sum(axis=1) / np.maximum(sums.windows.sum(axis=1), 1)
    before, after = sums.believed_error(near), sums.believed_error(other)
    rise = np.maximum(weighted, (after - before) / np.maximum(before, 1e-300))
    return float(rise[acts(sums, mine, whole.solution.theta, before)].max(initial=0.0))


def left_by_set(whole: Fit, chosen: tuple[int, ...] | None = None) -> Array:
    """The logarithm of the root mean square error that a set leaves on each axis that actuators move, (axes,).

    On flights that were not fitted, beside the file as it is. chosen: another set; the fitted one where not given.
    """
    chosen = whole.chosen if chosen is None else chosen
    theta = whole.linear.scorer(Scales(0.0), whole.held).solution(chosen).each
    left = whole.linear.absent.plain_error(theta)[moving(whole)]
    return 0.5 * np.log(np.maximum(left, 1e-300))


def left_beside(whole: Fit, theta: Array, axes: NDArray) -> Array:
    """The same of what goes with the motion on these axes, with numbers theta (folds, p), each fold under its own."""
    left = whole.linear.absent.believed_error(theta)[axes]
    return 0.5 * np.log(np.maximum(left, 1e-300))


def moving(whole: Fit) -> NDArray:
    """Which axes of the residual are forces and torques that can be judged, (axes,)."""
    ignored = whole.linear.observation.ignored
    return np.array([refusal.axis_group(a) is not None and a not in ignored for a in whole.linear.sums.axes])


def resampled(flight: NDArray, rng: np.random.Generator, count: int = RESAMPLES) -> Array:
    """How often each block stands in each of `count` resamples, (count, blocks); blocks are drawn within flights."""
    draws = np.zeros((count, len(flight)))
    for f in np.unique(flight):
        own = np.flatnonzero(flight == f)
        draws[:, own] = rng.multinomial(len(own), np.full(len(own), 1 / len(own)), size=count)
    return draws


def overdispersion(whole: Fit) -> tuple[float, Array]:
    """How much more the data scatter from block to block than the noise model says, and the numbers' covariance so.

    Sandwich over blocks with a small-sample factor (Liang and Zeger 1986), never below the model's covariance, none of
    a number below the one over flights (`variance_along`). The factor tempers log probabilities (composite likelihoods;
    Pauli, Racugno and Ventura 2011). Covariance (p, p), usual sizes.
    """
    return _sandwiches(whole)[:2]


def variance_along(whole: Fit, weight: Array) -> float:
    """Variance of a weighted sum of numbers, weight (p,), usual sizes: not below the sandwich over flights, where there
    are three and more. What belongs to a flight (a clock, the heading of its estimator), or is missing in the model
    there, all its blocks say alike."""
    _, covariance, over_flights = _sandwiches(whole)
    return float(max(weight @ covariance @ weight, weight @ over_flights @ weight))


def _sandwiches(whole: Fit) -> tuple[float, Array, Array]:
    """What `overdispersion` is, and the covariance (p, p) over flights alone; zero where there are too few."""
    sums = whole.linear.absent
    free, inverse = whole.scorer.covariance(whole.chosen)
    gram = sums.gram.sum(axis=0)
    score = gram[:, 0, 1:] - gram[:, 1:, 1:] @ whole.solution.theta
    score = score[:, free]
    blocks = len(score)
    if whole.linear.scatter is not None:
        # What flights differ by is known by itself.
        for f in np.unique(sums.flight):
            own = sums.flight == f
            of_flight = gram[own][:, 1:, 1:][:, free][:, :, free]
            score[own] -= of_flight @ _own(of_flight.sum(axis=0), score[own].sum(axis=0), whole.linear.scatter[free])
    score = score - score.mean(axis=0)
    meat = score.T @ score * blocks / max(blocks - 1, 1)
    robust = inverse @ meat @ inverse
    columns = {c for i in whole.chosen for c in whole.linear.choices[i].columns}
    own = np.array([k for k, c in enumerate(free) if c in columns], dtype=int)
    ratio = np.diag(robust)[own] / np.diag(inverse)[own] if len(own) else np.ones(1)
    flights = np.unique(sums.flight)
    of_flights = np.zeros_like(inverse)
    if len(flights) >= _FEW_FLIGHTS and whole.linear.scatter is None:
        along = np.stack([score[sums.flight == f].sum(axis=0) for f in flights]) @ inverse
        of_flights = along.T @ along * len(flights) / (len(flights) - 1)
    variance = np.maximum(np.diag(robust), np.diag(of_flights))
    wider = np.sqrt(np.maximum(variance / np.diag(inverse), 1.0))
    found = []
    for x in (inverse * np.outer(wider, wider), of_flights):
        found.append(np.zeros((sums.width, sums.width)))
        found[-1][np.ix_(free, free)] = x
    return max(1.0, float(np.median(ratio))), found[0], found[1]


def _own(gram: Array, score: Array, scatter: Array) -> Array:
    """A flight's own deviation (q,) from the common numbers."""
    inside = np.eye(len(gram)) + gram * np.outer(scatter, scatter)
    return scatter * np.linalg.solve(inside, scatter * score)


def form_error(whole: Fit, mine: Sequence[int], theta: Array) -> float:
    """Share by which an effect's size differs from block to block beyond what noise makes of it.

    Its numbers are scaled together, block by block; the variance of the scale between blocks is estimated by moments
    (DerSimonian and Laird 1986). 0: the formula holds; 1: it changes by as much as it is large.
    """
    sums = whole.linear.absent
    gram = sums.gram.sum(axis=0)
    step = np.zeros(sums.width)
    step[list(mine)] = theta[list(mine)]
    rest = theta - step
    information = gram[:, 1:, 1:] @ step @ step
    pull = (gram[:, 0, 1:] - gram[:, 1:, 1:] @ rest) @ step
    told = information > 1e-9 * max(information.max(initial=0.0), 1e-300)
    if told.sum() < 3:
        return 0.0
    weight, scale = information[told], pull[told] / information[told]
    mean = weight @ scale / weight.sum()
    spread = weight @ (scale - mean) ** 2 - (told.sum() - 1)
    variance = spread / max(weight.sum() - weight @ weight / weight.sum(), 1e-300)
    return float(np.sqrt(max(variance, 0.0)) / max(abs(mean), 1e-12))
