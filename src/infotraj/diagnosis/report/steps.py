"""How the error falls on flights that were not fitted, effect by effect: what the waterfall shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from infotraj.comparing.equation_error import AXES, EquationError, equation_error
from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.diagnosis.judge.evidence import resampled
from infotraj.progress import progress
from infotraj.rotations import Array


@dataclass(frozen=True)
class Steps:
    """labels (m,): the model as given, then each effect added; rmse (m, 6); low, high (m, 6): 95 %; floor (6,): with
    all of them.

    unit: of force and of torque; axes: their names.
    """

    labels: tuple[str, ...]
    rmse: Array
    low: Array
    high: Array
    floor: Array
    unit: dict[str, str]
    axes: tuple[str, ...] = AXES


@dataclass(frozen=True)
class HeldOut:
    """Equation errors of the flights, each stretch under numbers that were fitted without it.

    errors: one a flight; squares, rows (blocks, 6): squared error and how many rows it is of; flight (blocks,).
    """

    errors: tuple[EquationError, ...]
    squares: Array
    rows: Array
    flight: NDArray

    @property
    def rmse(self) -> Array:
        """Over all flights (6,), NaN for an axis without a row."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.sqrt(self.squares.sum(axis=0) / self.rows.sum(axis=0))

    def interval(self, rng: np.random.Generator) -> tuple[Array, Array]:
        """95 % of the error (6,), low and high, where stretches of the flights are resampled."""
        draws = resampled(self.flight, rng)
        with np.errstate(invalid="ignore", divide="ignore"):
            spread = np.sqrt((draws @ self.squares) / (draws @ self.rows))
        return np.quantile(spread, 0.025, axis=0), np.quantile(spread, 0.975, axis=0)


def steps(found: Diagnosis, seed: int = 0) -> Steps:
    """Equation error on held-out flights after each supported effect, what matters most first; the file comes last.

    The numbers of each step are fitted on the other folds (linearised at the fit to all), so no flight judges its own.
    """
    groups = given_groups(found)
    rng = np.random.default_rng(seed)
    so_far = [[x for group in groups[:k] for x in group] for k in range(len(groups) + 1)]
    made = [held_out(found, labels) for labels in progress(so_far, "computing step")]
    low, high = zip(*(m.interval(rng) for m in made), strict=True)
    return Steps(
        said([called(found, group) for group in groups]),
        np.array([m.rmse for m in made]),
        np.array(low),
        np.array(high),
        found.after.floor,
        made[-1].errors[-1].unit,
    )


def floors(found: Diagnosis) -> Array:
    """What noise of the sensors leaves with everything that is supported, flight by flight (flights, 6).

    Where noise is not white, a floor is what changes fast and is not explained: it depends on the model.
    """
    flights = [s.flight for s in found.samples]
    return np.array([equation_error(found.model, f, start=found.start, stop=found.stop).floor for f in flights])


def given_groups(found: Diagnosis) -> list[tuple[str, ...]]:
    """Labels of the model that is given: each effect that is named with confidence, what matters most first, then all
    that corrects the file beside them, which was fitted together."""
    rise = {f.name: f.evidence.rise for f in found.findings if f.evidence is not None}
    beside = tuple(x for x in found.final.labels if x in found.beside)
    labels = [x for x in found.final.labels if x not in beside and x.split()[0] in found.supported]
    named: list[tuple[str, ...]] = [(x,) for x in sorted(labels, key=lambda x: -rise.get(x.split()[0], 0.0))]
    return [*named, beside] if beside else named


def called(found: Diagnosis, group: Sequence[str]) -> str:
    """Effects for a picture, or that they correct the file."""
    if group[0] in found.beside:
        return "the file corrected"
    return " and ".join(x.replace("_", " ") for x in group)


def said(labels: Sequence[str]) -> tuple[str, ...]:
    """What the steps are called: the model as given, then each effect."""
    return ("as given", *(f"+ {label}" for label in labels))


def held_out(found: Diagnosis, labels: Sequence[str]) -> HeldOut:
    """The errors with these effects of the model that is given (see `given_groups`), by blocks of the flights."""
    made = found.final
    linear = made.linear
    cut = linear.observation.blocks
    chosen = linear.labelled(list(labels))
    refitted = made.scorer.solution(made.chosen)
    # Numbers that stay as they were found beside the file's own errors stay so in every step.
    solution = made.scorer.solution(chosen) if np.allclose(refitted.theta, made.solution.theta) else made.solution
    folds = np.unique(cut.fold)
    given = [linear.members(chosen, theta, np.inf) for theta in solution.each]
    squares, rows = np.zeros((len(cut.flight), 6)), np.zeros((len(cut.flight), 6))
    errors = []
    for number, s in enumerate(linear.observation.samples):
        place = cut.at(number, s.flight.t)
        whole: EquationError | None = None
        for f in np.unique(cut.fold[cut.flight == number]):
            members = given[int(np.searchsorted(folds, f))]
            error = equation_error(linear.observation.model(members), s.flight, start=found.start, stop=found.stop)
            own = (cut.fold[place] == f)[:, None]
            if whole is None:
                whole = error
            else:
                measured = np.where(own, error.measured, whole.measured)
                whole = replace(whole, measured=measured, predicted=np.where(own, error.predicted, whole.predicted))
        assert whole is not None
        squared = np.where(whole.scored, whole.residual, 0.0) ** 2
        for b in np.flatnonzero(cut.flight == number):
            squares[b] = squared[place == b].sum(axis=0)
            rows[b] = whole.scored[place == b].sum(axis=0)
        errors.append(whole)
    return HeldOut(tuple(errors), squares, rows, cut.flight)
