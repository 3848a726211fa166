"""What `check` says about one log of the corpus: whole, in segments, and with known errors put in."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from time import process_time
from typing import Any

import numpy as np

from infotraj.checking import Check, Finding, Loaded, examine
from infotraj.errors import InfotrajError, InputError
from infotraj.experiment.corpus.injected_errors import INJECTED
from infotraj.experiment.corpus.recipes import Log, Recipe, injected
from infotraj.flight import Flight

SEGMENT = 10.0  # s
SPOILED_SECONDS = 14.0  # s of flight that errors are put into
Row = dict[str, Any]


def judge(recipe: Recipe, base_seed: int, spoil: bool) -> list[Row]:
    """A row a verdict: part `whole`, `segment`, `injected` (where asked for, and the log moves), or `unreadable`."""
    try:
        log = recipe.make()
    except InfotrajError as error:
        # where the data sets lie is nobody's business
        path = getattr(recipe, "path", None)
        why = " ".join(str(error).split())
        name, why = (path.name, why.replace(f"{path}: ", "")) if path else (str(recipe), why)
        return [{"source": recipe.source, "log": name, "part": "unreadable", "why": why}]
    rows = [_row(log, "whole", log.loaded)]
    rows += [_row(log, "segment", piece) for piece in segments(log.loaded)]
    if spoil and log.moving:
        rows += [_injected_row(name, spoiled) for name, spoiled in injected(_shortened(log), base_seed)]
    return rows


def segments(loaded: Loaded) -> Iterator[Loaded]:
    """Pieces of 10 s of the flown part, with what the streams beside the table hold of them."""
    start, stop = _flown(loaded.flight)
    for at in np.arange(start + 1.0, stop - SEGMENT - 1.0, SEGMENT):
        until = at + SEGMENT
        if np.count_nonzero((loaded.flight.t >= at) & (loaded.flight.t < until)) < 2:
            continue  # a gap as long as the segment
        beside = []
        for other in loaded.beside:
            inside = (other.t >= at) & (other.t < until)
            beside.append(replace(other, t=other.t[inside], values=other.values[inside]))
        yield Loaded(loaded.flight.between(at, until), beside)


def _flown(flight: Flight) -> tuple[float, float]:
    """When it is first and last 0.3 m above its lowest place; without a position, when commands are above half of
    their usual size."""
    t = flight.t
    if flight.has("pz"):
        height = flight.get("pz")[:, 0]
        # by far the most of a log is right: a few spikes do not make its ground
        up = height > np.nanquantile(height, 0.01) + 0.3
    elif flight.has("cmd_rotor_0"):
        command = np.abs(flight.numbered("cmd_rotor_")).mean(axis=1)
        up = command > 0.5 * np.nanquantile(command, 0.75)
    else:
        return float(t[0]), float(t[-1])
    if up.mean() < 0.3:
        # in the air from the first row on, or hardly ever: all of it
        return float(t[0]), float(t[-1])
    rows = np.flatnonzero(up)
    return float(t[rows[0]]), float(t[rows[-1]])


def _shortened(log: Log) -> Log:
    # from 2 s before the flown part: as telling as the whole, in half the time
    start, stop = _flown(log.flight)
    return replace(log, loaded=Loaded(log.flight.between(start - 2.0, min(stop, start + SPOILED_SECONDS))))


def _row(log: Log, part: str, loaded: Loaded) -> Row:
    began = process_time()
    check = _checked(loaded, log)
    false = [f for f in check.findings if f.severity != "note" and not any(r.covers(f) for r in log.right)]
    right = [f.code for f in check.findings if f.severity != "note" and f not in false]
    return {
        "source": log.source,
        "kind": log.kind,
        "log": log.name,
        "part": part,
        "from": round(float(loaded.flight.t[0]), 3),
        "outcome": check.outcome,
        "false": [_said(f) for f in false],
        "right": right,
        "seconds": round(process_time() - began, 2),
    }


def _injected_row(name: str, log: Log) -> Row:
    began = process_time()
    row = {"source": log.source, "kind": log.kind, "log": log.name, "part": "injected", "error": name}
    check = _checked(log.loaded, log)
    said = [f.code for f in check.findings if f.severity != "note"]
    found = INJECTED[name].found(check, log.spoiled)
    return {**row, "found": found, "said": said, "seconds": round(process_time() - began, 2)}


def _checked(loaded: Loaded, log: Log) -> Check:
    # a log that check refuses is rejected as well; a crash is the worst of refusals, and no reason to stop the rest
    try:
        return examine(loaded, log.vehicle)
    except InputError as error:
        code, what = "refused", " ".join(str(error).split())
    except Exception as error:
        code, what = "crashed", f"{type(error).__name__}: {error}"
    t = loaded.flight.t
    finding = Finding(code, "reject", what, "no answer", "mend check")
    return Check(log.name, len(t), float(t[0]), float(t[-1]), 0.0, 0.0, "not looked at", [finding], [])


def _said(finding: Finding) -> dict[str, str]:
    return {"code": finding.code, "severity": finding.severity, "what": finding.what}
