"""Everything that `locate` says of a model on recorded flights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from infotraj.checking.acceptance import accepted_in
from infotraj.comparing.equation_error import AXES, WINDOW, EquationError, ForceFrom, equation_error
from infotraj.comparing.statistics import Statistics, statistics
from infotraj.dynamics.inputs import for_vehicle
from infotraj.flight import Flight
from infotraj.locating.lags import Lags, lags
from infotraj.locating.places import LEAST_EXCESS, Found, Place, find_places, matters
from infotraj.locating.quantities import cannot_name
from infotraj.locating.samples import samples
from infotraj.locating.tree import Leaf, leaves
from infotraj.locating.windows import TimeWindow, worst_windows
from infotraj.models import Model
from infotraj.progress import progress


@dataclass(frozen=True)
class Located:
    """What was found: places, those that account for most of their axis first (log-likelihood gain; axes whose
    prediction is worse than none come last), pairs, windows in time, a tree an axis that has a place, lags, and the
    statistics over all flights and flight by flight. `found` holds the searches themselves, for figures; cannot_name:
    groups of quantities that some flight lacks; accepted: findings about the flights that the user overruled."""

    paths: tuple[str, ...]
    errors: tuple[EquationError, ...]
    places: tuple[Place, ...]
    pairs: tuple[Place, ...]
    windows: tuple[TimeWindow, ...]
    trees: dict[str, list[Leaf]]
    lags: tuple[Lags, ...]
    overall: Statistics
    by_flight: tuple[Statistics, ...]
    found: tuple[Found, ...]
    cannot_name: tuple[str, ...] = ()
    accepted: tuple[dict[str, Any], ...] = ()

    @property
    def offsets(self) -> list[tuple[str, float, float]]:
        """Axes with a constant error everywhere that a place cannot name: (axis, bias, its share of the mean
        square)."""
        s = self.overall
        share = np.square(s.bias) / np.square(s.rmse)
        return [
            (axis, float(s.bias[k]), float(share[k]))
            for k, axis in enumerate(AXES)
            if s.rows[k] and s.floor[k] > 0 and matters(s.bias[k], s.floor[k])
        ]


def locate(
    model: Model,
    flights: Sequence[Flight],
    *,
    rng: np.random.Generator | None = None,
    window: float = WINDOW,
    force_from: ForceFrom = "auto",
    start: float | None = None,
    stop: float | None = None,
    least_excess: float = LEAST_EXCESS,
) -> Located:
    """Where a model fails on recorded flights: in time, in state and input space, by flight and by axis.

    rng: of the resamples (default: seed 0). window (s), force_from, start, stop (s): as in `equation_error`.
    least_excess: squared error, over the floor's square, below which a place does not matter. InputError where a flight
    lacks what the vehicle needs.
    """
    rng = np.random.default_rng(0) if rng is None else rng
    flights = [for_vehicle(f, model.vehicle) for f in flights]
    errors = tuple(
        equation_error(model, f, window=window, force_from=force_from, start=start, stop=stop) for f in flights
    )
    kinds = progress(list(samples(flights, model.vehicle, errors)), "searching, part")
    found = tuple(find_places(s, rng, least_excess=least_excess) for s in kinds)
    overall = statistics(errors)
    worse = overall.worse_than_none
    places = sorted((p for f in found for p in f.places), key=lambda p: (p.axis in worse, -p.gain))
    pairs = sorted((p for f in found for p in f.pairs), key=lambda p: -p.gain)
    trees = {}
    for f in found:
        for axis in dict.fromkeys(p.axis for p in f.places):
            grown = leaves(f.samples, axis)
            if len(grown) > 1:
                trees[axis] = grown
    paths = tuple(str(f.meta.get("source", f"flight {k}")) for k, f in enumerate(flights))
    return Located(
        paths,
        errors,
        tuple(places),
        tuple(pairs),
        tuple(worst_windows(errors)),
        trees,
        tuple(lags(errors)),
        overall,
        tuple(statistics([e]) for e in errors),
        found,
        tuple(dict.fromkeys(g for f in flights for g in cannot_name(f, model.vehicle))),
        tuple(accepted_in(flights)),
    )
