"""What users do today with the same question: sparse regression of the residual on the catalogue's regressors.

Three ways: stepwise regression with BIC, LASSO, and PySINDy's sequentially thresholded least squares. All get what the
diagnosis gets: the residual of the vehicle file's model and the linearised column of every number of every effect,
each per its usual size. All get the customary preparation: samples joined over 50 ms (means of forces, changes of
rates, which smooths the noise and brings neighbours nearer to independence), and each axis divided by its standard
deviation. An effect is named when any of its columns is kept.
"""

from __future__ import annotations

import importlib.util
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.linear.candidates import candidates
from infotraj.diagnosis.linear.sensitivities import sensitivities
from infotraj.effects import catalogue
from infotraj.errors import UsageError, problem
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

BIN = 0.05  # s
INSTALL = "PySINDy is not installed: pip install -c constraints.txt -e '.[benchmark]'"
_THRESHOLDS = np.geomspace(0.003, 0.5, 20)  # of the residual's standard deviation
_SHRINK = 1e-3  # STLSQ's ridge, of a standardised column's own square
_DEAD = 1e-3  # of a standard deviation: a column whose usual size changes less is dropped, as one would
_RIDGE = 1e-6  # of a column's own square: identical columns (thrust_scale, coaxial_loss) leave the system singular


@dataclass(frozen=True)
class Regression:
    """y (n,) and X (n, p), by flight (n,); names (p,): the effect of each column (`rotor_effectiveness 3` its own)."""

    y: Array
    X: Array
    flight: Array
    names: tuple[str, ...]

    def effects(self, kept: Sequence[int]) -> frozenset[str]:
        """The effects that these columns belong to."""
        return frozenset(self.names[k] for k in kept)


@dataclass(frozen=True)
class Named:
    """What one way names on these flights, and its CPU time (s), the columns included."""

    effects: frozenset[str]
    seconds: float


def regression(vehicle: Vehicle, flights: Sequence[Flight]) -> Regression:
    """The residual of the vehicle file's model on these flights and the columns of the catalogue."""
    known, _ = candidates(catalogue(), vehicle, flights)
    observation = observe(Model(vehicle), flights)
    found = sensitivities(observation, (), known, samples=True)
    # An effect with several linearisations (a cable of several lengths) brings the columns of them all.
    columns = [(choice.candidate.label, c) for choice in found.choices for c in choice.columns]
    order = [0, *(1 + c for _, c in columns)]
    rows, flight = [], []
    for number, (s, parts) in enumerate(zip(observation.samples, found.joint, strict=True)):
        for channel, part in zip(s.channels, parts, strict=True):
            joined = _joined(part[:, :, order], s.times(channel), channel.difference)
            rows.append(joined)
            flight.append(np.full(joined.shape[0], number))
    channels = [c.name for c in observation.samples[0].channels]
    y, X, of_flight = [], [], []
    for k in range(len(channels)):
        part = np.concatenate(rows[k :: len(channels)])
        label = np.concatenate(flight[k :: len(channels)])
        for axis in range(3):
            scaled = part[:, axis] / max(float(np.std(part[:, axis, 0])), 1e-12)
            y.append(scaled[:, 0])
            X.append(scaled[:, 1:])
            of_flight.append(label)
    joined = np.concatenate(X)
    live = np.flatnonzero(np.sqrt(np.mean(joined**2, axis=0)) > _DEAD)
    return Regression(np.concatenate(y), joined[:, live], np.concatenate(of_flight), tuple(columns[k][0] for k in live))


def _joined(samples: Array, times: Array, difference: bool) -> Array:
    """Samples (m, 3, c) over bins of BIN: means of levels, sums of changes."""
    place = np.floor((times - times[0]) / BIN + 1e-9).astype(int)
    starts = np.flatnonzero(np.diff(place, prepend=-1))
    total = np.add.reduceat(samples, starts, axis=0)
    return total if difference else total / np.diff(np.append(starts, len(samples)))[:, None, None]


def stepwise(data: Regression) -> list[int]:
    """Columns of forward-backward selection by BIC, n log(RSS / n) + k log n (Schwarz 1978), one column a step."""
    n, gram, right = len(data.y), data.X.T @ data.X, data.X.T @ data.y
    total = float(data.y @ data.y)

    def bic(columns: list[int]) -> float:
        squares = total
        if columns:
            squares -= float(right[columns] @ _solved(gram, right, columns))
        return n * np.log(max(squares, 1e-300) / n) + len(columns) * np.log(n)

    kept: list[int] = []
    best = bic(kept)
    while True:
        moves = [[*kept, c] for c in range(len(gram)) if c not in kept] + [[k for k in kept if k != c] for c in kept]
        scores = [bic(m) for m in moves]
        place = int(np.argmin(scores))
        if scores[place] >= best - 1e-9:
            return kept
        kept, best = moves[place], scores[place]


