"""Public real flights through diagnose and add: verdicts, figure, model, error on other flights, and named models."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from infotraj.comparing.equation_error import AXES
from infotraj.comparing.files import write_json
from infotraj.comparing.statistics import Statistics
from infotraj.diagnosis.adding import add
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.gates import refusal
from infotraj.diagnosis.gates.premises import examined
from infotraj.diagnosis.judge.verdicts import Finding
from infotraj.diagnosis.report import summary
from infotraj.diagnosis.report.saving import save_diagnosed
from infotraj.diagnosis.report.steps import steps
from infotraj.evaluation.lateral_error import lateral_error
from infotraj.experiment.common.config import ExperimentConfig
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.real.windows import chosen
from infotraj.flight import Flight, read_flight
from infotraj.models import Model, load_model
from infotraj.models.file import read_model
from infotraj.vehicle import Vehicle
from infotraj.writing import write_text

NOTHING = "nothing"
JOINED = "+"  # between the names of effects that are added together


def diagnose_flights(
    settings: ExperimentConfig, *, name: str, config: str | Path, flights: str | Path, numbers: str | Path,
    text: str | Path, table: str | Path, model: str | Path, png: str | Path, pdf: str | Path, seed: int = 0,
) -> None:  # fmt: skip
    """Diagnoses the data set's model on the flights to fit, as `infotraj diagnose` does.

    numbers: its JSON; text: its table and what the search did; table (CSV): a row an effect; model: with the supported
    effects; png, pdf: the waterfall.
    """
    from infotraj.plots.waterfall import waterfall  # late: matplotlib

    wanted = chosen(settings, name)
    parent = Path(config) / wanted.model
    began = time.process_time()
    given, content = read_model(parent)
    used = _read(flights, wanted.fit, given.vehicle)
    found = diagnose(given, used, seed=seed)
    write_json(summary.as_dict(found), Path(numbers))
    write_text(summary.as_text(found, verbose=True) + "\nThe search:\n" + "\n".join(found.search.trail) + "\n", text)
    write_table(pd.DataFrame([{"data_set": name} | _verdict(f) for f in found.findings]), table)
    save_diagnosed(found, Path(model), parent=parent, content=content, flights=used)
    fall = steps(found, seed=seed)
    drawn = (fall.labels, fall.axes, fall.rmse, fall.low, fall.high, fall.floor, fall.unit)
    waterfall(*drawn, Path(png), Path(pdf), refused=found.refused)
    print(f"{time.process_time() - began:.1f} s of CPU for the diagnosis and its figure", flush=True)


def score_held_out(
    settings: ExperimentConfig, *, name: str, config: str | Path, flights: str | Path, model: str | Path,
    table: str | Path,
) -> None:  # fmt: skip
    """Lateral RMSE (m/s^2, see `evaluation.lateral_error`) on the held-out flights, model as given and as diagnosed.

    table (CSV): a row a flight and a way to measure the force, x and y together; the row `all` is over all flights.
    """
    wanted = chosen(settings, name)
    models = {"before": load_model(Path(config) / wanted.model), "after": load_model(model)}
    used = _read(flights, wanted.held_out, models["before"].vehicle)
    rows = []
    for source in ("accelerometer", "velocity"):
        found = {when: lateral_error(m, used, source) for when, m in models.items()}
        each = {when: np.sqrt(np.mean(np.square(e.rms), axis=1)) for when, e in found.items()}
        for k, flight in enumerate(wanted.held_out):
            rows.append([name, source, flight, each["before"][k], each["after"][k]])
        rows.append([name, source, "all", found["before"].rmse, found["after"].rmse])
    write_table(pd.DataFrame(rows, columns=["data_set", "force_from", "flight", "before", "after"]), table)


def add_named(
    settings: ExperimentConfig, *, name: str, config: str | Path, flights: str | Path, table: str | Path
) -> None:
    """Adds what the configuration names to the data set's model, each fitted to the flights, as `infotraj add` does.

    table (CSV): a row each, the first without any: time constant of the rotors (s) and moments of inertia (kg m^2) with
    standard errors, which parameters ended at a bound, RMSE an axis (N, N m).
    """
    wanted = chosen(settings, name)
    given = load_model(Path(config) / wanted.model)
    used = _read(flights, wanted.fit, given.vehicle)
    before = refusal.errors(given, used, None, None)
    rows = [_added(NOTHING, given, [{} for _ in given.effects], before, ())]
    for names in wanted.add:
        made = add(given, names.split(JOINED), used)
        rows.append(_added(names, made.model, made.errors, made.after, made.ended))
        print(f"{names}\n{made.as_text()}", flush=True)
    write_table(pd.DataFrame([{"data_set": name} | row for row in rows]), table)


def _read(folder: str | Path, names: Sequence[str], vehicle: Vehicle) -> list[Flight]:
    return [examined(read_flight(Path(folder) / f"{name}.parquet"), vehicle) for name in names]


def _verdict(f: Finding) -> dict[str, Any]:
    e = f.evidence
    return {
        "effect": f.name,
        "verdict": f.verdict,
        "group": JOINED.join(f.group) if len(f.group) > 1 else "",
        "rise": e.rise if e else np.nan,
        "axis": e.axis if e else "",
        "heldout_change": e.heldout_change if e else np.nan,
        "low": e.ci95[0] if e else np.nan,
        "high": e.ci95[1] if e else np.nan,
        "better": "{}/{}".format(*e.flights_better) if e else "",
        "selected": e.selected if e else np.nan,
        "parameters": json.dumps(f.parameters),
        "standard_errors": json.dumps(f.standard_errors),
        "further_instances": json.dumps([v for v in f.instances if v != f.parameters]),
        "reason": f.reason,
    }


def _added(
    names: str, model: Model, errors: Iterable[dict[str, Any]], after: Statistics, ended: Iterable[str]
) -> dict[str, Any]:
    vehicle = model.vehicle
    declared = float(np.mean([rotor.time_constant for rotor in vehicle.rotors]))
    row: dict[str, Any] = {"effects": names, "time_constant": declared, "time_constant_error": np.nan}
    for i, axis in enumerate(("xx", "yy", "zz")):
        row |= {f"J_{axis}": vehicle.inertia_matrix()[i, i], f"J_{axis}_error": np.nan}
    for effect, error in zip(model.effects, errors, strict=True):
        places = {"extra_time_constant": "time_constant"} | {f"d{a}": f"J_{a}" for a in ("xx", "yy", "zz")}
        for parameter, column in places.items():
            if effect.name in ("rotor_lag", "inertia_error") and parameter in effect.values:
                row[column] += effect.values[parameter]
                row[f"{column}_error"] = error.get(parameter, np.nan)
    row["at_bound"] = " ".join(sorted(ended))
    return row | {f"rmse_{a}": float(v) for a, v in zip(AXES, after.rmse, strict=True)}
