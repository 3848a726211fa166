"""One answer for logs that share a mapping: their conventions are the same, so their evidence is added up.

Where all of them agree by themselves nothing is done. Where some reject what others let pass, all are judged again by
the evidence of all: ten logs of one vehicle do not split into rejected and passed. A log whose channels differ grossly
keeps its own answer: something happened to that one.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Sequence

import numpy as np

from infotraj.checking.conventions import TOLERATED, Verdict, decide, verdict
from infotraj.checking.motion import Judge
from infotraj.checking.readings import Table
from infotraj.checking.sentences import CODES
from infotraj.checking.whole import Check
from infotraj.flight import Flight

# A table of readings takes some ten megabytes; evidence of so many logs decides as well as of all.
MOST = 12


# Times what sensors in order leave: no sum over other logs speaks for such a one.
GROSS = 10.0


def mapping_key(flight: Flight) -> Hashable:
    """What logs have in common that were made by one mapping: its name and version.

    Tables of which nobody says how they were made have nothing in common."""
    if flight.meta.get("mapping") in (None, "flight_table"):
        return str(flight.meta.get("source")), id(flight)
    return str(flight.meta["mapping"]), str(flight.meta.get("mapping_sha256"))


def agreed(checks: Sequence[Check], keys: Sequence[Hashable], again: Callable[[int, Judge], Check]) -> list[Check]:
    """The checks, with one verdict on conventions for all that have the same key. `again(k, judge)` repeats check k."""
    groups: dict[Hashable, list[int]] = defaultdict(list)
    for k, key in enumerate(keys):
        if checks[k].rows:
            groups[key].append(k)
    found = list(checks)
    for members in groups.values():
        if len({_said(checks[k]) for k in members}) < 2:
            continue
        tables: list[Table] = []
        for place in np.unique(np.linspace(0, len(members) - 1, min(MOST, len(members))).round().astype(int)):
            again(members[place], _collecting(tables))
        decision = decide(tables) if tables else None
        for k in members:
            if decision is None and _grossly(checks[k]):
                continue
            found[k] = again(k, lambda table: verdict(table, decision))  # noqa: B023 - called before the next group
    return found


def _said(check: Check) -> frozenset[str]:
    return frozenset(f.code for f in check.findings if f.code in CODES)


def _grossly(check: Check) -> bool:
    rests = [(n, r) for f in check.findings if f.code in CODES for n, r in f.values.items() if n in TOLERATED]
    return any(rest["as_declared"] > GROSS * TOLERATED[name] for name, rest in rests)


def _collecting(tables: list[Table]) -> Judge:
    def judge(table: Table) -> Verdict:
        tables.append(table)
        return verdict(table, None)

    return judge
