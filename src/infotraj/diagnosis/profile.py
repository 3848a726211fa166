"""The squared error as a function of one column, all others free (variable projection, Golub and Pereyra 1973)."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from infotraj.diagnosis.noise import PRIOR
from infotraj.rotations import Array


class Profile:
    """The profile of the squared error; every (n, 1 + p): the residual, then the other columns.

    left: the squared error without the one column.
    """

    def __init__(self, every: Array) -> None:
        self._residual, self._others = every[:, 0], every[:, 1:]
        gram = self._others.T @ self._others
        self._inverse = np.linalg.inv(gram + np.eye(len(gram)) / PRIOR**2)
        self._along = self._others.T @ self._residual
        self.left = float(self._residual @ self._residual - self._along @ self._inverse @ self._along)

    def gain(self, column: Array) -> tuple[float, float]:
        """What the column takes off the squared error, and how many times it does; 0, 0 where only less than none."""
        cross = self._others.T @ column
        known = self._inverse @ cross
        size = float(column @ column - known @ cross)
        shared = float(column @ self._residual - known @ self._along)
        if shared <= 0 or size <= 1e-9 * float(column @ column):
            return 0.0, 0.0
        return shared**2 / size, shared / size


def gains_within(
    every: Array, time: Array, column: Callable[[int], Array | None]
) -> Callable[[Iterable[int], float], tuple[dict[int, float], float]]:
    """What columns take off the squared error of the first seconds, as `horizons.best_on_grid` asks for it.

    every: as of `Profile`; time (n,): s since the first sample of the flight; column: (n,) of a place, None for none.
    """
    kept: dict[int, Array | None] = {}

    def gains_at(places: Iterable[int], horizon: float) -> tuple[dict[int, float], float]:
        nonlocal kept
        kept = {p: kept[p] if p in kept else column(p) for p in places}
        rows = time <= horizon
        profile = Profile(every[rows])
        found = {p: 0.0 if c is None else profile.gain(c[rows])[0] for p, c in kept.items()}
        return found, (profile.left - max(found.values())) / max(int(rows.sum()), 1)

    return gains_at
