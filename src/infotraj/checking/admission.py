"""One door for every command that uses flights: what `check` rejects is refused, what it drops is empty."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import pandas as pd

from infotraj.checking.acceptance import ACCEPT, ACCEPTED, accepted_codes, marked, with_accepted
from infotraj.checking.cleaning import cleaned
from infotraj.checking.codes import NEVER
from infotraj.checking.finding import Finding, usable_spans
from infotraj.checking.identical import content_hash, copy_finding, own_reference
from infotraj.checking.pooled import agreed, mapping_key
from infotraj.checking.remembered import remembered
from infotraj.checking.settings import of_log, remedy_of
from infotraj.checking.whole import Check, examine
from infotraj.errors import InputError, problem
from infotraj.flight import Flight
from infotraj.progress import progress
from infotraj.vehicle import Vehicle


def checked(
    flights: Sequence[Flight],
    vehicle: Vehicle,
    start: float | None = None,
    stop: float | None = None,
    seen: dict[str, str] | None = None,
) -> list[Check]:
    """The checks of flight tables that are to be used together, in order, copies among them found.

    start, stop: s, the part that is used, and the only one that is looked at. InputError where it holds no rows. seen:
    as in `with_copies`. What was checked before is remembered (see `remembered`).
    """
    parts = [_plain(part(f, start, stop)) for f in flights]
    keys = [_key(f, vehicle) for f in parts]
    both = list(zip(keys, parts, strict=True))
    checks = [remembered(key, partial(examine, f, vehicle)) for key, f in progress(both, "checking flight")]
    if len(parts) > 1:
        checks = remembered(
            ("together", *keys),
            lambda: agreed(checks, [mapping_key(f) for f in parts], lambda k, judge: examine(parts[k], vehicle, judge)),
        )
    return with_copies(flights, [_overruled(c, f) for c, f in zip(checks, flights, strict=True)], seen)


def _plain(flight: Flight) -> Flight:
    """The flight without what its user says of its findings: they are marked when they are known."""
    return Flight(flight.table, {k: v for k, v in flight.meta.items() if k not in (ACCEPT, ACCEPTED)})


def _key(flight: Flight, vehicle: Vehicle) -> tuple[Any, ...]:
    rows = pd.util.hash_pandas_object(flight.table, index=False).to_numpy().tobytes()
    content = hashlib.sha256(rows).hexdigest()
    # Not where the flight lies: neither what is found nor how is said by its path.
    meta = {k: v for k, v in flight.meta.items() if k != "source"}
    return content, list(flight.table.columns), meta, vehicle.model_dump_json()


def _overruled(check: Check, flight: Flight) -> Check:
    findings = marked(check.findings, accepted_codes(flight))
    usable = usable_spans(check.start, check.stop, findings)
    return replace(check, source=str(flight.meta.get("source", "flight")), findings=findings, usable=usable)


def with_copies(flights: Sequence[Flight], checks: Sequence[Check], seen: dict[str, str] | None = None) -> list[Check]:
    """The checks, those of copies of an earlier flight with the finding that says so.

    seen: flights in question, name by hash of the content, where these are their reference; these are added to it.
    """
    seen = {} if seen is None else seen
    asked = dict(seen)
    found = []
    for flight, check in zip(flights, checks, strict=True):
        source, numbers = str(flight.meta.get("source", "flight")), content_hash(flight)
        again = [copy_finding(seen[numbers], same_bytes=False)] if numbers in seen else []
        again = [own_reference(asked[numbers])] if numbers in asked else again
        found.append(beside(check, again, flight))
        seen.setdefault(numbers, source)
    return found


def beside(check: Check, more: Sequence[Finding], flight: Flight) -> Check:
    """The check with further findings about the flight; those that its user accepted are marked so."""
    if not more:
        return check
    findings = marked([*more, *check.findings], accepted_codes(flight))
    rejected = any(f.counts == "reject" for f in findings)
    return replace(check, findings=findings, usable=[] if rejected else check.usable)


def admitted(flight: Flight, check: Check) -> Flight:
    """The flight as it may be used, with what was accepted in its metadata. InputError where the check rejects it."""
    for finding in check.findings:
        if finding.counts == "reject":
            raise InputError(rejection(str(flight.meta.get("source", "flight")), finding))
    return with_accepted(cleaned(flight, check), check.findings)


def rejection(source: str, finding: Finding) -> str:
    """The one line that every command says of a flight that is rejected: what was found, and what to do."""
    remedy = of_log(remedy_of(finding), source)
    remedy = remedy if remedy.startswith("infotraj ") else remedy[0].upper() + remedy[1:]
    return problem(
        f"{source}: {finding.what} ({finding.code})",
        "a flight that passes infotraj check",
        f"{remedy}." if finding.code in NEVER else f"{remedy}; or overrule it: --accept {finding.code}.",
    )


def part(flight: Flight, start: float | None, stop: float | None) -> Flight:
    """The rows with start <= t < stop (s), None for no limit. InputError where there are fewer than two."""
    if start is None and stop is None:
        return flight
    inside = flight.t >= (-float("inf") if start is None else start)
    inside &= flight.t < (float("inf") if stop is None else stop)
    return Flight(flight.table[inside].reset_index(drop=True), dict(flight.meta))
