"""What users do today, on runs of the hidden-effect study: named without the truth, given flights and vehicle alone."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from infotraj.errors import InfotrajError
from infotraj.experiment.hidden.baselines import INSTALL, METHODS, Named, methods, named_by_each
from infotraj.flight import read_flight
from infotraj.vehicle import load_vehicle


def name_batch(*, flights: Path, named: Path) -> None:
    """Writes named/run_K.json for every folder flights/run_K: of each way the effects named and seconds of CPU.

    Flights that a way cannot use leave it without a name. Without PySINDy its way is left out, with a line.
    """
    if len(methods()) < len(METHODS):
        print(INSTALL, file=sys.stderr)
    named.mkdir(parents=True, exist_ok=True)
    for run in sorted(flights.glob("run_*")):
        tables = sorted(run.glob("flight_*.parquet"))
        try:
            found = named_by_each(load_vehicle(run / "vehicle.yaml"), [read_flight(path) for path in tables])
        except InfotrajError as error:
            print(f"{run.name}: {error}", file=sys.stderr)
            found = dict.fromkeys(methods(), Named(frozenset(), 0.0))
        said = {way: {"effects": sorted(n.effects), "seconds": n.seconds} for way, n in found.items()}
        (named / f"{run.name}.json").write_text(json.dumps(said))
