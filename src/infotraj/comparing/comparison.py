"""Models against flights: every equation error and rollout, and what they come to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from infotraj.comparing.equation_error import WINDOW, EquationError, ForceFrom, equation_error
from infotraj.comparing.rollouts import Horizon, Rollouts, rollouts
from infotraj.comparing.statistics import Difference, Statistics, difference, statistics
from infotraj.flight import Flight
from infotraj.models import Model


@dataclass(frozen=True)
class Compared:
    """One model on all flights: its name, an EquationError and (where asked for) Rollouts a flight."""

    name: str
    model: Model
    errors: tuple[EquationError, ...]
    rollouts: tuple[Rollouts, ...]

    @property
    def overall(self) -> Statistics:
        """Over all flights together."""
        return statistics(self.errors)

    def of_flight(self, k: int) -> Statistics:
        """Over one flight."""
        return statistics(self.errors[k : k + 1])


@dataclass(frozen=True)
class Comparison:
    """One or several models on the same flights; the first one is the one that is asked about."""

    paths: tuple[str, ...]
    flights: tuple[Flight, ...]
    models: tuple[Compared, ...]

    def differences(self) -> tuple[Difference, ...]:
        """Each further model against the first one."""
        return tuple(difference(m.errors, self.models[0].errors) for m in self.models[1:])


def compare(
    models: dict[str, Model] | Model,
    flights: Sequence[Flight],
    *,
    horizons: Sequence[Horizon] = (),
    window: float = WINDOW,
    force_from: ForceFrom = "auto",
    start: float | None = None,
    stop: float | None = None,
) -> Comparison:
    """Compares one or several models with recorded flights.

    models: a model, or models by name; the errors of all are in the scale of the first one's mass and inertia.
    horizons: of rollouts, none without (see `parse_horizons`). window (s), force_from, start, stop (s): as in
    `equation_error`. InputError where a flight lacks what the vehicle needs.
    """
    named = {"model": models} if isinstance(models, Model) else models
    found: list[Compared] = []
    scale = next(iter(named.values())).vehicle
    for name, model in named.items():
        errors = tuple(
            equation_error(model, f, window=window, force_from=force_from, start=start, stop=stop, scale=scale)
            for f in flights
        )
        rolled = tuple(rollouts(model, f, horizons, start=start, stop=stop) for f in flights) if horizons else ()
        found.append(Compared(name, model, errors, rolled))
    paths = tuple(str(f.meta.get("source", f"flight {k}")) for k, f in enumerate(flights))
    return Comparison(tuple(str(Path(p)) for p in paths), tuple(flights), tuple(found))
