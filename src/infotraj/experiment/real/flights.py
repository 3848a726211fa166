"""Public real flights through import, check, compare and locate: tables, figures and sentences for each data set."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from infotraj.checking import check_logs
from infotraj.comparing import compare, parse_horizons
from infotraj.comparing.equation_error import AXES, ForceFrom
from infotraj.comparing.summary import as_dict, as_text
from infotraj.datasets import location
from infotraj.errors import InputError, UsageError, problem
from infotraj.flight import Flight, read_flight
from infotraj.importing import import_log
from infotraj.locating import locating
from infotraj.locating import summary as located_summary
from infotraj.models import load_model
from infotraj.writing import write_text

SHORTEST = 5.0  # s that a log must have left to be used
LEFT_OUT = {"low_flight"}  # findings that are no fault of the log, but of no use here: ground effect in every row
HORIZONS = "1,10,0.5s"


@dataclass(frozen=True)
class DataSet:
    """A public data set: its mapping, which files are logs, its models (the first is asked about), and what the force
    is measured with: NanoBench's onboard channels lag by a time that varies, its motion capture does not."""

    mapping: str
    pattern: str
    models: tuple[str, ...]
    force_from: ForceFrom


DATA_SETS = {
    "nanobench": DataSet(
        "nanobench", "*.parquet", ("models/nanobench.yaml", "vehicles/nanobench_uncalibrated.yaml"), "velocity"
    ),
    "arpl_crazyflie": DataSet("crazyflie", "log*", ("vehicles/crazyflie_arpl.yaml",), "accelerometer"),
}


def data_set(name: str) -> DataSet:
    """The data set of that name. UsageError where there is none."""
    if name not in DATA_SETS:
        raise UsageError(problem(f"no data set {name}", " or ".join(DATA_SETS), "Correct the name."))
    return DATA_SETS[name]


def receive_logs(*, name: str, data_dir: str | Path | None, flights: str | Path, table: str | Path) -> None:
    """Checks every log of a data set and writes the usable ones as flight tables into the folder `flights`.

    table (CSV): a row a log: what `check` made of it, its findings, the part that is used (the longest usable span).
    """
    chosen = data_set(name)
    folder = location.dataset(name, data_dir)
    logs = sorted(folder.glob(chosen.pattern))
    if not logs:
        raise InputError(problem(f"{folder}: no {chosen.pattern}", "the data set's logs", location.how_to_get(name)))
    rows = []
    Path(flights).mkdir(parents=True, exist_ok=True)
    for log, check in zip(logs, check_logs(logs, chosen.mapping), strict=True):
        span = max(check.usable, key=lambda s: s[1] - s[0], default=(0.0, 0.0))
        codes = {f.code for f in check.findings}
        used = check.outcome != "rejected" and span[1] - span[0] >= SHORTEST and not codes & LEFT_OUT
        rows.append(
            {
                "log": log.name,
                "outcome": check.outcome,
                "used": int(used),
                "from": span[0],
                "to": span[1],
                "airborne_seconds": check.airborne_seconds,
                "findings": " ".join(dict.fromkeys(f.code for f in check.findings if f.severity != "note")),
            }
        )
        if used:
            import_log(log, chosen.mapping).between(*span).write(Path(flights) / f"{log.stem}.parquet")
        print(rows[-1], flush=True)
    _write_csv(pd.DataFrame(rows), table)


def compare_flights(
    *, name: str, config: str | Path, flights: str | Path, numbers: str | Path, text: str | Path, figures: str | Path
) -> None:
    """Compares all models of a data set with its flights: JSON, text, and a folder of figures."""
    from infotraj.plots.comparison import comparison_figures  # late: matplotlib

    chosen = data_set(name)
    models = {path: load_model(Path(config) / path) for path in chosen.models}
    found = compare(models, _flights(flights), horizons=parse_horizons(HORIZONS), force_from=chosen.force_from)
    write_text(json.dumps(as_dict(found), indent=2, allow_nan=False) + "\n", numbers)
    write_text(as_text(found, verbose=True), text)
    comparison_figures(found, figures)


def locate_in_flights(
    *, name: str, model: str, config: str | Path, flights: str | Path, numbers: str | Path, text: str | Path,
    figures: str | Path, seed: int = 0,
) -> None:  # fmt: skip
    """Locates where one model of a data set fails: JSON, sentences, and a folder of figures."""
    from infotraj.plots.places import place_figures  # late: matplotlib

    chosen = data_set(name)
    path = next((m for m in chosen.models if Path(m).stem == model), None)
    if path is None:
        raise UsageError(problem(f"no model {model} for {name}", ", ".join(chosen.models), "Correct the name."))
    found = locating.locate(
        load_model(Path(config) / path),
        _flights(flights),
        rng=np.random.default_rng(seed),
        force_from=chosen.force_from,
    )
    write_text(json.dumps(located_summary.as_dict(found), indent=2, allow_nan=False) + "\n", numbers)
    write_text(located_summary.as_text(found, verbose=True), text)
    place_figures(found, figures)


def summarise(*, comparisons: Sequence[Path], places: Sequence[Path], table: str | Path, markdown: str | Path) -> None:
    """One table over data sets and models: RMSE an axis, its ratio to the floor, and the places named first."""
    from infotraj.plots import typeset

    located = {Path(p).parent: json.loads(Path(p).read_text()) for p in places}
    rows = []
    for path in map(Path, comparisons):
        content = json.loads(path.read_text())
        for model in content.get("models", [content]):
            stem = Path(model["model"]).stem
            found = located.get(path.parent / stem, {"places": []})["places"]
            row = {"data_set": path.parent.name, "model": stem, "flights": len(model["flights"])}
            for axis in AXES:
                rmse, floor, explained = (model[key][axis] for key in ("rmse", "floor", "explained"))
                row[f"rmse_{axis}"] = rmse
                row[f"over_floor_{axis}"] = rmse / floor if rmse is not None and floor else None
                row[f"explained_{axis}"] = explained
                row[f"place_{axis}"] = next((p["quantity"] for p in found if p["axis"] == axis), "")
            rows.append(row)
    result = pd.DataFrame(rows)
    _write_csv(result, table)
    header = ["data set", "model", "flights", *AXES]
    cells = [
        [
            str(r["data_set"]),
            str(r["model"]),
            str(r["flights"]),
            *(
                "-"
                if pd.isna(r[f"rmse_{a}"])
                else f"{r[f'rmse_{a}']:.2g} ({r[f'over_floor_{a}']:.1f}): {r[f'place_{a}'] or 'no place'}"
                for a in AXES
            ),
        ]
        for _, r in result.iterrows()
    ]
    write_text(
        "RMSE (N, N m), over the floor, and the quantity that the worst place is named by.\n\n"
        + typeset.markdown(header, cells),
        markdown,
    )


def _flights(folder: str | Path) -> list[Flight]:
    paths = sorted(Path(folder).glob("*.parquet"))
    if not paths:
        raise InputError(problem(f"{folder}: no flight", "flight tables", "Run the check of the data set again."))
    return [read_flight(p) for p in paths]


def _write_csv(table: pd.DataFrame, path: str | Path) -> None:
    write_text(table.to_csv(index=False), path)
