"""The flight as it may be used: cells that a check found to hold no sample are empty.

Compare, locate and diagnose all take a flight through here, so that they see the same numbers.
"""

from __future__ import annotations

from infotraj.checking.finding import Finding
from infotraj.checking.voids import Void, emptied
from infotraj.checking.whole import Check
from infotraj.flight import Flight


def cleaned(flight: Flight, check: Check) -> Flight:
    """The flight with empty cells where the check's findings cut, drop or void them, column by column.

    What was derived from cells that are now empty is derived again from the samples that are left. Findings that the
    user accepted leave their cells as they are.
    """
    accepted = {f.code for f in check.findings if getattr(f, "accepted", False)}
    voids = [v for v in check.voids if v.code not in accepted]
    voids += [
        _span_void(flight, f) for f in check.findings if f.code not in accepted and (f.drop or f.severity == "cut")
    ]
    return emptied(flight, voids)


def _span_void(flight: Flight, finding: Finding) -> Void:
    t = flight.t
    inside = [(t >= a) & (t <= b) for a, b in finding.spans]
    rows = inside[0] if inside else t < t[0]
    for more in inside[1:]:
        rows = rows | more
    return Void(finding.code, finding.channels, t[rows])
