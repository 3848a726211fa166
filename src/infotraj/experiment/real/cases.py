"""The cases of the table of real flights: which logs of which data sets, what is known of them, and their flights."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import Field, field_validator, model_validator

from infotraj.comparing.equation_error import ForceFrom
from infotraj.datasets.location import find_dataset
from infotraj.errors import InputError, UsageError, problem
from infotraj.experiment.common.patterns import matching
from infotraj.experiment.common.strict_yaml import Strict, read_yaml


class Window(Strict):
    """One log, and the part of it that is used."""

    file: str = Field(description="path inside the data set's folder; #2: the second log of a file with several")
    beside: str | None = Field(None, description="a further table of the same flight")
    start: float | None = Field(None, alias="from", description="s on the log's clock")
    stop: float | None = Field(None, alias="to", description="s on the log's clock")

    @model_validator(mode="after")
    def _ordered(self) -> Window:
        if self.start is not None and self.stop is not None and not self.start < self.stop:
            raise ValueError(f"the window of {self.file} ends before it starts")
        return self

    @property
    def name(self) -> str:
        """The log's name, with the window's start where the log is cut: a log may be used in two parts."""
        stem = Path(self.file).stem.replace("#", "_")
        return stem if self.start is None else f"{stem}_from_{self.start:g}"


class RealCase(Strict):
    """Flights of one vehicle as it was on one day, and what is known of it."""

    name: str = Field(pattern="^[a-z0-9_]+$")
    folder: str = Field(description="the data set's folder under INFOTRAJ_DATA")
    mapping: str | None = Field(None, description="of `infotraj import`; none: recognised by itself")
    model: str = Field(description="model or vehicle file, below config")
    fit: tuple[Window, ...] = Field(min_length=1, description="logs that the diagnosis is given")
    held: tuple[Window, ...] = Field((), description="other logs, on which its model is tested; none: no test")
    force_from: ForceFrom = Field("auto", description="what the force is measured with on the flights held out")
    accept: tuple[str, ...] = Field((), description="findings of `check` that are overruled, for a reason in `known`")
    known: str = Field(description="what is known of the vehicle without this tool")
    must: tuple[tuple[str, ...], ...] = Field((), description="groups of names: of each, one has to be supported")
    numbers: dict[str, float] = Field(
        {}, description="known numbers: effect.parameter, of a vector effect.parameter.place"
    )
    never: tuple[str, ...] = Field((), description="names that would be wrong")
    cannot: str = Field("", description="what these logs cannot answer, and why")

    @field_validator("fit", "held", mode="before")
    @classmethod
    def _plain(cls, logs: Any) -> Any:
        return [{"file": log} if isinstance(log, str) else log for log in logs] if isinstance(logs, Sequence) else logs

    @model_validator(mode="after")
    def _consistent(self) -> RealCase:
        names = [w.name for w in (*self.fit, *self.held)]
        if twice := next((n for n in names if names.count(n) > 1), None):
            raise ValueError(f"{twice} is used twice in {self.name}")
        if both := next((n for group in self.must for n in group if n in self.never), None):
            raise ValueError(f"{both} must and must never be found in {self.name}")
        return self


class RealCases(Strict):
    """All of them."""

    cases: tuple[RealCase, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _named_once(self) -> RealCases:
        names = [c.name for c in self.cases]
        if twice := next((n for n in names if names.count(n) > 1), None):
            raise ValueError(f"two cases are called {twice}")
        return self

    def chosen(self, only: Sequence[str] = ()) -> tuple[RealCase, ...]:
        """The cases whose names match one of the patterns; all without any. UsageError where a pattern matches none."""
        wanted = matching((c.name for c in self.cases), only)
        return tuple(c for c in self.cases if c.name in wanted)

    def get(self, name: str) -> RealCase:
        """The case of that name. UsageError where there is none."""
        found = next((c for c in self.cases if c.name == name), None)
        if found is None:
            known = ", ".join(c.name for c in self.cases)
            raise UsageError(problem(f"no case {name}", f"one of {known}", "Correct the name."))
        return found


def read_cases(path: str | Path) -> RealCases:
    """The file of cases (YAML). UsageError, one line, where it cannot be used."""
    return read_yaml(RealCases, path)


def missing(case: RealCase, data_dir: str | Path | None = None) -> str:
    """Why the case's logs cannot be read on this machine, in one line; empty where all are here."""
    folder = find_dataset(case.folder, data_dir)
    if folder is None:
        return f"data set {case.folder} is not here: set INFOTRAJ_DATA to the folder that holds it"
    files = [f for w in (*case.fit, *case.held) for f in (w.file.split("#")[0], w.beside) if f]
    absent = [f for f in files if not (folder / f).is_file()]
    return f"data set {case.folder} holds no {', '.join(absent)}" if absent else ""


def cut_case(case: RealCase, flights: str | Path, data_dir: str | Path | None = None) -> None:
    """Imports the case's logs, cut to their windows, into the folder `flights`, a Parquet file a window.

    InputError where a log is not here, cannot be imported or holds nothing in its window.
    """
    from infotraj.checking.acceptance import accepting
    from infotraj.importing import import_log  # late: reading cases needs no importer

    if why := missing(case, data_dir):
        raise InputError(f"{case.name}: {why}")
    folder = find_dataset(case.folder, data_dir)
    assert folder is not None
    Path(flights).mkdir(parents=True, exist_ok=True)
    for window in (*case.fit, *case.held):
        beside = () if window.beside is None else (folder / window.beside,)
        flight = import_log(folder / window.file, case.mapping, start=window.start, stop=window.stop, beside=beside)
        accepting(flight, case.accept).write(flight_path(flights, window))
        print(f"{window.name}: {len(flight.t)} rows, {flight.t[0]:.2f} to {flight.t[-1]:.2f} s", flush=True)


def flight_path(flights: str | Path, window: Window) -> Path:
    """Where `cut_case` puts a window's flight table."""
    return Path(flights) / f"{window.name}.parquet"
