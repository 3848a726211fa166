"""Cells that hold no sample: which columns at which times, and the finding that says so."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from infotraj.flight import Flight
from infotraj.rotations import Array


@dataclass(frozen=True)
class Void:
    """At `times` (m,) s the `columns` hold no sample; `code` is that of the finding that says why."""

    code: str
    columns: tuple[str, ...]
    times: Array


def emptied(flight: Flight, voids: Iterable[Void]) -> Flight:
    """The flight with these cells empty; columns that it does not have are passed over."""
    table = flight.table.copy()
    t = flight.t
    for void in voids:
        columns = [c for c in void.columns if c in table and c not in ("t", "airborne")]
        if columns and len(void.times):
            # A column of whole numbers cannot hold an empty cell.
            table[columns] = table[columns].astype(float)
            table.loc[np.isin(t, void.times), columns] = np.nan
    return Flight(table, dict(flight.meta))
