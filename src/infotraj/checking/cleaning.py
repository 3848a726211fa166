"""The flight as it may be used: cells that a check found to hold no sample are empty.

Compare, locate and diagnose all take a flight through here, so that they see the same numbers.
"""

from __future__ import annotations

import numpy as np

from infotraj.checking.finding import Finding
from infotraj.checking.voids import Void, emptied
from infotraj.checking.whole import Check
from infotraj.flight import ATTITUDE, POSITION, RATE, VELOCITY, Flight
from infotraj.importing import derive

LONGEST_STEP = 5.0  # usual steps between samples; over a longer one nothing is derived


def cleaned(flight: Flight, check: Check) -> Flight:
    """The flight with empty cells where the check's findings cut, drop or void them, column by column.

    What was derived from cells that are now empty is derived again from the samples that are left. Findings that the
    user accepted leave their cells as they are.
    """
    accepted = {f.code for f in check.findings if getattr(f, "accepted", False)}
    named = {v.code for v in check.voids}
    spans = [_spans(flight, f) for f in check.findings if (f.drop or f.severity == "cut") and f.code not in named]
    return derived_again(emptied(flight, [v for v in [*check.voids, *spans] if v.code not in accepted]), flight)


def derived_again(flight: Flight, before: Flight) -> Flight:
    """`flight` with velocity and rates derived again where they were derived from cells that it lacks and `before` had.

    A difference of held samples is zero but for jumps; between the samples that are left it is a velocity.
    """
    table = {}
    derived = flight.meta.get("derived") or ()
    for columns, source, rule in ((VELOCITY, POSITION, derive.velocity), (RATE, ATTITUDE, derive.rate)):
        if not set(columns) <= set(derived) or not flight.has(*columns, *source):
            continue
        x = flight.get(*source)
        known = np.isfinite(x).all(axis=1)
        lost = np.isfinite(before.get(*source)).all(axis=1) & ~known
        if known.sum() < 3 or not lost.any():
            continue
        usual = float(np.median(np.diff(flight.t[known])))
        new = rule(flight.t, x, LONGEST_STEP * usual)
        # what rests on whole samples stays as the import derived it
        near = np.convolve(lost, np.ones(3), "same") > 0
        table.update(dict(zip(columns, np.where(near[:, None], new, flight.get(*columns)).T, strict=True)))
    return Flight(flight.table.assign(**table), dict(flight.meta)) if table else flight


def _spans(flight: Flight, finding: Finding) -> Void:
    t = flight.t
    rows = np.zeros(len(t), dtype=bool)
    for a, b in finding.spans:
        rows |= (t >= a) & (t <= b)
    return Void(finding.code, finding.channels, t[rows])
