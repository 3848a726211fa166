"""One door for every command that uses flights: what `check` rejects is refused, what it drops is empty."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace

import pandas as pd

from infotraj.checking.acceptance import ACCEPT, ACCEPTED, accepted_codes, marked, with_accepted
from infotraj.checking.cleaning import cleaned
from infotraj.checking.finding import Finding, usable_spans
from infotraj.checking.identical import content_hash, copy_finding
from infotraj.checking.remembered import remembered
from infotraj.checking.whole import Check, examine
from infotraj.errors import InputError, problem
from infotraj.flight import Flight
from infotraj.vehicle import Vehicle


def checked(
    flights: Sequence[Flight], vehicle: Vehicle, start: float | None = None, stop: float | None = None
) -> list[Check]:
    """The checks of flight tables that are to be used together, in order, copies among them found.

    start, stop: s, the part that is used, and the only one that is looked at. InputError where it holds no rows. What
    was checked before is remembered (see `remembered`).
    """
    return with_copies(flights, [_checked(_part(f, start, stop), vehicle) for f in flights])


def _checked(flight: Flight, vehicle: Vehicle) -> Check:
    accepted = accepted_codes(flight)
    meta = {k: v for k, v in flight.meta.items() if k not in (ACCEPT, ACCEPTED, "source")}
    plain = Flight(flight.table, {**meta, "source": flight.meta.get("source", "flight")})
    rows = pd.util.hash_pandas_object(flight.table, index=False).to_numpy().tobytes()
    content = hashlib.sha256(rows).hexdigest()
    key = (content, list(flight.table.columns), meta, vehicle.model_dump_json())
    check = remembered(key, lambda: examine(plain, vehicle))
    findings = marked(check.findings, accepted)
    usable = usable_spans(check.start, check.stop, findings)
    return replace(check, source=str(flight.meta.get("source", "flight")), findings=findings, usable=usable)


def with_copies(flights: Sequence[Flight], checks: Sequence[Check]) -> list[Check]:
    """The checks, those of copies of an earlier flight with the finding that says so."""
    seen: dict[str, str] = {}
    found = []
    for flight, check in zip(flights, checks, strict=True):
        source, numbers = str(flight.meta.get("source", "flight")), content_hash(flight)
        again = [copy_finding(seen[numbers], same_bytes=False)] if numbers in seen else []
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
    remedy = finding.remedy[0].upper() + finding.remedy[1:].rstrip(".")
    return problem(
        f"{source}: {finding.what} ({finding.code})",
        "a flight that passes infotraj check",
        f"{remedy}; or overrule it: --accept {finding.code}.",
    )


def _part(flight: Flight, start: float | None, stop: float | None) -> Flight:
    if start is None and stop is None:
        return flight
    inside = flight.t >= (-float("inf") if start is None else start)
    inside &= flight.t < (float("inf") if stop is None else stop)
    return Flight(flight.table[inside].reset_index(drop=True), dict(flight.meta))
