"""The baselines on folders of flights, and their score against a table of truths that only the scoring reads."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from infotraj.errors import InputError, problem
from infotraj.experiment.baselines import INSTALL, METHODS, methods, named_by_each
from infotraj.experiment.tables import write_table
from infotraj.flight import read_flight
from infotraj.vehicle import load_vehicle

JOIN = "+"


def name_flights(*, vehicle: str | Path, case: str, flights: Sequence[str | Path], table: str | Path) -> None:
    """Writes a row each way for one set of flights: case, method, effects (joined by +) and seconds."""
    if len(methods()) < len(METHODS):
        print(INSTALL, file=sys.stderr)
    found = named_by_each(load_vehicle(vehicle), [read_flight(path) for path in flights])
    rows = [
        {"case": case, "method": name, "effects": JOIN.join(sorted(n.effects)), "seconds": n.seconds}
        for name, n in found.items()
    ]
    write_table(pd.DataFrame(rows), table)


def score(*, tables: Sequence[str | Path], truths: str | Path, table: str | Path, markdown: str | Path) -> None:
    """Writes found, invented and time of each method: a row a method, and the same as Markdown.

    truths (CSV): case and effects, joined by + and empty for nothing. A run is `found` where every true effect is named
    and `exact` where nothing else is; `false_alarms` is the share of runs with an invented effect, `invented` the
    number of them a run. InputError where a case has no truth.
    """
    from infotraj.plots import typeset  # late: matplotlib

    runs = pd.concat([pd.read_csv(path, keep_default_na=False) for path in tables], ignore_index=True)
    known = pd.read_csv(truths, keep_default_na=False).set_index("case")["effects"]
    missing = sorted(set(runs["case"]) - set(known.index))
    if missing:
        raise InputError(problem(f"{truths}: no truth for {missing[0]}", "a row a case", "Add it."))
    true = [_split(known[case]) for case in runs["case"]]
    named = [_split(effects) for effects in runs["effects"]]
    runs["found"] = [t <= n for t, n in zip(true, named, strict=True)]
    runs["exact"] = [t == n for t, n in zip(true, named, strict=True)]
    runs["invented"] = [len(n - t) for t, n in zip(true, named, strict=True)]
    runs["false_alarms"] = runs["invented"] > 0
    scored = runs.groupby("method", sort=False)[["found", "exact", "false_alarms", "invented", "seconds"]].mean()
    scored.insert(0, "runs", runs.groupby("method", sort=False).size())
    write_table(scored.reset_index(), table)
    cells = [
        [
            str(method), str(int(r["runs"])), f"{r['found']:.0%}", f"{r['exact']:.0%}", f"{r['false_alarms']:.0%}",
            f"{r['invented']:.1f}", f"{r['seconds']:.1f} s",
        ]
        for method, r in scored.iterrows()
    ]  # fmt: skip
    header = ["method", "runs", "found", "found and nothing else", "false alarms", "invented a run", "time"]
    path = Path(markdown)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(typeset.markdown(header, cells))


def _split(effects: str) -> frozenset[str]:
    return frozenset(effects.split(JOIN)) if effects else frozenset()
