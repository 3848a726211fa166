"""Execution by a vehicle of your own: the workflow hands out a reference and waits for the flight table."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from infotraj.errors import InputError, problem
from infotraj.experiment.delivery import delivered
from infotraj.flight import COMMANDED_WRENCH, POSITION, RATE, Flight, read_flight
from infotraj.trajectories.reference import Reference, read_reference

_COVERED = 0.95  # share of the reference's duration that a flight must hold, so that an aborted one is not learned
_APART = 1.0  # m, mean distance to the reference beyond which it must have been another flight


def receive(*, folder: str | Path, name: str, reference: str | Path, flight: str | Path) -> None:
    """Takes the flight table FOLDER/NAME.parquet or .csv, checks it against its reference and writes it to `flight`.

    InputError, one line, says where to put the flight while it is not there, or what is wrong with it.
    """
    found = delivered(folder, name)
    if len(found) != 1:
        state = "no flight yet" if not found else f"{' and '.join(found)} both exist"
        raise InputError(
            problem(
                f"{reference}: {state}",
                f"its flight table as {Path(folder) / name}.parquet or .csv",
                "Fly the reference, put the table there and run the same command again.",
            )
        )
    table = read_flight(found[0])
    _check(table, read_reference(reference), found[0], reference)
    table.write(flight)


def _check(flight: Flight, asked: Reference, source: str, reference: str | Path) -> None:
    flight.get(*POSITION, *RATE, *COMMANDED_WRENCH)
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
