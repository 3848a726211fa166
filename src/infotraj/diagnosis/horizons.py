"""The best number of what swings along a flight, over a horizon that extends.

A swing runs out of step with one of another length within seconds: over whole flights the squared error has a valley of
a few thousandths of the length, local minima beside it, and is the less smooth the longer they last (Ribeiro et al.,
"On the smoothness of nonlinear system identification", Automatica 2020). Over their first seconds alone the valley is
wide. So the number is looked for on a grid over these first, and the horizon is doubled as the grid is halved about
what is still possible (an extending horizon: Beno, Pachner and Havlena, SYSID 2012).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from infotraj.diagnosis.candidates import Place
from infotraj.rotations import Array

_HORIZON = 2.0  # s of every flight, at first
_GRID = 0.1  # relative step of the first grid
_HALVINGS = 8
_BEYOND = 4.0
_CLOSE = 20.0  # squared error, times what is left a sample, by which a possible number is worse than the best
_KEPT = (3, 12)  # numbers that stay possible, at least and at most


def grid(place: Place, starts: Sequence[float]) -> Array:
    """All numbers that `best_on_grid` may ask for, evenly in their logarithm: within the bounds of a fitted number.

    Where a bound is not positive or not finite, `starts` times (or over) _BEYOND.
    """
    low = place.low if place.low > 0 else min(starts) / _BEYOND
    high = place.high if np.isfinite(place.high) else max(starts) * _BEYOND
    return np.geomspace(low, high, math.ceil(math.log(high / low) / _GRID) * 2**_HALVINGS + 1)


def best_on_grid(count: int, gains_at: Callable[[Iterable[int], float], tuple[dict[int, float], float]]) -> int | None:
    """The place of the best of `count` numbers of a `grid`, None where none takes anything off.

    gains_at: what the numbers at these places take off the squared error of the flights' first seconds, so many of
    them, and what is left a sample there.
    """
    least, most = _KEPT
    horizon = _HORIZON
    places: Iterable[int] = range(0, count, 2**_HALVINGS)
    gains, left = gains_at(places, horizon)
    for halving in range(_HALVINGS):
        ordered = sorted(gains, key=lambda p: -gains[p])
        possible = gains[ordered[0]] - _CLOSE * max(1.0, left)
        kept = [p for i, p in enumerate(ordered[:most]) if i < least or gains[p] > possible]
        half = 2 ** (_HALVINGS - halving - 1)
        places = {q for p in kept for q in (p - half, p, p + half) if 0 <= q < count}
        gains, left = gains_at(places, horizon)
        longer, left_longer = gains_at(places, 2 * horizon)
        # Where more time explains less, noise of the motion has moved the swing too far for any number to predict it.
        if max(longer.values()) >= max(gains.values()):
            gains, left, horizon = longer, left_longer, 2 * horizon
    best = max(gains, key=lambda p: gains[p])
    return best if gains[best] > 0.0 else None
