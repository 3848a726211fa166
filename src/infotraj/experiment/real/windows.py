"""The parts of public real flights that are diagnosed: which logs the configuration names, cut to their windows."""

from __future__ import annotations

from pathlib import Path

from infotraj.datasets import location
from infotraj.errors import UsageError, problem
from infotraj.experiment.common.config import ExperimentConfig, RealDiagnosis
from infotraj.experiment.real.flights import data_set
from infotraj.importing import import_log


def chosen(settings: ExperimentConfig, name: str) -> RealDiagnosis:
    """What the configuration diagnoses in the data set of that name. UsageError where it has no such data set."""
    if name not in type(settings.real_flights).model_fields:
        known = " or ".join(type(settings.real_flights).model_fields)
        raise UsageError(problem(f"nothing to diagnose in {name}", known, "Correct the name."))
    return getattr(settings.real_flights, name)


def logs(settings: ExperimentConfig, name: str, folder: str | Path) -> dict[str, Path]:
    """The logs in the data set's folder that the configuration names, by name. UsageError where one is not there."""
    wanted = chosen(settings, name)
    here = {path.stem: path for path in sorted(Path(folder).glob(data_set(name).pattern))}
    missing = [log for log in (*wanted.flights, *wanted.windows) if log not in here]
    if missing:
        what = f"{name} has no log {', '.join(missing)}"
        raise UsageError(problem(what, f"some of {', '.join(here)}", "Correct real_flights in the configuration."))
    return {log: here[log] for log in wanted.flights}


def cut_flights(settings: ExperimentConfig, *, name: str, data_dir: str | Path | None, flights: str | Path) -> None:
    """Imports the logs that the configuration names, cut to their windows, into the folder `flights`."""
    wanted = chosen(settings, name)
    for log, path in logs(settings, name, location.dataset(name, data_dir)).items():
        flight = import_log(path, data_set(name).mapping)
        if log in wanted.windows:
            flight = flight.between(*wanted.windows[log])
        flight.write(Path(flights) / f"{log}.parquet")
        print(f"{log}: {len(flight.t)} rows, {flight.t[0]:.2f} to {flight.t[-1]:.2f} s", flush=True)
