"""Execution by a vehicle of your own: the workflow hands out a reference and waits for its flight table or log."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from infotraj.errors import InputError, problem
from infotraj.experiment.paper.delivery import MAPPING, TABLES, delivered
from infotraj.flight import COMMANDED_WRENCH, POSITION, RATE, Flight, read_flight
from infotraj.trajectories.reference import Reference, read_reference

_COVERED = 0.95  # share of the reference's duration that a flight must hold, so that an aborted one is not learned
_APART = 1.0  # m, mean distance to the reference beyond which it must have been another flight


def receive(
    *, folder: str | Path, name: str, reference: str | Path, flight: str | Path, model: str | Path | None = None
) -> None:
    """Takes the flight of FOLDER, checks it against its reference and writes its table to `flight`.

    It is a flight table (NAME.parquet or .csv) or any log that can be imported (NAME.bag, .mcap, .ulg, a bag's folder
    NAME ...), with FOLDER/mapping.yaml where that is there and else the shipped mapping that fits. model: the learned
    model that the controller is to fly with; None: the vehicle's first-principles model alone.

    InputError, one line, says where to put the flight while it is not there, or what is wrong with it.
    """
    found = delivered(folder, name)
    if not found:
        learned = "no learned model" if model is None else f"the learned model {model}"
        raise InputError(
            problem(
                f"{reference}: no flight yet",
                f"its flight table as {Path(folder) / name}.parquet or .csv, or its log under that name",
                f"Fly the reference with {learned} in the controller, put the flight there and run the same command "
                "again.",
            )
        )
    if len(found) > 1:
        raise InputError(
            problem(
                f"{reference}: {len(found)} flights, {' and '.join(found)}",
                f"one file or folder called {name}",
                "Keep the flight of this reference, remove what else has that name, and run the same command again.",
            )
        )
    table = _read(Path(found[0]), Path(folder) / MAPPING)
    _check(table, read_reference(reference), found[0], reference)
    table.write(flight)


def _read(path: Path, mapping: Path) -> Flight:
    if path.suffix in TABLES and not mapping.is_file():
        return read_flight(path)
    from infotraj.importing import import_log, load_mapping  # late: rosbags, pyulog

    return import_log(path, load_mapping(str(mapping)) if mapping.is_file() else None)


def _check(flight: Flight, asked: Reference, source: str, reference: str | Path) -> None:
    # a log of actuator commands alone will do: the declared response makes the wrench from them
    commands = () if flight.has("cmd_rotor_0") and not flight.has(*COMMANDED_WRENCH) else COMMANDED_WRENCH
    flight.get(*POSITION, *RATE, *commands)
    lasts, wanted = flight.t[-1] - flight.t[0], asked.t[-1] - asked.t[0]
    if lasts < _COVERED * wanted:
        raise InputError(
            problem(f"{source}: lasts {lasts:.2f} s", f"the {wanted:.2f} s of {reference}", "Fly it to its end.")
        )
    flown = flight.get(*POSITION)
    rows = np.clip(np.searchsorted(asked.t - asked.t[0], flight.t - flight.t[0]), 0, len(asked.t) - 1)
    apart = float(np.nanmean(np.linalg.norm(flown - asked.position[rows], axis=1)))
    if not apart <= _APART:
        raise InputError(
            problem(
                f"{source}: {apart:.1f} m from {reference} in the mean",
                f"at most {_APART:g} m",
                "Check that it is the flight of this reference, in the same world frame.",
            )
        )
