"""The commands from Python: `infotraj.compare`, `locate` and `diagnose` take what the commands take, and give objects.

They go through the same door as the commands: a flight that `infotraj check` rejects is an InputError here, and what it
drops is left out. Each result prints as the command does.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from infotraj import comparing
from infotraj.arguments import AnyPath, as_several, is_path, require_part, require_seed
from infotraj.checking.acceptance import accepting
from infotraj.checking.admission import admitted, checked
from infotraj.checking.codes import known
from infotraj.comparing import files
from infotraj.comparing.comparison import Comparison
from infotraj.diagnosis import diagnosis
from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.errors import InputError, UsageError, problem
from infotraj.flight import Flight, read_flight
from infotraj.importing import import_log
from infotraj.locating import locating
from infotraj.locating.healthy import Beside, beside
from infotraj.locating.locating import Located
from infotraj.models import Model, load_model, save_model

__all__ = [
    "Compared",
    "Diagnosed",
    "Placed",
    "compare",
    "diagnose",
    "import_log",
    "load_model",
    "locate",
    "read_flight",
    "save_model",
]

AnyFlight = Flight | AnyPath
AnyModel = Model | AnyPath


@dataclass(frozen=True)
class _Answer:
    """An answer that prints as its command does."""

    def __str__(self) -> str:
        raise NotImplementedError

    def __repr__(self) -> str:
        return str(self)


@dataclass(frozen=True, repr=False)
class Compared(_Answer):
    """Model against measurement. found: the comparison, with the error at every row."""

    found: Comparison

    def __str__(self) -> str:
        from infotraj.comparing import summary

        return summary.as_text(self.found).rstrip("\n")

    def as_dict(self) -> dict[str, Any]:
        """What `infotraj compare --json` writes."""
        from infotraj.comparing import summary

        return summary.as_dict(self.found)


@dataclass(frozen=True, repr=False)
class Placed(_Answer):
    """Where a model fails. found: places, pairs, windows; healthy: the same places on healthy flights, where given."""

    found: Located
    healthy: Beside | None = None

    def __str__(self) -> str:
        from infotraj.locating import summary

        return summary.as_text(self.found, healthy=self.healthy).rstrip("\n")

    def as_dict(self) -> dict[str, Any]:
        """What `infotraj locate --json` writes."""
        from infotraj.locating import summary

        return summary.as_dict(self.found, self.healthy)


@dataclass(frozen=True, repr=False)
class Diagnosed(_Answer):
    """Which effects a model lacks. found: findings with their evidence, doubts, what is left, the fitted model."""

    found: Diagnosis

    def __str__(self) -> str:
        from infotraj.diagnosis.report import summary

        return summary.as_text(self.found).rstrip("\n")

    @property
    def names(self) -> tuple[str, ...]:
        """The effects that are missing; of those that these flights cannot tell apart the simplest."""
        return self.found.supported

    @property
    def model(self) -> Model:
        """The model with them, fitted to the flights (`infotraj.save_model` writes it)."""
        return self.found.model

    @property
    def effects(self) -> pd.DataFrame:
        """An effect of the catalogue a row, by name: verdict, rise (units of the floor), change of the held-out squared
        error with its 95 % interval (low, high), probability, values. NaN where an effect was not fitted."""
        rows = []
        for f in self.found.findings:
            e = f.evidence
            numbers = [np.nan] * 5 if e is None else [e.rise, e.heldout_change, *e.ci95, e.probability]
            rows.append([f.name, f.verdict, *numbers, f.parameters])
        columns = ["effect", "verdict", "rise", "change", "low", "high", "probability", "values"]
        return pd.DataFrame(rows, columns=columns).set_index("effect")

    @property
    def errors(self) -> pd.DataFrame:
        """RMSE of the force (N) and torque (N m) about each axis, fx .. tz: before and after, and the floor of the
        new model."""
        before, after = self.found.before, self.found.after
        parts = {"before": before.rmse, "after": after.rmse, "floor": after.floor}
        return pd.DataFrame(parts, index=pd.Index(["fx", "fy", "fz", "tx", "ty", "tz"], name="axis"))

    def as_dict(self) -> dict[str, Any]:
        """What `infotraj diagnose --json` writes."""
        from infotraj.diagnosis.report import summary

        return summary.as_dict(self.found)


def compare(
    model: AnyModel,
    flights: AnyFlight | Iterable[AnyFlight],
    *,
    against: AnyModel | None = None,
    accept: Sequence[str] = (),
    start: float | None = None,
    stop: float | None = None,
) -> Compared:
    """Compares a model, and another `against` it, with flights.

    model: a model or vehicle file, or what `load_model` made of one. flights: flight tables (paths or Flights), one or
    several. accept: codes of findings of `check` that are overruled. start, stop: s, the part that is used. InputError,
    one line, where a file is not valid or a flight cannot be used.
    """
    models = {"model": _model(model)} | ({} if against is None else {"against": _model(against)})
    used, _ = _admitted(flights, (), models["model"], accept, start, stop)
    return Compared(comparing.compare(models, used, start=start, stop=stop))


def locate(
    model: AnyModel,
    flights: AnyFlight | Iterable[AnyFlight],
    *,
    reference: AnyFlight | Iterable[AnyFlight] = (),
    accept: Sequence[str] = (),
    start: float | None = None,
    stop: float | None = None,
    seed: int = 0,
) -> Placed:
    """Where a model fails. reference: healthy flights, whose errors stand beside; seed: of the resamples.

    The rest, and errors: as in `compare`.
    """
    require_seed(seed)
    loaded = _model(model)
    used, usual = _admitted(flights, reference, loaded, accept, start, stop)
    found = locating.locate(loaded, used, rng=np.random.default_rng(seed), start=start, stop=stop)
    return Placed(found, beside(found, loaded, usual, start=start, stop=stop) if usual else None)


def diagnose(
    model: AnyModel,
    flights: AnyFlight | Iterable[AnyFlight],
    *,
    reference: AnyFlight | Iterable[AnyFlight] = (),
    effects_from: AnyPath | Iterable[AnyPath] = (),
    accept: Sequence[str] = (),
    start: float | None = None,
    stop: float | None = None,
    seed: int = 0,
) -> Diagnosed:
    """Which named physical effects a model lacks on flights, and how sure that is.

    reference: healthy flights of the same vehicle; what is asked then is what changed since them. effects_from: files
    or folders with effects of your own. seed: of the resamples. The rest, and errors: as in `compare`.
    """
    require_seed(seed)
    loaded = _model(model, effects_from)
    used, usual = _admitted(flights, reference, loaded, accept, start, stop)
    found = diagnosis.diagnose(
        loaded, used, effects_from=effects_from, seed=seed, start=start, stop=stop, reference=usual
    )
    return Diagnosed(found)


def _model(model: AnyModel, effects_from: AnyPath | Iterable[AnyPath] = ()) -> Model:
    if isinstance(model, Model):
        return model
    if not is_path(model):
        found = f"a model of type {type(model).__name__}"
        raise UsageError(problem(found, "a path or a Model", "`infotraj.load_model` reads one."))
    return load_model(model, effects_from)


def _admitted(
    flights: AnyFlight | Iterable[AnyFlight],
    reference: AnyFlight | Iterable[AnyFlight],
    model: Model,
    accept: Sequence[str],
    start: float | None,
    stop: float | None,
) -> tuple[list[Flight], list[Flight]]:
    """Flights and healthy ones as they may be used. InputError for the first that may not, and for no flight."""
    require_part(start, stop)
    given, healthy = _given(flights), _given(reference)
    if not given:
        raise InputError(problem("no flight", "one or several", "Does the pattern find files?"))
    codes = as_several("accept", accept, "codes of findings")
    if not all(isinstance(code, str) for code in codes):
        raise UsageError(problem(f"accept={accept!r}", "codes of findings", "Give their names."))
    overruled = known(codes)

    def admit(some: Sequence[Any], seen: dict[str, str]) -> list[Flight]:
        read = [accepting(x if isinstance(x, Flight) else read_flight(x), overruled) for x in some]
        return [admitted(f, c) for f, c in zip(read, checked(read, model.vehicle, start, stop, seen), strict=True)]

    return files.apart(given, healthy, admit)


def _given(flights: AnyFlight | Iterable[AnyFlight]) -> list[Any]:
    """Paths and Flights, of one alone too. InputError for what is neither."""
    alone = isinstance(flights, Flight | pd.DataFrame | dict) or not isinstance(flights, Iterable)
    given: list[Any] = [flights] if alone else as_several("flights", flights, "paths or Flights")
    for one in given:
        if not (isinstance(one, Flight) or is_path(one)):
            table = "`infotraj.flight.Flight(table)` makes one of a table."
            remedy = table if isinstance(one, pd.DataFrame) else "Read it first."
            raise InputError(problem(f"a flight of type {type(one).__name__}", "a path or a Flight", remedy))
    return given