def lasso(data: Regression) -> list[int]:
    """Columns of the LASSO (Tibshirani 1996), standardised, its penalty by cross-validation over flights and the
    one-standard-error rule (Hastie, Tibshirani and Friedman 2009, 7.10)."""
    from sklearn.linear_model import lasso_path  # late: 0.4 s

    X = _standardised(data)
    most = float(np.abs(X.T @ data.y).max()) / len(X)
    penalties = most * np.geomspace(1.0, 1e-3, 50)

    def path(rows: NDArray[np.intp]) -> Array:
        A, b = X[rows], data.y[rows]
        return lasso_path(A, b, alphas=penalties, precompute=A.T @ A, Xy=A.T @ b, max_iter=5000, tol=1e-3)[1]

    with warnings.catch_warnings():
        # Columns that copy each other converge slowly at the smallest penalties, which the rule does not choose.
        warnings.simplefilter("ignore")
        errors = np.array(
            [np.mean((data.y[test][:, None] - X[test] @ path(fit)) ** 2, axis=0) for fit, test in _folds(data)]
        )
        found = path(np.arange(len(X)))[:, _one_standard_error(errors)]
    return [int(c) for c in np.flatnonzero(np.abs(found) > 1e-8)]


def sparse(data: Regression) -> list[int]:
    """Columns of PySINDy's STLSQ (Brunton, Proctor and Kutz 2016) with the regressors as its library, its threshold by
    cross-validation over flights and the one-standard-error rule. Columns are standardised.

    UsageError where PySINDy is not installed.
    """
    if importlib.util.find_spec("pysindy") is None:
        raise UsageError(INSTALL)
    from pysindy.optimizers import STLSQ  # late, and for this benchmark only

    X = _standardised(data)

    def coefficients(rows: NDArray[np.intp], threshold: float) -> Array:
        fitted = STLSQ(threshold=threshold, alpha=_SHRINK * len(rows), max_iter=50, unbias=False)
        return np.ravel(fitted.fit(X[rows], data.y[rows, None]).coef_)

    with warnings.catch_warnings():
        # A threshold that removes every column is an answer here, not a fault.
        warnings.simplefilter("ignore")
        # Sparser with a higher threshold: the rule wants the sparse end first.
        thresholds = _THRESHOLDS[::-1]
        errors = np.array(
            [
                [np.mean((data.y[test] - X[test] @ coefficients(fit, h)) ** 2) for h in thresholds]
                for fit, test in _folds(data)
            ]
        )
        found = coefficients(np.arange(len(X)), thresholds[_one_standard_error(errors)])
    return [int(c) for c in np.flatnonzero(np.abs(found) > 1e-12)]


METHODS: dict[str, Callable[[Regression], list[int]]] = {
    "stepwise regression, BIC": stepwise,
    "LASSO": lasso,
    "PySINDy, STLSQ": sparse,
}


def methods() -> dict[str, Callable[[Regression], list[int]]]:
    """The ways that can run here: PySINDy's only where it is installed."""
    present = importlib.util.find_spec("pysindy") is not None
    return {name: method for name, method in METHODS.items() if present or method is not sparse}


def named_by_each(vehicle: Vehicle, flights: Sequence[Flight]) -> dict[str, Named]:
    """What each way names on these flights. InputError where the flights cannot be used."""
    if not flights:
        raise UsageError(problem("no flight", "at least one", "Name flight tables."))
    start = time.process_time()
    data = regression(vehicle, flights)
    prepared = time.process_time() - start
    found = {}
    for name, method in methods().items():
        start = time.process_time()
        kept = method(data)
        found[name] = Named(data.effects(kept), prepared + time.process_time() - start)
    return found


def _solved(gram: Array, right: Array, columns: list[int]) -> Array:
    block = gram[np.ix_(columns, columns)]
    return cho_solve(cho_factor(block + _RIDGE * np.diag(np.diag(block))), right[columns])


def _standardised(data: Regression) -> Array:
    return data.X / np.sqrt(np.mean(data.X**2, axis=0))


def _folds(data: Regression) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Rows to fit and to test, a flight each; of a single flight, its five fifths."""
    label: NDArray = data.flight
    if len(np.unique(label)) == 1:
        label = np.arange(len(label)) * 5 // len(label)
    return [(np.flatnonzero(label != k), np.flatnonzero(label == k)) for k in np.unique(label)]


def _one_standard_error(errors: Array) -> int:
    """The first (sparsest) setting whose mean is within one standard error of the best; errors (folds, settings)."""
    mean = errors.mean(axis=0)
    best = int(np.argmin(mean))
    spread = errors[:, best].std(ddof=1) / np.sqrt(len(errors)) if len(errors) > 1 else 0.0
    return int(np.flatnonzero(mean <= mean[best] + spread)[0])
