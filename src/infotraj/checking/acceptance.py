"""The user's word: findings that are accepted stay visible and are in no one's way.

The word travels with the flight. Its metadata hold `accept`, the codes that are accepted (`--accept` adds to them),
and, once it was checked, `accepted`: what was found and accepted, which every answer names.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from infotraj.checking.codes import known
from infotraj.checking.finding import Finding, ordered
from infotraj.errors import InputError, UsageError, problem
from infotraj.flight import Flight

ACCEPT, ACCEPTED = "accept", "accepted"


def accepting(flight: Flight, codes: Iterable[str]) -> Flight:
    """The flight with these codes accepted beside those that its metadata accept already."""
    every = sorted({*codes, *accepted_codes(flight)})
    return Flight(flight.table, {**flight.meta, ACCEPT: every}) if every else flight


def accepted_codes(flight: Flight) -> frozenset[str]:
    """The codes that the flight's metadata accept. InputError where they hold something else."""
    codes = flight.meta.get(ACCEPT) or []
    source = flight.meta.get("source", "flight")
    if not isinstance(codes, (list, tuple)) or not all(isinstance(c, str) for c in codes):
        raise InputError(problem(f"{source}: accept {codes!r} in the metadata", "a list of codes", "Correct it."))
    try:
        return frozenset(known(codes))
    except UsageError as error:
        raise InputError(f"{source}: accept in the metadata: {error}") from error


def marked(findings: Iterable[Finding], codes: frozenset[str]) -> list[Finding]:
    """The findings in order, the accepted ones marked so."""
    return ordered([replace(f, accepted=True) if f.code in codes else f for f in findings])


def with_accepted(flight: Flight, findings: Iterable[Finding]) -> Flight:
    """The flight whose metadata say which of the findings were accepted."""
    said = [{"code": f.code, "severity": f.severity, "what": f.what} for f in findings if f.accepted]
    return Flight(flight.table, {**flight.meta, ACCEPTED: said}) if said else flight


def accepted_in(flights: Sequence[Flight]) -> list[dict[str, Any]]:
    """What was found in these flights and accepted: path, code, severity, what; for JSON and provenance."""
    return [
        {"path": str(f.meta.get("source", "flight")), **entry} for f in flights for entry in f.meta.get(ACCEPTED, [])
    ]


def accepted_lines(entries: Iterable[dict[str, Any]]) -> list[str]:
    """A line of text for each accepted finding, of one flight or of all."""
    return [f"accepted {e['code']}{' in ' + e['path'] if 'path' in e else ''}: {e['what']}" for e in entries]
